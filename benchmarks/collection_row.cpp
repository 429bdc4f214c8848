#include "benchmarks/collection_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/statistics.hpp"
#include "formats/csv.hpp"
#include "pipeline/case/case_files.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/pipeline/line_measure.hpp"

namespace angio {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kRadiusBarPercent = 2.0, kAirBarPercent = 95.0, kSecondsBar = 300.0;

json read_json(const fs::path& file) {
  if (!fs::exists(file)) return json::object();
  const json parsed = json::parse(read_text(file), nullptr, false);
  return parsed.is_object() ? parsed : json::object();
}

/// metrics.json's status; where there is none, the stage that failed or the last one that ran.
std::string status_of(const fs::path& folder, int exit_code) {
  constexpr int kTimeLimit = 124, kKilled = 137;  // of timeout(1)
  if (exit_code == kTimeLimit || exit_code == kKilled) return "out of time";
  const json metrics = read_json(folder / "metrics.json");
  if (metrics.contains("status") && metrics.at("status").is_string())
    return metrics.at("status").get<std::string>();
  const json run = read_json(folder / "run.json");
  std::string reached;
  for (const char* stage : {"segmentation", "centerline", "meshing", "simulation", "report"}) {
    const std::string pointer = std::string("/stages/") + stage + "/status";
    const std::string status = run.value(json::json_pointer(pointer), std::string());
    if (status == "failed") return std::string(stage) + " failed";
    if (status == "done" || status == "given") reached = stage;
  }
  if (reached.empty()) return "refused";
  return reached == "report" ? "done" : "until " + reached;
}

RowLines measure(const CenterlineTree& tree, const fs::path& folder) {
  const LineMeasure found = measure_lines(tree, folder);
  RowLines lines;
  lines.count = int(tree.paths.size());
  lines.points = found.points;
  lines.outside = found.outside;
  lines.sharp_steps = found.sharp_steps;
  lines.sharp_turns = found.sharp_radii;
  lines.inside_percent = found.inside_percent();
  lines.radius_error_95_percent = 100.0 * quantile(found.radius_errors, 0.95, 0.0);
  lines.radius_off_percent = found.radius_off_percent();
  lines.too_long_percent = found.too_long;
  return lines;
}

/// From the time series, which a simulation that failed leaves, too.
std::optional<RowSimulation> measure_simulation(const fs::path& time_series) {
  if (!fs::exists(time_series)) return std::nullopt;
  const std::vector<formats::CsvRow> rows = formats::parse_csv(read_text(time_series));
  if (rows.size() < 2) return std::nullopt;
  const auto column = [&](const char* name) {
    return std::size_t(std::find(rows[0].begin(), rows[0].end(), name) - rows[0].begin());
  };
  const std::size_t depth = column("max_penetration_mm"), air = column("air_tet_count");
  RowSimulation simulation;
  int with_air = 0;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (std::max(depth, air) >= rows[r].size()) continue;
    const double penetration = std::stod(rows[r][depth]);
    ++simulation.frames;
    simulation.crossing_frames += penetration > 0.0 ? 1 : 0;
    simulation.max_penetration_mm = std::max(simulation.max_penetration_mm, penetration);
    with_air += std::stod(rows[r][air]) > 0.0 ? 1 : 0;
  }
  simulation.air_percent = 100.0 * with_air / std::max(1, simulation.frames);
  return simulation;
}

std::string bold_if(bool misses, const std::string& text) {
  return misses ? "**" + text + "**" : text;
}

std::string ends_text(const CollectionRow& row) {
  if (!row.ends_read) return fmt::format("- ({})", row.ends_of_lines);
  return bold_if(
             row.ends_found < *row.ends_read,
             fmt::format("{}{}/{}", row.ends_by_place ? "" : "~", row.ends_found, *row.ends_read)) +
         fmt::format(" ({})", row.ends_of_lines);
}

/// "8 of 9 (88.9 %)"
std::string share(int part, int whole) {
  return whole == 0 ? "none to count"
                    : fmt::format("{} of {} ({:.1f} %)", part, whole, 100.0 * part / whole);
}

/// Sums over lines.
struct LineTotals {
  int cases = 0, points = 0, outside = 0, inside_all = 0, turns = 0, smooth = 0, radius_good = 0;
};

/// Sums over what a person has read.
struct ReadingTotals {
  int ends = 0, ends_found = 0, inlets = 0, inlets_right = 0;
  int judged = 0, stenoses = 0, stenoses_found = 0, stenoses_wrong = 0;
};

/// Sums over simulations.
struct SimulationTotals {
  int cases = 0, clean = 0, airy = 0;
};

/// Sums of the rows that count.
struct Totals {
  int cases = 0, slow = 0, failed = 0;
  LineTotals lines;
  ReadingTotals read;
  SimulationTotals simulated;

  void add(const CollectionRow& row) {
    ++cases;
    failed += row.exit_code != 0 ? 1 : 0;
    slow += row.wall_s > kSecondsBar ? 1 : 0;
    if (row.lines) {
      ++lines.cases;
      lines.points += row.lines->points;
      lines.outside += row.lines->outside;
      lines.inside_all += row.lines->outside == 0 ? 1 : 0;
      lines.turns += row.lines->sharp_turns;
      lines.smooth += row.lines->sharp_turns == 0 ? 1 : 0;
      lines.radius_good += row.lines->radius_error_95_percent <= kRadiusBarPercent ? 1 : 0;
    }
    read.ends += row.ends_read.value_or(0);
    read.ends_found += row.ends_read ? row.ends_found : 0;
    read.inlets += row.inlet_right ? 1 : 0;
    read.inlets_right += row.inlet_right.value_or(false) ? 1 : 0;
    if (row.stenoses_read) {
      read.judged += row.lines ? 1 : 0;
      read.stenoses += *row.stenoses_read;
      read.stenoses_found += row.stenoses_found;
      read.stenoses_wrong += row.stenoses_wrong;
    }
    if (row.simulation) {
      ++simulated.cases;
      simulated.clean += row.simulation->crossing_frames == 0 ? 1 : 0;
      simulated.airy += row.simulation->air_percent >= kAirBarPercent ? 1 : 0;
    }
  }
  [[nodiscard]] double wrong_per_case() const {
    return double(read.stenoses_wrong) / std::max(1, read.judged);
  }
};

}  // namespace

void judge_run(const fs::path& case_folder, CollectionRow& row) {
  row.status = status_of(case_folder, row.exit_code);
  const fs::path lines = case_folder / "centerline/centerlines.vtp";
  if (fs::exists(lines)) row.lines = measure(pipeline::read_centerlines(lines), case_folder);
  row.simulation = measure_simulation(case_folder / "simulation/timeseries.csv");
}

void judge_against(const Reading& reading, const fs::path& case_folder, const fs::path& input,
                   CollectionRow& row) {
  row.ends_read = reading.ends;
  row.ends_by_place = !reading.placed_ends.empty();
  if (row.ends_by_place) row.ends_read = int(reading.placed_ends.size());
  if (!reading.inlets.empty()) row.inlet_right = false;
  row.stenoses_read = reading.stenoses;
  if (!row.lines) return;
  const CenterlineTree tree =
      pipeline::read_centerlines(case_folder / "centerline/centerlines.vtp");
  std::optional<VolumeGeometry> volume;
  if (reading.inlets_are_voxels)
    volume = segmentation::read_volume_file(case_folder / "segmentation/volume.nrrd").geometry;
  const Reading here = in_case(reading, frame_of_case(input, case_folder), volume);
  const std::vector<LineEnd> ends = ends_of(tree);
  row.ends_of_lines = int(ends.size());
  row.ends_found = row.ends_by_place ? count_found_ends(here.placed_ends, ends)
                                     : std::min(row.ends_read.value_or(0), int(ends.size()));
  if (!here.inlets.empty())
    row.inlet_right = is_inlet_right(here.inlets, ends.front(), here.placed_ends);
  const StenosisCount stenoses =
      count_stenoses(here, read_stenoses(case_folder / "centerline/lesions.json", tree));
  row.stenoses_found = stenoses.found;
  row.stenoses_wrong = stenoses.wrong;
}

const char* const kCollectionHeader =
    "case,split,certainty,status,exit_code,lines,points,outside,inside_percent,steps_over_25,"
    "turns_over_40,radius_error_95_percent,radius_off_2_percent,too_long_percent,ends_read,"
    "ends_found,ends_by,ends_of_lines,inlet_right,stenoses_read,stenoses_found,stenoses_false,"
    "frames,crossing_frames,max_penetration_mm,air_percent,wall_s,cpu_s";

std::string csv_line(const CollectionRow& row) {
  std::string text = fmt::format("{},{},{},{},{},", formats::csv_cell(row.name), row.split,
                                 row.certainty, formats::csv_cell(row.status), row.exit_code);
  if (const auto& l = row.lines)
    text += fmt::format("{},{},{},{:.2f},{},{},{:.2f},{:.2f},{:.2f},", l->count, l->points,
                        l->outside, l->inside_percent, l->sharp_steps, l->sharp_turns,
                        l->radius_error_95_percent, l->radius_off_percent, l->too_long_percent);
  else
    text += ",,,,,,,,,";
  text += row.ends_read ? fmt::format("{},{},{},", *row.ends_read, row.ends_found,
                                      row.ends_by_place ? "place" : "number")
                        : ",,,";
  text += fmt::format("{},", row.ends_of_lines);
  text += row.inlet_right ? (*row.inlet_right ? "yes," : "no,") : ",";
  text += row.stenoses_read
              ? fmt::format("{},{},{},", *row.stenoses_read, row.stenoses_found, row.stenoses_wrong)
              : ",,,";
  if (const auto& s = row.simulation)
    text += fmt::format("{},{},{:.4f},{:.1f},", s->frames, s->crossing_frames,
                        s->max_penetration_mm, s->air_percent);
  else
    text += ",,,,";
  return text + fmt::format("{:.1f},{:.1f}", row.wall_s, row.cpu_s);
}

std::string markdown_head() {
  return "| case | inside % | turns | radius % | ends | inlet | stenoses | false | status | "
         "crossings | air % | s (CPU) |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
}

std::string markdown_line(const CollectionRow& row) {
  std::string text = fmt::format("| {}{} |", row.name, row.is_certain() ? "" : " ?");
  if (const auto& l = row.lines)
    text += fmt::format(" {} | {} | {} |",
                        bold_if(l->outside > 0, fmt::format("{:.2f}", l->inside_percent)),
                        bold_if(l->sharp_turns > 0, std::to_string(l->sharp_turns)),
                        bold_if(l->radius_error_95_percent > kRadiusBarPercent,
                                fmt::format("{:.1f}", l->radius_error_95_percent)));
  else
    text += " - | - | - |";
  text += " " + ends_text(row) + " |";
  text += !row.inlet_right   ? " - |"
          : *row.inlet_right ? " right |"
          : row.lines        ? " **wrong** |"
                             : " **none** |";
  if (row.stenoses_read)
    text += fmt::format(" {} | {} |",
                        bold_if(row.stenoses_found < *row.stenoses_read,
                                fmt::format("{}/{}", row.stenoses_found, *row.stenoses_read)),
                        bold_if(row.stenoses_wrong > 0, std::to_string(row.stenoses_wrong)));
  else
    text += " - | - |";
  text += fmt::format(
      " {} |", bold_if(row.exit_code != 0,
                       row.exit_code == 0 ? row.status
                                          : fmt::format("{}, exit {}", row.status, row.exit_code)));
  if (const auto& s = row.simulation)
    text += fmt::format(
        " {} | {} |",
        bold_if(s->crossing_frames > 0,
                s->crossing_frames == 0
                    ? "0"
                    : fmt::format("{} ({:.3f} mm)", s->crossing_frames, s->max_penetration_mm)),
        bold_if(s->air_percent < kAirBarPercent, fmt::format("{:.0f}", s->air_percent)));
  else
    text += " - | - |";
  return text + fmt::format(" {} ({:.0f}) |",
                            bold_if(row.wall_s > kSecondsBar, fmt::format("{:.0f}", row.wall_s)),
                            row.cpu_s);
}

std::string summary(const std::vector<CollectionRow>& rows) {
  Totals certain, all;
  for (const CollectionRow& row : rows) {
    all.add(row);
    if (row.is_certain()) certain.add(row);
  }
  std::string text = fmt::format(
      "| of all cases | bar | certain readings ({} cases) | all ({} cases) |\n|---|---|---|---|\n",
      certain.cases, all.cases);
  const auto add = [&](const char* what, const char* bar, auto value) {
    text += fmt::format("| {} | {} | {} | {} |\n", what, bar, value(certain), value(all));
  };
  using T = const Totals&;
  add("cases that have lines", "", [](T t) { return share(t.lines.cases, t.cases); });
  add("points inside the lumen", "100 %",
      [](T t) { return share(t.lines.points - t.lines.outside, t.lines.points); });
  add("cases with all points inside", "",
      [](T t) { return share(t.lines.inside_all, t.lines.cases); });
  add("turns over 40 degrees within a radius", "0",
      [](T t) { return std::to_string(t.lines.turns); });
  add("cases without such a turn", "", [](T t) { return share(t.lines.smooth, t.lines.cases); });
  add("cases whose radii are within 2 % of the distance to the wall", "all",
      [](T t) { return share(t.lines.radius_good, t.lines.cases); });
  add("ends found", "98 %", [](T t) { return share(t.read.ends_found, t.read.ends); });
  add("inlet right", "95 %", [](T t) { return share(t.read.inlets_right, t.read.inlets); });
  add("stenoses over 50 % found", "all",
      [](T t) { return share(t.read.stenoses_found, t.read.stenoses); });
  add("false stenoses over 50 %, a case", "under 0.2",
      [](T t) { return fmt::format("{:.2f}", t.wrong_per_case()); });
  add("simulations without a crossing", "all",
      [](T t) { return share(t.simulated.clean, t.simulated.cases); });
  add("simulations with air in 95 % of the frames", "all",
      [](T t) { return share(t.simulated.airy, t.simulated.cases); });
  add("cases over 5 minutes", "0", [](T t) { return std::to_string(t.slow); });
  add("cases with another exit code than 0", "", [](T t) { return std::to_string(t.failed); });
  return text;
}

}  // namespace angio
