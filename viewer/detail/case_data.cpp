#include "viewer/detail/case_data.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/csv.hpp"
#include "formats/files.hpp"
#include "formats/nrrd.hpp"
#include "formats/text.hpp"
#include "formats/tokens.hpp"
#include "viewer/detail/report_charts.hpp"

namespace angio::viewer::detail {
namespace case_file = formats::case_file;
namespace fs = std::filesystem;
namespace {

const std::string kSimulationName = fs::path(case_file::kFrameList).parent_path();
const std::string kFrameListName = fs::path(case_file::kFrameList).filename();
const std::string kTimeSeriesName = fs::path(case_file::kTimeSeries).filename();

/// The digits of "balloon_000120.vtp".
int frame_number(const fs::path& file) {
  const std::string stem = file.stem().string();
  const auto digits = stem.find_last_not_of("0123456789");
  const auto number = formats::parse_number<int>(
      std::string_view(stem).substr(digits == std::string::npos ? 0 : digits + 1));
  return number.value_or(0);
}

/// A value per line; 0, 1, ... where the file has no such array.
std::vector<int> line_numbers(const formats::PolylineData& data, const std::string& name) {
  std::vector<int> numbers(data.lines.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  for (const DataArray& array : data.cell_arrays)
    if (array.name == name)
      std::transform(array.values.begin(), array.values.end(), numbers.begin(),
                     [](double value) { return int(value); });
  return numbers;
}

}  // namespace

std::vector<CenterlinePath> read_paths(const fs::path& file) {
  const formats::PolylineData data = formats::read_polylines(file);
  const DataArray& radius = formats::find_array(data.point_arrays, "MaximumInscribedSphereRadius");
  const std::vector<int> ids = line_numbers(data, "CenterlineIds");
  const std::vector<int> tracts = line_numbers(data, "TractIds");
  std::map<std::pair<int, int>, std::size_t> order;  // in the file lines are cut into tracts
  for (std::size_t line = 0; line < data.lines.size(); ++line)
    order[{ids[line], tracts[line]}] = line;
  std::map<int, CenterlinePath> joined;
  for (const auto& [key, line] : order) {
    CenterlinePath& path = joined[key.first];
    path.id = key.first;
    for (const int index : data.lines[line]) {
      const Vec3& point = data.points[std::size_t(index)];
      if (!path.points.empty() && point == path.points.back()) continue;  // shared by two tracts
      path.points.push_back(point);
      path.inscribed_radius.push_back(radius.values[std::size_t(index)]);
    }
  }
  std::vector<CenterlinePath> paths;
  for (auto& [id, path] : joined) {
    path.equivalent_radius = path.inscribed_radius;
    path.section_area.assign(path.points.size(), 0.0);
    path.abscissa = arc_length(path.points);
    if (path.points.size() >= 2) paths.push_back(std::move(path));
  }
  return paths;
}

void check_case(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw InputError(folder.string() +
                         (fs::exists(folder, ignored) ? " is no case (it is a file)"
                                                      : " is no case (there is no such folder)") +
                         ". Name the folder that `angio run -o` made",
                     ExitCode::no_input);
  const fs::path lumen = folder / case_file::kLumen;
  if (!fs::exists(lumen, ignored))
    throw InputError(folder.string() +
                         " has nothing to show yet (meshing/lumen.vtp is missing). Run `angio "
                         "run INPUT -o " +
                         folder.string() + "` first",
                     ExitCode::no_input);
}

CaseData read_case(const fs::path& folder) {
  check_case(folder);
  std::error_code ignored;
  CaseData data;
  data.lumen = formats::read_surface(folder / case_file::kLumen).mesh;
  const fs::path scan = folder / case_file::kScan;
  if (fs::exists(scan, ignored)) data.scan = formats::read_nrrd(scan);
  const fs::path lines = folder / case_file::kCenterlines;
  if (fs::exists(lines, ignored)) data.paths = read_paths(lines);
  const fs::path simulation = simulation_folder(folder);
  if (!simulation.empty()) data.frames = read_frame_list(simulation / kFrameListName);
  const fs::path still_wire = folder / case_file::kGuidewire;
  if (fs::exists(still_wire, ignored))
    for (FrameFiles& frame : data.frames)
      if (frame.guidewire.empty()) frame.guidewire = still_wire;
  const fs::path table = simulation / kTimeSeriesName;
  if (!simulation.empty() && fs::exists(table, ignored)) data.series = read_time_series(table);
  return data;
}

fs::path simulation_folder(const fs::path& case_folder) {
  fs::path latest;
  fs::file_time_type latest_time;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(case_folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name != kSimulationName && !name.starts_with("." + kSimulationName + ".tmp-")) continue;
    const fs::file_time_type time = fs::last_write_time(entry.path() / kFrameListName, error);
    if (error || (!latest.empty() && time <= latest_time)) continue;
    latest = entry.path();
    latest_time = time;
  }
  return latest;
}

std::vector<FrameFiles> read_frame_list(const fs::path& collection) {
  std::map<int, FrameFiles> frames;
  for (const formats::TimeStep& step : formats::read_collection(collection)) {
    const fs::path file = step.file;
    const std::string name = file.filename().string();
    FrameFiles& frame = frames[frame_number(file)];
    frame.frame = frame_number(file);
    frame.time_s = step.time_s;
    if (name.starts_with("balloon")) frame.balloon = collection.parent_path() / file;
    if (name.starts_with("vessel")) frame.vessel = collection.parent_path() / file;
    if (name.starts_with("wall")) frame.tissue = collection.parent_path() / file;
    if (name.starts_with("guidewire")) frame.guidewire = collection.parent_path() / file;
  }
  std::vector<FrameFiles> list;
  for (auto& [number, frame] : frames)
    if (!frame.balloon.empty() && !frame.vessel.empty()) list.push_back(std::move(frame));
  return list;
}

TimeSeries read_time_series(const fs::path& csv) {
  TimeSeries series;
  series.rows = formats::parse_csv(read_text(csv));
  if (series.rows.empty()) return series;
  series.columns = std::move(series.rows.front());
  series.rows.erase(series.rows.begin());
  return series;
}

std::optional<std::size_t> row_of(const TimeSeries& series, int frame) {
  const std::vector<double> frames = column(series, "frame");
  const auto found = std::find(frames.begin(), frames.end(), double(frame));
  if (found == frames.end()) return std::nullopt;
  return std::size_t(found - frames.begin());
}

std::size_t nearest_frame(const std::vector<FrameFiles>& frames, int frame) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (std::abs(frames[i].frame - frame) < std::abs(frames[nearest].frame - frame)) nearest = i;
  return nearest;
}

std::size_t peak_frame(const CaseData& data) {
  const std::vector<double> pressure = column(data.series, "pressure_atm");
  std::size_t peak = 0;
  double highest = -1.0;
  for (std::size_t i = 0; i < data.frames.size(); ++i) {
    const auto row = row_of(data.series, data.frames[i].frame);
    if (row && *row < pressure.size() && pressure[*row] > highest) {
      highest = pressure[*row];
      peak = i;
    }
  }
  return peak;
}

std::string describe_frame(const CaseData& data, const FrameFiles& files) {
  std::string text =
      "frame " + std::to_string(files.frame) + "    " + formats::fixed_text(files.time_s, 3) + " s";
  const auto row = row_of(data.series, files.frame);
  if (!row) return text;
  const auto phase = std::find(data.series.columns.begin(), data.series.columns.end(), "phase");
  const auto phase_index = std::size_t(phase - data.series.columns.begin());
  if (phase_index < data.series.rows[*row].size())
    text += "    " + data.series.rows[*row][phase_index];
  const auto add = [&](const char* name, const char* label, const char* unit, int decimals) {
    const std::vector<double> values = column(data.series, name);
    if (*row < values.size() && std::isfinite(values[*row]))
      text += std::string("    ") + label + formats::fixed_text(values[*row], decimals) + unit;
  };
  add("pressure_atm", "", " atm", 2);
  add("balloon_diameter_mm", "balloon ", " mm", 2);
  add("lumen_mld_mm", "MLD ", " mm", 2);
  return text;
}

}  // namespace angio::viewer::detail

namespace angio::viewer {

std::vector<FrameTime> read_frame_times(const std::filesystem::path& path) {
  std::vector<FrameTime> times;
  for (const detail::FrameFiles& files : detail::read_frame_list(path))
    times.push_back({files.frame, files.time_s});
  return times;
}

}  // namespace angio::viewer
