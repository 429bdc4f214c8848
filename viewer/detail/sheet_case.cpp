#include "viewer/detail/sheet_case.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "formats/nrrd.hpp"
#include "formats/text.hpp"
#include "viewer/detail/case_data.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/level_set_surface.hpp"

namespace angio::viewer::detail {
namespace case_file = formats::case_file;
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr const char* kStages[] = {"reconstruction", "segmentation", "centerline",
                                   "meshing",        "simulation",   "report"};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The file's JSON; null if it is missing or damaged.
json read_json(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {};
  json parsed = json::parse(read_text(file), nullptr, false);
  return parsed.is_discarded() ? json() : parsed;
}

double number(const json& node, const char* key) {
  if (!node.is_object()) return kNone;
  const auto found = node.find(key);
  return found != node.end() && found->is_number() ? found->get<double>() : kNone;
}

std::string words(const json& node, const char* key) {
  if (!node.is_object()) return {};
  const auto found = node.find(key);
  return found != node.end() && found->is_string() ? found->get<std::string>() : std::string();
}

json part(const json& node, const char* key) {
  return node.is_object() && node.contains(key) ? node.at(key) : json();
}

TriangleMesh read_lumen(const fs::path& folder) {
  std::error_code ignored;
  for (const char* name : {case_file::kLumen, case_file::kGivenLumen})
    if (fs::exists(folder / name, ignored)) return formats::read_surface(folder / name).mesh;
  const fs::path level_set = folder / case_file::kLevelSet;
  if (!fs::exists(level_set, ignored)) return {};
  return zero_surface(formats::read_nrrd(level_set));
}

std::vector<SheetLesion> read_lesions(const fs::path& file) {
  std::vector<SheetLesion> lesions;
  const json list = read_json(file);
  if (!list.is_array()) return lesions;
  for (const json& row : list) {
    SheetLesion lesion;
    const auto index = lesions.size();
    lesion.name = std::string(1, char('A' + index % 26));
    if (index >= 26) lesion.name += std::to_string(index / 26);
    lesion.path =
        std::isfinite(number(row, "centerline_id")) ? int(number(row, "centerline_id")) : -1;
    lesion.abscissa_mm = number(row, "abscissa_mm");
    lesion.mld_mm = number(row, "mld_mm");
    lesion.reference_mm = number(row, "reference_diameter_mm");
    lesion.stenosis_percent = number(row, "diameter_stenosis_percent");
    lesion.proximal_mm = number(row, "proximal_mm");
    lesion.distal_mm = number(row, "distal_mm");
    if (std::isfinite(lesion.abscissa_mm)) lesions.push_back(lesion);
  }
  return lesions;
}

/// The balloon at peak; where there are no frames, as it was placed.
void read_balloon(const fs::path& folder, ReportContent& content) {
  std::error_code ignored;
  const auto read_wire = [&](const fs::path& file) {
    return fs::exists(file, ignored) ? formats::read_polylines(file).points : std::vector<Vec3>();
  };
  CaseData data;
  if (fs::exists(folder / case_file::kFrameList, ignored))
    data.frames = read_frame_list(folder / case_file::kFrameList);
  if (fs::exists(folder / case_file::kTimeSeries, ignored))
    data.series = read_time_series(folder / case_file::kTimeSeries);
  if (!data.frames.empty()) {
    const FrameFiles& peak = data.frames[peak_frame(data)];
    content.moments.push_back(
        {describe_frame(data, peak),
         formats::read_surface(peak.balloon).mesh,
         formats::read_surface(peak.vessel).mesh,
         {},
         read_wire(peak.guidewire.empty() ? folder / case_file::kGuidewire : peak.guidewire)});
  } else if (fs::exists(folder / case_file::kBalloon, ignored) &&
             fs::exists(folder / case_file::kRegion, ignored)) {
    content.moments.push_back({"the balloon as placed; not simulated",
                               formats::read_surface(folder / case_file::kBalloon).mesh,
                               formats::read_surface(folder / case_file::kRegion).mesh,
                               {},
                               read_wire(folder / case_file::kGuidewire)});
  }
}

void read_after(const fs::path& file, DiameterProfile& after) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return;
  const TimeSeries table = read_time_series(file);
  after.abscissa_mm = column(table, "abscissa_mm");
  after.inscribed_diameter_mm = column(table, "inscribed_diameter_after_mm");
}

/// The line to show the diameter of: the treated one, the first lesion's, or the longest.
void choose_line(const json& metrics, SheetCase& sheet) {
  ReportContent& content = sheet.content;
  const json lesion = part(metrics, "lesion");
  if (std::isfinite(number(lesion, "centerline_id"))) {
    content.lesion_path = int(number(lesion, "centerline_id"));
    content.lesion_abscissa_mm = number(lesion, "abscissa_mm");
  } else if (!sheet.lesions.empty()) {
    content.lesion_path = sheet.lesions.front().path;
    content.lesion_abscissa_mm = sheet.lesions.front().abscissa_mm;
  } else if (!content.tree.paths.empty()) {
    const auto& paths = content.tree.paths;
    content.lesion_path =
        std::max_element(paths.begin(), paths.end(), [](const auto& a, const auto& b) {
          return a.abscissa.back() < b.abscissa.back();
        })->id;
  }
}

void read_run(const json& run, SheetCase& sheet) {
  double total = 0.0;
  std::string split;
  for (const char* stage : kStages) {
    const json record = part(part(run, "stages"), stage);
    const double seconds = number(record, "seconds");
    if (std::isfinite(seconds) && seconds > 0.0) {
      total += seconds;
      split +=
          (split.empty() ? "" : ", ") + std::string(stage) + " " + formats::fixed_text(seconds, 1);
    }
    for (const char* key : {"error", "warnings"}) {
      const json said = part(record, key);
      if (said.is_string())
        sheet.notes.push_back(std::string(stage) + ": " + said.get<std::string>());
      if (!said.is_array()) continue;
      for (const json& warning : said)
        if (warning.is_string())
          sheet.notes.push_back(std::string(stage) + ": " + warning.get<std::string>());
    }
  }
  sheet.times = formats::fixed_text(total, 1) + " s" + (split.empty() ? "" : " (" + split + ")");
}

std::string describe_input(const json& run, const SheetCase& sheet) {
  std::string text = words(part(run, "input"), "description");
  if (sheet.content.volume) {
    const VolumeGeometry& grid = sheet.content.volume->geometry;
    text += text.empty() ? "" : ", ";
    for (std::size_t i = 0; i < 3; ++i) text += (i > 0 ? " x " : "") + std::to_string(grid.size[i]);
    text += " voxels of ";
    for (int i = 0; i < 3; ++i)
      text += (i > 0 ? " x " : "") + formats::fixed_text(grid.spacing[i], 3);
    return text + " mm";
  }
  if (!sheet.content.lumen.vertices.empty()) {  // shows a wrong unit
    Vec3 low = sheet.content.lumen.vertices.front(), high = low;
    for (const Vec3& vertex : sheet.content.lumen.vertices)
      for (int i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], vertex[i]);
        high[i] = std::max(high[i], vertex[i]);
      }
    text += ", box of ";
    for (int i = 0; i < 3; ++i)
      text += (i > 0 ? " x " : "") + formats::fixed_text(high[i] - low[i], 1);
    text += " mm";
  }
  return text;
}

/// The last line that a run printed.
std::string last_line(const fs::path& log) {
  std::error_code ignored;
  if (log.empty() || !fs::exists(log, ignored)) return {};
  std::string text = read_text(log);
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text.substr(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
}

/// What metrics.json says; otherwise which stages ran.
std::string describe_status(const json& run, const json& metrics, const std::string& last) {
  const std::string told = words(metrics, "status"), reason = words(metrics, "status_reason");
  if (!told.empty()) return told + (reason.empty() ? "" : ": " + reason);
  const std::string why = last.starts_with("angio: ") ? ": " + last.substr(7) : "";
  std::string reached;
  for (const char* stage : kStages) {
    const std::string status = words(part(part(run, "stages"), stage), "status");
    if (status == "failed") return std::string("failed in ") + stage + why;
    if (status == "done" || status == "given") reached = stage;
  }
  if (reached.empty()) return "failed" + why;
  return reached == "report" ? "done" : "run as far as " + reached;
}

void read_parts(const fs::path& folder, SheetCase& sheet) {
  ReportContent& content = sheet.content;
  std::error_code ignored;
  content.lumen = read_lumen(folder);
  if (fs::exists(folder / case_file::kScan, ignored))
    content.volume = formats::read_nrrd(folder / case_file::kScan);
  if (fs::exists(folder / case_file::kCenterlines, ignored))
    content.tree.paths = read_paths(folder / case_file::kCenterlines);
  sheet.lesions = read_lesions(folder / case_file::kLesions);
  read_balloon(folder, content);
  read_after(folder / case_file::kProfile, content.after);
}

}  // namespace

SheetCase read_sheet_case(const fs::path& folder, const fs::path& log) {
  SheetCase sheet;
  sheet.name = folder.filename().empty() ? folder.parent_path().filename().string()
                                         : folder.filename().string();
  const json run = read_json(folder / case_file::kRun),
             metrics = read_json(folder / case_file::kMetrics);
  read_run(run, sheet);
  try {
    read_parts(folder, sheet);
  } catch (const Error& error) {  // a damaged part must not hide the others
    sheet.notes.push_back(error.what());
  }
  choose_line(metrics, sheet);
  sheet.input = describe_input(run, sheet);
  const std::string last = last_line(log);
  sheet.status = describe_status(run, metrics, last);
  if (sheet.content.lumen.triangles.empty()) sheet.why_nothing = sheet.status;
  return sheet;
}

}  // namespace angio::viewer::detail
