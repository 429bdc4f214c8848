// The numbers of case folders, a row a case: what was treated, how the simulation fared, how long
// the stages took.
//
//     case_table [--curves] CASE... [--markdown FILE]
//
// --curves: also the position corrections of friction and adhesion over time, as
// docs/experiments.md compares them with the seed paper. Exit codes: 0 done, 64 usage, 65 a folder
// is no case.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "testing/result_table.hpp"

namespace angio::benchmarks {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kStages[] = {"segmentation", "centerline", "meshing", "simulation", "report"};

struct Case {
  std::string name;
  json metrics, run;
  fs::path folder;
};

json read_json(const fs::path& file) {
  if (!fs::exists(file))
    throw InputError("there is no " + file.filename().string() +
                     ". Name folders that angio run has made");
  return json::parse(read_text(file));
}

Case read_case(const fs::path& given) {
  const fs::path folder = fs::absolute(given / ".").parent_path();
  return {folder.filename().string(), read_json(folder / "metrics.json"),
          read_json(folder / "run.json"), folder};
}

/// A number of metrics.json, by "part/name"; empty where it does not apply.
std::string number(const Case& c, const std::string& key, const char* format) {
  const json::json_pointer pointer("/" + key);
  if (!c.metrics.contains(pointer) || !c.metrics.at(pointer).is_number()) return "";
  return formatted(format, c.metrics.at(pointer).get<double>());
}

void add_treatments(const std::vector<Case>& cases, ResultTable& results) {
  results.section("Before and after");
  results.columns({"case", "status", "stenosis before %", "MLD before mm", "balloon at peak mm",
                   "MLD after mm", "along the whole balloon mm", "stenosis after %", "recoil %"});
  for (const Case& c : cases) {
    const json status = c.metrics.value("status", json());
    results.row({c.name, status.is_string() ? status.get<std::string>() : "",
                 number(c, "lesion/diameter_stenosis_percent", "%.0f"),
                 number(c, "lesion/mld_mm", "%.3f"), number(c, "balloon/peak_diameter_mm", "%.3f"),
                 number(c, "result/mld_mm", "%.3f"), number(c, "result/segment_mld_mm", "%.3f"),
                 number(c, "result/diameter_stenosis_percent", "%.0f"),
                 number(c, "result/recoil_percent", "%.0f")});
  }
}

void add_simulations(const std::vector<Case>& cases, ResultTable& results) {
  results.section("The simulation");
  results.columns({"case", "frames", "without a whole air mesh", "flips", "air meshes rebuilt",
                   "inverted tets", "greatest penetration mm", "worst residual", "frames/s"});
  for (const Case& c : cases)
    results.row({c.name, number(c, "simulation/frame_count", "%.0f"),
                 number(c, "simulation/frames_without_air", "%.0f"),
                 number(c, "simulation/air_flips", "%.0f"),
                 number(c, "simulation/air_rebuilds", "%.0f"),
                 number(c, "simulation/inverted_air_tets", "%.0f"),
                 number(c, "simulation/max_penetration_mm", "%.4g"),
                 number(c, "simulation/worst_residual", "%.3f"),
                 number(c, "simulation/frames_per_second", "%.1f")});
}

void add_meshes_and_times(const std::vector<Case>& cases, ResultTable& results) {
  results.section("Meshes, seconds of each stage, memory");
  results.columns({"case", "lumen triangles", "tets", "least dihedral angle", "segmentation s",
                   "centerline s", "meshing s", "simulation s", "report s", "peak memory MiB"});
  for (const Case& c : cases) {
    std::vector<std::string> row{c.name, number(c, "mesh/lumen_triangles", "%.0f"),
                                 number(c, "mesh/tets", "%.0f"),
                                 number(c, "mesh/min_dihedral_degrees", "%.1f")};
    double memory = 0.0;
    for (const char* stage : kStages) {
      const json record = c.run.value("stages", json::object()).value(stage, json::object());
      const bool was_run = record.value("status", std::string()) == "done";
      row.push_back(was_run ? formatted("%.1f", record.value("seconds", 0.0)) : "");
      memory = std::max(memory, record.value("peak_memory_mib", 0.0));
    }
    row.push_back(formatted("%.0f", memory));
    results.row(row);
  }
}

struct Series {
  std::vector<double> time, friction, adhesion;
  std::vector<std::string> phase;
};

Series read_series(const fs::path& folder) {
  const auto rows = formats::parse_csv(read_text(folder / "simulation/timeseries.csv"));
  std::map<std::string, std::size_t> column;
  for (std::size_t k = 0; k < rows.at(0).size(); ++k) column[rows[0][k]] = k;
  Series series;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    series.time.push_back(std::stod(rows[r].at(column.at("time_s"))));
    series.friction.push_back(std::stod(rows[r].at(column.at("friction_delta_mm"))));
    series.adhesion.push_back(std::stod(rows[r].at(column.at("viscous_delta_mm"))));
    series.phase.push_back(rows[r].at(column.at("phase")));
  }
  return series;
}

std::size_t first_of(const Series& series, const char* phase) {
  return std::size_t(std::find(series.phase.begin(), series.phase.end(), phase) -
                     series.phase.begin());
}

void add_curves(const std::vector<Case>& cases, ResultTable& results) {
  constexpr double kFaded = 0.02;  // of the peak
  results.section("Position corrections of friction and adhesion");
  results.columns({"case", "friction, peak mm", "at s", "deflation begins s",
                   "friction below 2 % of its peak from s", "adhesion as the deflation begins mm",
                   "adhesion, peak mm", "at s", "adhesion at the end mm"});
  for (const Case& c : cases) {
    if (!fs::exists(c.folder / "simulation/timeseries.csv")) continue;
    const Series s = read_series(c.folder);
    const auto peak_of = [](const std::vector<double>& values) {
      return std::size_t(std::max_element(values.begin(), values.end()) - values.begin());
    };
    const std::size_t friction = peak_of(s.friction), adhesion = peak_of(s.adhesion),
                      deflation = std::min(first_of(s, "deflate"), s.time.size() - 1);
    std::size_t faded = s.time.size();
    while (faded > 0 && s.friction[faded - 1] < kFaded * s.friction[friction]) --faded;
    results.row({c.name, formatted("%.3f", s.friction[friction]),
                 formatted("%.2f", s.time[friction]), formatted("%.2f", s.time[deflation]),
                 faded < s.time.size() ? formatted("%.2f", s.time[faded]) : "",
                 formatted("%.4f", s.adhesion[deflation]), formatted("%.4f", s.adhesion[adhesion]),
                 formatted("%.2f", s.time[adhesion]), formatted("%.4f", s.adhesion.back())});
  }
}

int run(int argument_count, char** arguments) {
  ResultTable results("Cases as `angio run` leaves them", argument_count, arguments);
  bool with_curves = false;
  std::vector<Case> cases;
  for (int i = 1; i < argument_count; ++i) {
    const std::string word = arguments[i];
    if (word == "--curves")
      with_curves = true;
    else
      cases.push_back(read_case(word));
  }
  if (cases.empty()) {
    fmt::print(stderr, "usage: case_table [--curves] CASE... [--markdown FILE]\n");
    return int(ExitCode::usage);
  }
  add_treatments(cases, results);
  add_simulations(cases, results);
  add_meshes_and_times(cases, results);
  if (with_curves) add_curves(cases, results);
  results.write();
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argument_count, char** arguments) {
  return angio::benchmarks::run_benchmark("case_table", argument_count, arguments,
                                          angio::benchmarks::run);
}
