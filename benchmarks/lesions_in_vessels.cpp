// Stenoses put into real vessels, and whether they are found there.
//
//     lesions_in_vessels make SEED COUNT FOLDER CASE...    COUNT surfaces a case, and lesions.csv
//     lesions_in_vessels make-beside SEED COUNT FOLDER CASE...
//     angio run FOLDER/NAME.vtp -o FOLDER/cases/NAME --until centerline        for each of them
//     lesions_in_vessels table FOLDER [each] [--markdown FILE]
//
// CASE is a folder of `angio run SURFACE --until centerline`. Of its lumen the sections around
// random places of its lines are drawn together, up to three on a surface, so the truth is known in
// a shape that no one made: a diameter stenosis of 40 to 90 % that leaves 0.5 mm or more, from all
// sides or from one. A place is fit if the vessel is 1.5 mm or more wide there, three diameters
// from an end, and no narrowing was listed near it. `make` puts them where the vessel is even over
// two diameters to both sides, a diameter from a branching, 2 to 5 diameters long from shoulder to
// shoulder; `make-beside` nearer to a branching, and 0.75 to 2 diameters long, as coarctations and
// ostial stenoses are. Nothing of the program is set for them.
//
// Listed: a listed stenosis holds the place. Only told: the program says that a narrowing is there,
// and why it is not listed. False: a listed one that holds none, and was not listed before.
// Exit codes: 0 done, 64 usage, 65 a file is not what make and run have written.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "benchmarks/vessel_narrowing.hpp"
#include "centerline/centerline.hpp"
#include "centerline/resolution.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/statistics.hpp"
#include "formats/case_file.hpp"
#include "formats/csv.hpp"
#include "formats/files.hpp"
#include "pipeline/case/case_files.hpp"
#include "testing/result_table.hpp"

namespace angio::benchmarks {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

/// A listed stenosis, of lesions.json.
struct Listed {
  Vec3 place;
  double percent = 0.0, reference_mm = 0.0;
  const CenterlinePath* path = nullptr;
  double begin = 0.0, end = 0.0;  ///< abscissas of its edges [mm]

  /// Whether a place of the vessel lies between its edges.
  [[nodiscard]] bool holds(const Vec3& there) const {
    const double s = project(*path, there);
    return begin <= s && s <= end && distance(sample(*path, s).point, there) < 0.5 * reference_mm;
  }
};

CenterlineTree lines_of(const fs::path& folder) {
  return pipeline::read_centerlines(folder / "centerline/centerlines.vtp");
}

TriangleMesh given_surface(const fs::path& folder) {
  return formats::read_surface(folder / formats::case_file::kGivenLumen).mesh;
}

std::vector<Listed> listed_in(const fs::path& folder, const CenterlineTree& lines) {
  std::vector<Listed> listed;
  for (const json& lesion : json::parse(read_text(folder / "centerline/lesions.json"))) {
    const double percent = lesion.at("diameter_stenosis_percent");
    if (!(lesion.at("length_mm").get<double>() > 0.0)) continue;  // the place of a trial
    const CenterlinePath& path = pipeline::path_of(lines, lesion.at("centerline_id"));
    listed.push_back({sample(path, lesion.at("abscissa_mm")).point, percent,
                      lesion.at("reference_diameter_mm"), &path, lesion.at("proximal_mm"),
                      lesion.at("distal_mm")});
  }
  return listed;
}

double nearest(const std::vector<Listed>& listed, const Vec3& place) {
  double least = std::numeric_limits<double>::max();
  for (const Listed& lesion : listed) least = std::min(least, distance(lesion.place, place));
  return least;
}

/// The folder's own name, also where a slash ends its path.
std::string name_of(const fs::path& folder) {
  return folder.has_filename() ? folder.filename().string()
                               : folder.parent_path().filename().string();
}

void make(Site site, std::uint64_t seed, int count, const fs::path& folder,
          const std::vector<fs::path>& cases) {
  fs::create_directories(folder);
  std::string list = "surface,case,x_mm,y_mm,z_mm,diameter_mm,percent,length_mm,eccentricity\n";
  std::size_t number = 0;
  for (const fs::path& given : cases) {
    ++number;
    const CenterlineTree lines = lines_of(given);
    const TriangleMesh lumen = given_surface(given);
    std::vector<Vec3> taken;
    for (const Listed& listed : listed_in(given, lines)) taken.push_back(listed.place);
    for (int n = 1; n <= count; ++n) {
      std::seed_seq numbers{seed, std::uint64_t(number), std::uint64_t(n)};
      TriangleMesh surface = lumen;
      const std::string name = formatted("%zu-%s-%d", number, name_of(given).c_str(), n);
      const std::vector<Narrowing> put =
          narrow_vessels(surface, lines, taken, site, std::mt19937_64(numbers));
      if (put.empty()) continue;
      formats::write_surface(folder / (name + ".vtp"), {surface, {}, {}});
      for (const Narrowing& one : put)
        list += formatted("%s,%s,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", name.c_str(),
                          fs::absolute(given).c_str(), one.place.x, one.place.y, one.place.z,
                          one.diameter_mm, one.percent, one.length_mm, one.eccentricity);
    }
  }
  write_text_atomically(folder / "lesions.csv", list);
}

// ---- what came of it ---------------------------------------------------------------------------

struct Surface {
  fs::path given;  ///< the case without the stenoses
  std::vector<Narrowing> there;
};

std::map<std::string, Surface> read_list(const fs::path& file) {
  std::map<std::string, Surface> surfaces;
  const auto rows = formats::parse_csv(read_text(file));
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() != 9) throw InputError(file.filename().string() + " was not made by make");
    const auto number = [&](std::size_t column) { return std::atof(rows[r][column].c_str()); };
    Surface& surface = surfaces[rows[r][0]];
    surface.given = rows[r][1];
    surface.there.push_back(
        {{number(2), number(3), number(4)}, number(5), number(6), number(7), number(8)});
  }
  return surfaces;
}

struct Outcome {
  Narrowing there;
  std::optional<double> percent;  ///< as listed; none: not listed
  std::string told;               ///< why not, where the program says that something is there
};

/// Why a place is not listed.
struct Reason {
  std::string word;  ///< empty: nothing was seen there
  double percent = 0.0;
};

Reason reason_for(const CenterlineTree& lines, const TriangleMesh& surface,
                  const Narrowing& there) {
  constexpr const char* kDoubts[] = {"",
                                     "a vessel that is thin there by itself",
                                     "a large tree",
                                     "beside no tube",
                                     "beyond a heart",
                                     "at a beginning",
                                     "at an end",
                                     "one of a string of beads",
                                     "a bridge",
                                     "diffuse disease",
                                     "beyond an aneurysm",
                                     "wider sides",
                                     "not the same blood"};
  const centerline::LesionOptions options =
      centerline::lesion_options({}, centerline::resolution_of_surface(surface));
  for (const centerline::Lesion& lesion : centerline::find_lesions(lines, options)) {
    if (!lesion.is_left_out()) continue;
    const CenterlinePath& path = pipeline::path_of(lines, lesion.path_id);
    if (distance(sample(path, lesion.abscissa_mm).point, there.place) > there.length_mm) continue;
    return {lesion.is_too_thin ? "too coarse a surface" : kDoubts[int(lesion.doubt)],
            lesion.diameter_stenosis_percent};
  }
  return {};
}

void add_row(const std::string& name, const std::vector<const Outcome*>& those,
             ResultTable& results) {
  std::vector<double> errors, sizes;
  double sum = 0.0, squares = 0.0;
  for (const Outcome* outcome : those) {
    if (!outcome->percent) continue;
    const double error = *outcome->percent - outcome->there.percent;
    errors.push_back(error);
    sizes.push_back(std::abs(error));
    sum += error;
    squares += error * error;
  }
  const double n = double(errors.size()), mean = n > 0.0 ? sum / n : NAN;
  const auto told = std::count_if(those.begin(), those.end(),
                                  [](const Outcome* outcome) { return !outcome->told.empty(); });
  const double sd = n > 1.0 ? std::sqrt((squares - n * mean * mean) / (n - 1.0)) : NAN;
  const double found = those.empty() ? NAN : 100.0 * n / double(those.size());
  results.row({name, std::to_string(those.size()), formatted("%.1f", found), std::to_string(told),
               formatted("%+.1f", mean), formatted("%.1f", sd),
               formatted("%.1f", quantile(sizes, 0.95, double(NAN)))});
}

/// What came of all surfaces.
struct Tally {
  std::vector<Outcome> outcomes;
  std::set<fs::path> vessels;
  std::size_t ran = 0, false_ones = 0, not_run = 0;
};

void say(const std::string& name, const Outcome& outcome, const Reason& reason) {
  const Narrowing& there = outcome.there;
  const std::string answer = outcome.percent ? formatted("%.0f %%", *outcome.percent)
                             : reason.word.empty()
                                 ? std::string("nothing")
                                 : formatted("told, %.0f %%: ", reason.percent) + reason.word;
  std::cout << formatted("%s at %.1f %.1f %.1f: %.0f %% of %.2f mm, %.1f mm long: ", name.c_str(),
                         there.place.x, there.place.y, there.place.z, there.percent,
                         there.diameter_mm, there.length_mm)
            << answer << '\n';
}

/// Holds what is listed in a surface against what was put there.
void judge(const std::string& name, const Surface& surface, const fs::path& run, bool each,
           Tally& tally) {
  const CenterlineTree lines = lines_of(run), lines_before = lines_of(surface.given);
  const std::vector<Listed> before = listed_in(surface.given, lines_before);
  const std::vector<Listed> listed = listed_in(run, lines);
  const TriangleMesh wall = given_surface(run);
  std::vector<bool> is_explained(listed.size(), false);
  for (const Narrowing& there : surface.there) {
    Outcome outcome{there, {}, {}};
    for (std::size_t k = 0; k < listed.size(); ++k) {
      if (!listed[k].holds(there.place)) continue;
      is_explained[k] = true;
      outcome.percent = std::max(outcome.percent.value_or(0.0), listed[k].percent);
    }
    const Reason reason = outcome.percent ? Reason{} : reason_for(lines, wall, there);
    outcome.told = reason.word;
    if (each && (!outcome.percent || std::abs(*outcome.percent - there.percent) > 10.0))
      say(name, outcome, reason);
    tally.outcomes.push_back(outcome);
  }
  for (std::size_t k = 0; k < listed.size(); ++k) {
    const Vec3& place = listed[k].place;
    if (is_explained[k] || nearest(before, place) < 3.0 * listed[k].reference_mm) continue;
    ++tally.false_ones;
    if (each)
      std::cout << formatted("%s: false %.0f %% of %.2f mm at %.1f %.1f %.1f\n", name.c_str(),
                             listed[k].percent, listed[k].reference_mm, place.x, place.y, place.z);
  }
}

void show(const Tally& tally, ResultTable& results) {
  const double ran = double(tally.ran);
  results.paragraph(formatted(
      "%zu stenoses in %zu surfaces of %zu vessels; %zu more surfaces were not run. %zu false "
      "(%.3f a surface).",
      tally.outcomes.size(), tally.ran, tally.vessels.size(), tally.not_run, tally.false_ones,
      tally.ran > 0 ? double(tally.false_ones) / ran : 0.0));
  results.columns(
      {"true stenosis", "there", "listed %", "only told", "%DS bias", "sd", "95 % of errors"});
  const auto row = [&](const std::string& name, const auto& wanted) {
    std::vector<const Outcome*> those;
    for (const Outcome& outcome : tally.outcomes)
      if (wanted(outcome.there)) those.push_back(&outcome);
    add_row(name, those, results);
  };
  row("40 to 50 %", [](const Narrowing& n) { return n.percent < 50.0; });
  row("50 to 70 %", [](const Narrowing& n) { return n.percent >= 50.0 && n.percent < 70.0; });
  row("70 to 90 %", [](const Narrowing& n) { return n.percent >= 70.0; });
  row("**50 to 90 %**", [](const Narrowing& n) { return n.percent >= 50.0; });
  row("of them, vessels under 2.5 mm",
      [](const Narrowing& n) { return n.percent >= 50.0 && n.diameter_mm < 2.5; });
  row("from one side (over half)",
      [](const Narrowing& n) { return n.percent >= 50.0 && n.eccentricity > 0.5; });
  std::map<std::string, int> reasons;
  for (const Outcome& outcome : tally.outcomes)
    if (!outcome.percent) ++reasons[outcome.told.empty() ? "not told" : outcome.told];
  results.section("Why the others are not listed");
  results.columns({"reason", "stenoses"});
  for (const auto& [reason, count] : reasons) results.row({reason, std::to_string(count)});
}

void table(const fs::path& folder, bool each, ResultTable& results) {
  Tally tally;
  for (const auto& [name, surface] : read_list(folder / "lesions.csv")) {
    const fs::path run = folder / "cases" / name;
    if (!fs::exists(run / "centerline/lesions.json")) {
      ++tally.not_run;
      if (each) std::cout << name << ": not run\n";
      continue;
    }
    ++tally.ran;
    tally.vessels.insert(surface.given);
    judge(name, surface, run, each, tally);
  }
  show(tally, results);
}

int run(int argc, char** argv) {
  ResultTable results("Stenoses put into real vessels", argc, argv);
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() >= 5 && (words[0] == "make" || words[0] == "make-beside")) {
    make(words[0] == "make" ? Site::even : Site::beside,
         std::strtoull(words[1].c_str(), nullptr, 10), std::atoi(words[2].c_str()), words[3],
         {words.begin() + 4, words.end()});
    return 0;
  }
  const bool each = words.size() == 3 && words[2] == "each";
  if (words.empty() || words[0] != "table" || (words.size() != 2 && !each)) {
    std::cerr << "usage: lesions_in_vessels make|make-beside SEED COUNT FOLDER CASE... | table "
                 "FOLDER [each] [--markdown FILE]\n";
    return int(ExitCode::usage);
  }
  table(words[1], each, results);
  results.write();
  return 0;
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argument_count, char** arguments) {
  return angio::benchmarks::run_benchmark("lesions_in_vessels", argument_count, arguments,
                                          angio::benchmarks::run);
}
