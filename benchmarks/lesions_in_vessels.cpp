// Stenoses put into real vessels, and whether they are found there.
//
//     lesions_in_vessels make SEED COUNT FOLDER CASE...    COUNT surfaces a case, and lesions.csv
//     angio run FOLDER/NAME.vtp -o FOLDER/cases/NAME --until centerline        for each of them
//     lesions_in_vessels table FOLDER [each] [--markdown FILE]
//
// CASE is a folder of `angio run SURFACE --until centerline`. Of its lumen the sections around
// random places of its lines are drawn together, up to three on a surface, so the truth is known in
// a shape that no one made: a diameter stenosis of 40 to 90 % that leaves 0.5 mm or more, 2 to 5
// diameters long from shoulder to shoulder, from all sides or from one. A place is fit if the
// vessel is 1.5 mm or more wide there, even over two diameters to both sides, a diameter from a
// branching and three from an end, and no narrowing was listed near it. Nothing of the program is
// set for it.
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
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

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

/// A stenosis that was put into a vessel.
struct Narrowing {
  std::string surface;  ///< its name
  Vec3 place;           ///< its tightest place on the line [mm]
  double diameter_mm = 0.0, percent = 0.0, length_mm = 0.0;
  double eccentricity = 0.0;  ///< 0: from all sides; 1: the wall stays on one side
};

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

// ---- where a stenosis can be put ---------------------------------------------------------------

struct Place {
  std::size_t path = 0, point = 0;
  double weight = 0.0;  ///< diameters of vessel that it stands for
};

bool is_blanked(const CenterlinePath& path, std::size_t point) {
  return std::any_of(path.tracts.begin(), path.tracts.end(), [&](const CenterlineTract& tract) {
    return tract.blanking && tract.first_point <= int(point) && int(point) <= tract.last_point;
  });
}

bool is_fit(const CenterlinePath& path, std::size_t point, const std::vector<Listed>& listed) {
  constexpr double kLeast = 1.5, kUneven = 1.25;            // mm; ratio
  constexpr double kEven = 2.0, kBranch = 1.0, kEnd = 3.0;  // diameters
  const std::vector<double>&s = path.abscissa, &radius = measured_radius(path);
  const double diameter = 2.0 * radius[point];
  if (diameter < kLeast || std::min(s[point], s.back() - s[point]) < kEnd * diameter) return false;
  if (nearest(listed, path.points[point]) < kEnd * diameter) return false;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double away = std::abs(s[i] - s[point]);
    const double ratio = radius[i] / radius[point];
    if (away < kBranch * diameter && is_blanked(path, i)) return false;
    if (away < kEven * diameter && (ratio > kUneven || ratio < 1.0 / kUneven)) return false;
  }
  return true;
}

/// Each fit place once, though several lines run through it.
std::vector<Place> fit_places(const CenterlineTree& lines, const std::vector<Listed>& listed) {
  std::vector<Place> places;
  std::vector<Vec3> known;
  for (std::size_t p = 0; p < lines.paths.size(); ++p) {
    const CenterlinePath& path = lines.paths[p];
    for (std::size_t i = 1; i < path.points.size(); ++i) {
      const bool is_known = std::any_of(known.begin(), known.end(),
                                        [&](const Vec3& other) { return other == path.points[i]; });
      if (is_known) continue;
      known.push_back(path.points[i]);
      if (!is_fit(path, i, listed)) continue;
      const double step = path.abscissa[i] - path.abscissa[i - 1];
      places.push_back({p, i, 0.5 * step / measured_radius(path)[i]});
    }
  }
  return places;
}

// ---- how it is put there -----------------------------------------------------------------------

/// The place of the lines that a vertex belongs to: the one whose ball it is nearest to.
struct Owner {
  const CenterlinePath* path = nullptr;
  std::size_t point = 0;
};

std::vector<Owner> owners(const TriangleMesh& surface, const CenterlineTree& lines) {
  std::vector<Owner> result(surface.vertices.size());
#pragma omp parallel for
  for (std::size_t v = 0; v < result.size(); ++v) {
    double least = std::numeric_limits<double>::max();
    for (const CenterlinePath& path : lines.paths)
      for (std::size_t i = 0; i < path.points.size(); ++i) {
        const double off = distance(surface.vertices[v], path.points[i]) - path.inscribed_radius[i];
        if (off >= least) continue;
        least = off;
        result[v] = {&path, i};
      }
  }
  return result;
}

/// Draws the sections around a place together, by 1 - percent cos^2; false, and the surface is as
/// it was, if a part of them is another line's or too few vertices are there to show a throat.
bool narrow(TriangleMesh& surface, const std::vector<Owner>& owner, const CenterlineTree& lines,
            const Place& place, const Narrowing& narrowing, double angle) {
  const CenterlinePath& path = lines.paths[place.path];
  const double middle = path.abscissa[place.point], half = 0.5 * narrowing.length_mm;
  const Vec3 tangent = sample(path, middle).tangent;
  const Vec3 across = any_perpendicular(tangent), other = cross(tangent, across);
  const Vec3 aside = std::cos(angle) * across + std::sin(angle) * other;
  constexpr double kTight = 0.75;  // of the depth: where the throat is,
  constexpr int kSeen = 24;        // and how many vertices show it
  int seen = 0;
  TriangleMesh narrowed = surface;
  for (std::size_t v = 0; v < narrowed.vertices.size(); ++v) {
    Vec3& vertex = narrowed.vertices[v];
    if (distance(vertex, path.points[place.point]) > half + 2.0 * narrowing.diameter_mm) continue;
    const double s = project(path, vertex);
    if (std::abs(s - middle) >= half) continue;
    const CenterlineSample on_line = sample(path, s);
    const double away = distance(vertex, on_line.point);
    if (away > 2.0 * on_line.inscribed_radius) continue;
    const auto& [owning, point] = owner[v];  // lines share their points from the inlet on
    if (point >= path.points.size() || !(owning->points[point] == path.points[point])) return false;
    const double c = std::cos(0.5 * std::numbers::pi * (s - middle) / half);
    const double depth = 0.01 * narrowing.percent * c * c;
    const Vec3 towards = on_line.point + narrowing.eccentricity * on_line.inscribed_radius * aside;
    vertex = vertex + depth * (towards - vertex);
    if (c * c > kTight) ++seen;
  }
  if (seen < kSeen) return false;
  surface = narrowed;
  return true;
}

struct Random {
  std::mt19937_64 engine;
  double uniform(double low, double high) {  // the same with any library
    return low + (high - low) * (double(engine() >> 11U) + 0.5) * 0x1p-53;
  }
};

std::vector<Narrowing> narrow_some(TriangleMesh& surface, const CenterlineTree& lines,
                                   const std::vector<Place>& places, const std::string& name,
                                   Random& random) {
  constexpr int kMost = 3, kTries = 30;
  constexpr double kApart = 8.0;   // diameters
  constexpr double kThroat = 0.5;  // mm: what a balloon crosses, and a scan might show
  const std::vector<Owner> owner = owners(surface, lines);
  double whole = 0.0;
  for (const Place& place : places) whole += place.weight;
  std::vector<Narrowing> put;
  for (int n = 0; n < kTries && int(put.size()) < kMost; ++n) {
    double at = random.uniform(0.0, whole);
    std::size_t k = 0;
    while (k + 1 < places.size() && (at -= places[k].weight) > 0.0) ++k;
    const CenterlinePath& path = lines.paths[places[k].path];
    Narrowing narrowing;
    narrowing.surface = name;
    narrowing.place = path.points[places[k].point];
    narrowing.diameter_mm = 2.0 * measured_radius(path)[places[k].point];
    narrowing.percent =
        random.uniform(40.0, std::min(90.0, 100.0 * (1.0 - kThroat / narrowing.diameter_mm)));
    narrowing.length_mm = narrowing.diameter_mm * random.uniform(2.0, 5.0);
    narrowing.eccentricity = random.uniform(0.0, 1.0);
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const bool is_apart = std::all_of(put.begin(), put.end(), [&](const Narrowing& other) {
      return distance(other.place, narrowing.place) >
             kApart * std::max(other.diameter_mm, narrowing.diameter_mm);
    });
    if (is_apart && narrow(surface, owner, lines, places[k], narrowing, angle))
      put.push_back(narrowing);
  }
  return put;
}

void make(std::uint64_t seed, int count, const fs::path& folder,
          const std::vector<fs::path>& cases) {
  fs::create_directories(folder);
  std::string list = "surface,case,x_mm,y_mm,z_mm,diameter_mm,percent,length_mm,eccentricity\n";
  for (const fs::path& given : cases) {
    const CenterlineTree lines = lines_of(given);
    const std::vector<Place> places = fit_places(lines, listed_in(given, lines));
    if (places.empty()) continue;
    const TriangleMesh lumen = formats::read_surface(given / formats::case_file::kGivenLumen).mesh;
    for (int n = 1; n <= count; ++n) {
      Random random{std::mt19937_64(1000 * seed + std::uint64_t(n))};
      TriangleMesh surface = lumen;
      const std::string name = formatted("%s-%d", given.filename().c_str(), n);
      const std::vector<Narrowing> put = narrow_some(surface, lines, places, name, random);
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
    surface.there.push_back({rows[r][0],
                             {number(2), number(3), number(4)},
                             number(5),
                             number(6),
                             number(7),
                             number(8)});
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
                                     "diffuse disease"};
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

void table(const fs::path& folder, bool each, ResultTable& results) {
  std::vector<Outcome> outcomes;
  std::string wrong;
  std::size_t ran = 0, false_ones = 0, not_run = 0;
  std::map<fs::path, bool> cases;
  for (const auto& [name, surface] : read_list(folder / "lesions.csv")) {
    const fs::path run = folder / "cases" / name;
    if (!fs::exists(run / "centerline/lesions.json")) {
      ++not_run;
      if (each) std::cout << name << ": not run\n";
      continue;
    }
    ++ran;
    cases[surface.given] = true;
    const CenterlineTree lines = lines_of(run);
    const CenterlineTree lines_before = lines_of(surface.given);
    const std::vector<Listed> before = listed_in(surface.given, lines_before);
    const std::vector<Listed> listed = listed_in(run, lines);
    std::vector<bool> is_explained(listed.size(), false);
    for (const Narrowing& there : surface.there) {
      Outcome outcome{there, {}, {}};
      for (std::size_t k = 0; k < listed.size(); ++k) {
        if (!listed[k].holds(there.place)) continue;
        is_explained[k] = true;
        outcome.percent = std::max(outcome.percent.value_or(0.0), listed[k].percent);
      }
      const Reason reason =
          outcome.percent ? Reason{} : reason_for(lines, given_surface(run), there);
      outcome.told = reason.word;
      if (each && (!outcome.percent || std::abs(*outcome.percent - there.percent) > 10.0))
        std::cout << formatted("%s at %.1f %.1f %.1f: %.0f %% of %.2f mm, %.1f mm long: ",
                               name.c_str(), there.place.x, there.place.y, there.place.z,
                               there.percent, there.diameter_mm, there.length_mm)
                  << (outcome.percent ? formatted("%.0f %%", *outcome.percent)
                      : reason.word.empty()
                          ? std::string("nothing")
                          : formatted("told, %.0f %%: ", reason.percent) + reason.word)
                  << '\n';
      outcomes.push_back(outcome);
    }
    for (std::size_t k = 0; k < listed.size(); ++k) {
      if (is_explained[k] || nearest(before, listed[k].place) < 3.0 * listed[k].reference_mm)
        continue;
      ++false_ones;
      if (each)
        std::cout << formatted("%s: false %.0f %% of %.2f mm at %.1f %.1f %.1f\n", name.c_str(),
                               listed[k].percent, listed[k].reference_mm, listed[k].place.x,
                               listed[k].place.y, listed[k].place.z);
    }
  }
  results.paragraph(
      formatted("%zu stenoses in %zu surfaces of %zu vessels; %zu more surfaces were not run. %zu "
                "false (%.3f a "
                "surface).",
                outcomes.size(), ran, cases.size(), not_run, false_ones,
                ran > 0 ? double(false_ones) / double(ran) : 0.0));
  results.columns(
      {"true stenosis", "there", "listed %", "only told", "%DS bias", "sd", "95 % of errors"});
  const auto row = [&](const std::string& name, const auto& wanted) {
    std::vector<const Outcome*> those;
    for (const Outcome& outcome : outcomes)
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
}

int run(int argc, char** argv) {
  ResultTable results("Stenoses put into real vessels", argc, argv);
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() >= 5 && words[0] == "make") {
    make(std::strtoull(words[1].c_str(), nullptr, 10), std::atoi(words[2].c_str()), words[3],
         {words.begin() + 4, words.end()});
    return 0;
  }
  const bool each = words.size() == 3 && words[2] == "each";
  if (words.empty() || words[0] != "table" || (words.size() != 2 && !each)) {
    std::cerr << "usage: lesions_in_vessels make SEED COUNT FOLDER CASE... | table FOLDER [each] "
                 "[--markdown FILE]\n";
    return int(ExitCode::usage);
  }
  table(words[1], each, results);
  results.write();
  return 0;
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argc, char** argv) {
  try {
    return angio::benchmarks::run(argc, argv);
  } catch (const angio::Error& e) {
    std::cerr << "error: " << e.what() << '\n';
    return static_cast<int>(e.exit_code());
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what() << '\n';
    return 65;
  }
}
