#include "pipeline/cli/data_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "pipeline/case/input_folder.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/tell.hpp"
#include "pipeline/cli/shared_options.hpp"
#include "pipeline/stages/reconstruction.hpp"
#include "pipeline/stages/surface_input.hpp"
#include "reconstruction/reconstruction.hpp"
#include "segmentation/read_run.hpp"
#include "segmentation/read_views.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {
namespace {

template <class Value>
nlohmann::json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

constexpr const char* kSpacingPlanes[] = {"unknown", "detector", "isocentre", "calibrated"};

nlohmann::json to_json(const segmentation::ProjectionRun& run) {
  nlohmann::json json = {{"primary_angles_degrees", run.primary_angles_degrees},
                         {"secondary_angles_degrees", run.secondary_angles_degrees},
                         {"base_angles_degrees", run.base_angles_degrees},
                         {"source_to_detector_mm", or_null(run.source_to_detector_mm)},
                         {"source_to_isocentre_mm", or_null(run.source_to_isocentre_mm)},
                         {"magnification", or_null(run.magnification)},
                         {"spacing_mm", run.spacing_mm},
                         {"spacing_plane", kSpacingPlanes[int(run.spacing_plane)]},
                         {"frame_time_ms", or_null(run.frame_time_ms)},
                         {"r_wave_times_ms", run.r_wave_times_ms},
                         {"mask_frames", run.mask_frames},
                         {"mask_operation", run.mask_operation},
                         {"open_field", or_null(run.open_field)},
                         {"burned_in_text", run.burned_in_text},
                         {"positioner_motion", run.positioner_motion},
                         {"pixel_relation", run.pixel_relation},
                         {"pixels_inverted", run.is_inverted},
                         {"has_contrast_medium", run.has_contrast_medium},
                         {"table_travel_mm", run.table_travel_mm},
                         {"notes", run.notes}};
  if (!(run.spacing_mm[0] > 0.0)) json["spacing_mm"] = nullptr;
  return json;
}

/// What is in an input, and what `angio run` takes of it.
struct Findings {
  std::vector<segmentation::SeriesSummary> series;
  std::vector<segmentation::ViewSummary> views;
  bool has_volume = false, has_run = false, has_views = false;  ///< one can be used

  [[nodiscard]] const segmentation::ViewSummary* view_of(
      const segmentation::SeriesSummary& s) const {
    const auto found = std::find_if(views.begin(), views.end(), [&](const auto& view) {
      return view.series == s.key && view.problem.empty();
    });
    return has_views && found != views.end() ? &*found : nullptr;
  }
};

/// "volume", "rotational run" or "view"; empty: it is not taken.
std::string taken_as(const segmentation::SeriesSummary& s, const Findings& findings) {
  if (s.usable) return "volume";
  if (s.is_rotational && (findings.has_run || findings.has_volume)) return "rotational run";
  return findings.view_of(s) != nullptr ? "view" : "";
}

/// "usable: regular grid"; of what is no volume, but taken all the same, as what.
std::string verdict_on(const segmentation::SeriesSummary& s, const Findings& findings) {
  const std::string as = taken_as(s, findings);
  if (as == "rotational run")
    return fmt::format("usable by `angio run{}`: a rotational run, of which it makes a volume",
                       findings.has_volume ? " --series " + s.key : "");
  if (as == "view")
    return fmt::format("usable by `angio run`: view {} of a C-arm that stood still",
                       findings.view_of(s)->number);
  if (s.is_rotational) return "refused: a rotational run that no volume can be made of";
  return (s.usable ? "usable: " : "refused: ") + s.verdict;
}

nlohmann::json to_json(const segmentation::SeriesSummary& s, const Findings& findings) {
  const auto& g = s.geometry;
  nlohmann::json json = {{"key", s.key},
                         {"kind", s.kind},
                         {"transfer_syntax", s.transfer_syntax},
                         {"pixel_format", s.pixel_format},
                         {"files", s.file_count},
                         {"frames", s.frame_count},
                         {"size", {g.size[0], g.size[1], g.size[2]}},
                         {"spacing_mm", {g.spacing.x, g.spacing.y, g.spacing.z}},
                         {"usable", s.usable},
                         {"taken_as", nullptr},
                         {"lossy", s.lossy},
                         {"resampled", s.resampled},
                         {"tilt_degrees", s.tilt_degrees},
                         {"verdict", s.verdict},
                         {"warnings", s.warnings}};
  if (!s.usable) json["spacing_mm"] = nullptr;
  if (const std::string as = taken_as(s, findings); !as.empty()) json["taken_as"] = as;
  if (g.size[0] == 0) json["size"] = nullptr;
  json["labels"] = s.labels.empty() ? nlohmann::json(nullptr) : nlohmann::json::array();
  if (s.projection) json["projection"] = to_json(*s.projection);
  for (const segmentation::Label& label : s.labels)
    json["labels"].push_back({{"value", label.value}, {"voxels", label.voxel_count}});
  return json;
}

/// "-30.0 to 30.0", or the one angle of a standing run.
std::string range_text(const std::vector<double>& angles) {
  if (angles.empty()) return "unknown";
  const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
  return *least == *most ? fmt::format("{:.1f}", *least)
                         : fmt::format("{:.1f} to {:.1f}", angles.front(), angles.back());
}

void print_projection(const segmentation::ProjectionRun& run) {
  tell("   angles: primary (RAO to LAO) {}, secondary (CAU to CRA) {} degrees",
       range_text(run.primary_angles_degrees), range_text(run.secondary_angles_degrees));
  const auto distance_text = [](const std::optional<double>& mm) {
    return mm ? fmt::format("{:.1f} mm", *mm) : std::string("unknown");
  };
  tell("   source to detector {}, source to isocentre {}", distance_text(run.source_to_detector_mm),
       distance_text(run.source_to_isocentre_mm));
  if (run.spacing_mm[0] > 0.0)
    tell("   pixels of {:.4g} x {:.4g} mm, plane: {}", run.spacing_mm[0], run.spacing_mm[1],
         kSpacingPlanes[int(run.spacing_plane)]);
  else
    tell("   pixel size unknown");
  if (run.frame_time_ms) tell("   {:.4g} ms a frame", *run.frame_time_ms);
  if (!run.r_wave_times_ms.empty())
    tell("   {} R wave(s) of the heart", run.r_wave_times_ms.size());
  if (!run.mask_operation.empty())
    tell("   digital subtraction: {}, mask frame(s) {}", run.mask_operation,
         fmt::join(run.mask_frames, ", "));
  if (run.open_field)
    tell("   open field: columns {} to {}, rows {} to {}", (*run.open_field)[0],
         (*run.open_field)[1], (*run.open_field)[2], (*run.open_field)[3]);
  if (run.burned_in_text) tell("   text is burned into the pixels");
  for (const std::string& note : run.notes) tell("   note: {}", note);
}

void print_labels(const segmentation::SeriesSummary& s) {
  constexpr std::size_t kMost = 32;
  if (s.labels.empty()) return;
  const Vec3& h = s.geometry.spacing;
  std::vector<std::string> texts;
  for (std::size_t n = 0; n < std::min(s.labels.size(), kMost); ++n)
    texts.push_back(fmt::format("{} ({:.4g} ml)", s.labels[n].value,
                                double(s.labels[n].voxel_count) * h.x * h.y * h.z / 1000.0));
  tell("   a label map, no image, of {} label(s): {}{}; segmentation.labels chooses",
       s.labels.size(), fmt::join(texts, ", "), s.labels.size() > kMost ? ", ..." : "");
}

void print_series(std::size_t number, const segmentation::SeriesSummary& s,
                  const Findings& findings) {
  const auto& g = s.geometry;
  tell("{}  {}  {}, {} file(s), {} frame(s), {}{}", number, s.key, s.kind, s.file_count,
       s.frame_count, s.transfer_syntax, s.lossy ? " (lossy)" : "");
  if (!s.pixel_format.empty()) tell("   {}", s.pixel_format);
  if (s.usable)
    tell("   {} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm", g.size[0], g.size[1], g.size[2],
         g.spacing.x, g.spacing.y, g.spacing.z);
  else if (g.size[0] > 0)
    tell("   {} columns x {} rows x {} frame(s)", g.size[0], g.size[1], g.size[2]);
  print_labels(s);
  if (s.projection) print_projection(*s.projection);
  tell("   {}", verdict_on(s, findings));
  for (const std::string& warning : s.warnings) tell("   note: {}", warning);
}

/// What `angio run` makes of a rotational run.
struct Forecast {
  reconstruction::RunForecast run;
  std::optional<reconstruction::HeartForecast> heart;
  std::string source;
};

/// What it makes of the folder, where that is the volume of a rotational run.
std::optional<Forecast> forecast_of(const std::string& input, const Config& config) {
  std::optional<segmentation::LoadedRun> loaded;
  try {
    loaded = segmentation::read_run(input, config.input);
  } catch (const InputError&) {
    return {};  // the list has said why it is refused
  }
  if (!loaded) return {};
  try {
    return Forecast{
        reconstruction::forecast_run(frames_by_header(*loaded), loaded->masks != nullptr,
                                     config.reconstruction, open_field_of(*loaded)),
        reconstruction::forecast_heart(in_seconds(loaded->run.frame_times_ms),
                                       in_seconds(loaded->run.r_wave_times_ms),
                                       config.reconstruction),
        loaded->source_description};
  } catch (const InputError& error) {
    fmt::print(stderr, "`angio run` makes no volume of it: {}\n", error.what());
    return {};
  }
}

nlohmann::json to_json(const Forecast& forecast) {
  const auto& [quality, grid, error, is_sparse] = forecast.run;
  nlohmann::json json = {
      {"source", forecast.source},
      {"frames", quality.frame_count},
      {"arc_degrees", quality.arc_degrees},
      {"shortest_arc_degrees", quality.shortest_arc_degrees},
      {"largest_step_degrees", quality.largest_step_degrees},
      {"sparse", is_sparse},
      {"subtracted", quality.is_subtracted},
      {"pixel_at_isocentre_mm", quality.pixel_at_isocentre_mm},
      {"field_radius_mm", quality.field_radius_mm},
      {"size", grid.size},
      {"voxel_mm", grid.spacing.x},
      {"radius_error_mm", std::isfinite(error) ? nlohmann::json(error) : nlohmann::json(nullptr)},
      {"heart", nullptr}};
  if (forecast.heart)
    json["heart"] = {{"beats_per_min", forecast.heart->beats_per_min},
                     {"beats", forecast.heart->beats},
                     {"phase_frames", forecast.heart->phase_frames}};
  return json;
}

void print_forecast(const Forecast& forecast) {
  constexpr double kBytesPerVoxel = 12.0;  // the sums, the volume, and the one before it
  const auto& [quality, grid, error, is_sparse] = forecast.run;
  const bool vessels_alone = quality.method == reconstruction::Method::few_views;
  const auto& n = grid.size;
  tell("`angio run` makes a volume of: {}", forecast.source);
  tell(
      "   {} frames over {:.0f} degrees, up to {:.1f} degrees apart; all sides are seen from "
      "{:.0f} "
      "degrees on",
      quality.frame_count, quality.arc_degrees, quality.largest_step_degrees,
      quality.shortest_arc_degrees);
  tell(
      "   {} x {} x {} voxels of {:.3g} mm, {:.0f} mm across, {:.0f} mm high; about {:.0f} MiB "
      "of memory",
      n[0], n[1], n[2], grid.spacing.x, 2.0 * quality.field_radius_mm, n[2] * grid.spacing.z,
      kBytesPerVoxel * double(grid.voxel_count()) / double(1 << 20));
  if (std::isfinite(error))
    tell("   expected: radii to about {:.2g} mm, where all stands still{}", error,
         vessels_alone ? "; the vessels alone, for there are few frames" : "");
  else
    tell(
        "   expected: vessels blurred along the direction that the arc lacks; radii there are "
        "not to be trusted");
  if (!quality.is_subtracted && !vessels_alone)
    tell("   no mask run: bone and tissue stay in the volume");
  if (forecast.heart)
    tell(
        "   heart: {:.1f} beats, {:.0f} a minute; where the vessels move with it, the volume is "
        "made of the {} frames of one phase",
        forecast.heart->beats, forecast.heart->beats_per_min, forecast.heart->phase_frames);
}

nlohmann::json to_json(const std::vector<segmentation::ViewSummary>& views) {
  nlohmann::json list = nlohmann::json::array();
  for (const segmentation::ViewSummary& view : views)
    list.push_back(
        {{"view", view.number},
         {"series", view.series},
         {"primary_degrees", view.primary_degrees},
         {"secondary_degrees", view.secondary_degrees},
         {"frames", view.frame_count},
         {"problem", view.problem.empty() ? nlohmann::json() : nlohmann::json(view.problem)}});
  return list;
}

/// What `angio run` can make of angiograms of a C-arm that stood still.
void print_views(const std::vector<segmentation::ViewSummary>& views) {
  if (views.size() < 2) return;
  tell(
      "views of a C-arm that stood still; `angio run` finds the vessels that two or more of them,");
  tell("30 degrees apart, show (--views 1,2; --ends for one vessel):");
  for (const segmentation::ViewSummary& view : views)
    tell("   view {}: series {}, {:.1f}/{:.1f} degrees, {} frame(s){}", view.number, view.series,
         view.primary_degrees, view.secondary_degrees, view.frame_count,
         view.problem.empty() ? "" : "; cannot be used: " + view.problem);
}

}  // namespace

void add_read_options(CLI::App& command, ReadArguments& read) {
  command.add_option("--series", read.series, "series of a DICOM folder, from `angio inspect`");
  command
      .add_option("--views", read.views,
                  "angiograms of a C-arm that stood still, from `angio inspect`: 2 to 6 of one\n"
                  "vessel, 30 degrees apart")
      ->type_name("1,3");
  command
      .add_option(
          "--ends", read.ends,
          "the one vessel that is wanted of them: column,row of its proximal end, then of\n"
          "its distal one, in pixels from 0, for each view; otherwise all that they tell of")
      ->type_name("C,R,C,R,...");
  command.add_flag("--allow-lossy", read.allow_lossy, "measure on lossy-compressed pixels");
  command
      .add_option("--spacing", read.spacing,
                  "voxel size [mm] between columns, rows and slices, for a scan that states none")
      ->type_name("I,J,K");
  command.add_flag("--resample", read.resample,
                   "interpolate missing or unevenly spaced slices instead of refusing them");
  command
      .add_option("--angles", read.angles,
                  "a projection run's angle increments: from-base or cumulative")
      ->check(CLI::IsMember({"from-base", "cumulative"}));
  command
      .add_option("--max-memory", read.max_memory,
                  "refuse a scan that needs more [GiB]; 0: what is free")
      ->check(CLI::Range(0.0, 65536.0));
}

void add_unit_option(CLI::App& command, std::string& unit) {
  command
      .add_option(
          "--unit", unit,
          "of a given lumen surface or volume file: mm, cm, m, inch, or auto (default): as the\n"
          "file says, otherwise by its size")
      ->check(CLI::IsMember({"auto", "mm", "cm", "m", "inch"}));
}

void apply_read_options(Config& config, const ReadArguments& read) {
  if (!read.spacing.empty())
    apply_option(config, "--spacing", read.spacing, "input.spacing_mm=[" + read.spacing + "]",
                 "three voxel sizes I,J,K [mm]");
  if (!read.max_memory.empty())
    apply_option(config, "--max-memory", read.max_memory, "input.max_memory_gib=" + read.max_memory,
                 "a number [GiB]");
  if (!read.views.empty())
    apply_option(config, "--views", read.views, "input.views=\"" + read.views + "\"",
                 "numbers of two views or more, as 1,3");
  if (!read.ends.empty())
    apply_option(config, "--ends", read.ends, "views.ends=[" + read.ends + "]",
                 "four numbers a view: column,row of the vessel's proximal end, then of its distal "
                 "one");
  try {
    if (!read.series.empty()) config.input.series = read.series;
    if (!read.angles.empty()) apply_setting(config, "input.angles=" + read.angles);
    if (read.allow_lossy) config.input.allow_lossy = true;
    if (read.resample) config.input.resample = true;
    config.input.validate();
  } catch (const OptionError& error) {  // on the command line, not in a configuration
    throw Error(ExitCode::usage, error.what());
  }
}

CLI::App& add_inspect_command(CLI::App& app, InspectArguments& inspect) {
  CLI::App& command = *app.add_subcommand(
      "inspect",
      "what is there, whether it can be used, and why not; reads headers only, but\n"
      "a surface whole");
  command.add_option("INPUT", inspect.input, "a folder or file")->required();
  command.add_flag("--json", inspect.as_json, "as JSON");
  add_read_options(command, inspect.read);
  add_unit_option(command, inspect.unit);
  return command;
}

namespace {

void print_json(const Findings& findings, const std::optional<Forecast>& forecast) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& series : findings.series) list.push_back(to_json(series, findings));
  nlohmann::json found = {{"series", list}};
  if (forecast) found["reconstruction"] = to_json(*forecast);
  if (!findings.views.empty()) found["views"] = to_json(findings.views);
  fmt::print("{}\n", found.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

void inspect_scan(const std::string& input, const Config& config, bool as_json) {
  Findings findings{segmentation::inspect(input, config.input), {}};
  const auto any = [&](auto what) {
    return std::any_of(findings.series.begin(), findings.series.end(), what);
  };
  std::optional<Forecast> forecast;
  findings.has_volume = any([](const auto& series) { return series.usable; });
  if (any([](const auto& series) { return series.projection.has_value(); })) {
    forecast = forecast_of(input, config);
    findings.views = segmentation::list_views(input, config.input);
    findings.has_run = forecast.has_value();
    findings.has_views = segmentation::are_views(input, config.input) &&
                         std::count_if(findings.views.begin(), findings.views.end(),
                                       [](const auto& v) { return v.problem.empty(); }) > 1;
  }
  if (as_json) {
    print_json(findings, forecast);
  } else {
    for (std::size_t i = 0; i < findings.series.size(); ++i)
      print_series(i + 1, findings.series[i], findings);
    if (forecast) print_forecast(*forecast);
    print_views(findings.views);
  }
}

}  // namespace

int do_inspect(const InspectArguments& arguments) {
  Config config;
  if (!arguments.unit.empty()) apply_setting(config, "input.unit=" + arguments.unit);
  apply_read_options(config, arguments.read);
  const std::vector<std::string> files = files_instead_of_dicom(arguments.input, config.input);
  const std::string input = files.size() == 1 ? files.front() : arguments.input;
  const InputKind kind = input_kind(input);
  if (kind == InputKind::surface) {
    inspect_surface(input, config.surface_unit, arguments.as_json);
    return int(ExitCode::done);
  }
  if (kind == InputKind::phantom)
    throw Error(ExitCode::usage, "a phantom has nothing to inspect. See `angio phantom --help`");
  if (files.size() > 1 && std::none_of(files.begin(), files.end(), segmentation::is_volume_file))
    refuse_several(input, files);
  config.input.unit = config.surface_unit;
  inspect_scan(input, config, arguments.as_json);
  if (files.size() > 1 && !arguments.as_json)
    tell("`angio run` takes one of these files, not their folder: `angio run {} -o CASE`",
         files.front());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
