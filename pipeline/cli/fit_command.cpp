#include "pipeline/cli/fit_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/stages/loaded_frames.hpp"
#include "pipeline/stages/reconstruction.hpp"
#include "pipeline/stages/reporter.hpp"
#include "reconstruction/geometry_file.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// Some frames of a run, as a run.
class SomeFrames : public reconstruction::FrameReader {
 public:
  SomeFrames(const reconstruction::FrameReader& all, const std::vector<int>& chosen)
      : all_(all), chosen_(chosen) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    return all_.read_some({chosen_.begin() + first, chosen_.begin() + first + count});
  }

 private:
  const reconstruction::FrameReader& all_;
  const std::vector<int>& chosen_;
};

void require_files(const fs::path& case_folder) {
  for (const auto& [name, why] :
       {std::pair{file::kGeometry,
                  "its volume was not made of X-ray frames here). Make the case of "
                  "the run: `angio run RUN -o CASE`"},
        std::pair{file::kQuality, "its reconstruction is not done). Run `angio run RUN -o CASE`"},
        std::pair{file::kCenterlines,
                  "its lines are not found yet). Run `angio centerline CASE`"}}) {
    std::error_code ignored;
    if (!fs::exists(case_folder / name, ignored))
      throw InputError(fmt::format("there is no {} ({}", (case_folder / name).string(), why),
                       ExitCode::no_input);
  }
  std::error_code ignored;
  if (fs::exists(case_folder / file::kNarrowedLumen, ignored))
    throw InputError(
        fmt::format("the lines of {} are of a vessel that was narrowed "
                    "(lesion.narrow_percent), which no frame shows. Fit the case "
                    "that it was made of",
                    case_folder.string()));
}

/// Those that the case's volume was made of, numbered from 0.
std::vector<int> used_frames(const json& quality, int frame_count) {
  std::vector<int> used;
  for (const json& frame : quality.at("gating").at("frames_used")) {
    used.push_back(frame.get<int>() - 1);
    if (used.back() < 0 || used.back() >= frame_count)
      throw InputError(
          fmt::format("{} names frame {} of {} (another run was given than the case was made of). "
                      "Give that one",
                      file::kQuality, used.back() + 1, frame_count));
  }
  if (used.empty()) {
    used.resize(std::size_t(frame_count));
    std::iota(used.begin(), used.end(), 0);
  }
  return used;
}

/// A lumen whose area's circle is wider by so much than what fits into it is flat: the frames tell
/// areas, and the fit knows round lumens alone.
constexpr double kFlat = 0.25;

/// What a lesion of the case measures in the fitted tree, between the same points of its line.
json measure(const json& lesion, const CenterlineTree& before, const reconstruction::TreeFit& fit) {
  const int id = lesion.at("centerline_id").get<int>();
  const auto path = std::find_if(before.paths.begin(), before.paths.end(),
                                 [&](const CenterlinePath& one) { return one.id == id; });
  if (path == before.paths.end())
    throw InputError(fmt::format("{} names line {}, which {} has not. Run `angio centerline CASE`",
                                 file::kLesions, id, file::kCenterlines));
  const auto index = std::size_t(path - before.paths.begin());
  const auto point_at = [&](const char* name) {
    const auto& along = path->abscissa;
    const auto at = std::lower_bound(along.begin(), along.end(), lesion.at(name).get<double>());
    return std::size_t(std::min(at, along.end() - 1) - along.begin());
  };
  const CenterlinePath& fitted = fit.tree.paths[index];
  const std::size_t first = point_at("proximal_mm"), last = point_at("distal_mm");
  std::size_t throat = first;
  for (std::size_t p = first; p <= last; ++p)
    if (fitted.tube_radius[p] < fitted.tube_radius[throat]) throat = p;
  const double diameter = 2.0 * fitted.tube_radius[throat];
  const double reference = lesion.at("reference_diameter_mm").get<double>();
  const double sd = 2.0 * fit.radius_sd[index][throat];
  const double by_volume = lesion.at("mld_mm").get<double>();
  return {{"centerline_id", id},
          {"abscissa_mm", fitted.abscissa[throat]},
          {"mld_mm", diameter},
          {"mld_sd_mm", sd},
          {"diameter_stenosis_percent", 100.0 * (1.0 - diameter / reference)},
          {"reference_diameter_mm", reference},
          {"volume_mld_mm", by_volume},
          {"is_flat", diameter > by_volume + std::max(3.0 * sd, kFlat * by_volume)}};
}

json to_json(const reconstruction::TreeFit& fit, const std::vector<int>& used) {
  json frames = json::array();
  for (std::size_t f = 0; f < used.size(); ++f)
    frames.push_back({{"frame", used[f] + 1}, {"contrast_per_mm", fit.contrast_per_mm[f]}});
  return {{"converged", fit.converged},
          {"steps", fit.steps},
          {"noise", fit.noise},
          {"correlation", fit.correlation},
          {"blur_pixels", fit.blur_pixels},
          {"frames", frames}};
}

void tell(Reporter& reporter, const json& lesion) {
  reporter.note(fmt::format(
      "line {} at {:.1f} mm: {:.2f} mm, sd {:.2f} mm, by the frames; {:.2f} mm by the volume{}",
      lesion.at("centerline_id").get<int>(), lesion.at("abscissa_mm").get<double>(),
      lesion.at("mld_mm").get<double>(), lesion.at("mld_sd_mm").get<double>(),
      lesion.at("volume_mld_mm").get<double>(),
      lesion.at("is_flat").get<bool>()
          ? ". The lumen is flat there: the frames' diameter is that of a circle of its area, and "
            "the volume's is its width"
          : ""));
}

void fit_case(const FitArguments& a) {
  Reporter reporter(a.shared.style());
  reporter.begin_stage("fit");
  const Progress progress = reporter.progress();
  const auto loaded = segmentation::read_run(a.run, a.read, segmentation::RunGeometry::given,
                                             part(progress, 0.0, 0.05));
  if (!loaded)
    throw InputError(a.run.string() +
                     " holds no run of X-ray frames. Give the one that the case was made of");
  std::vector<std::string> warnings = loaded->warnings;
  reconstruction::RotationalRun run =
      rotational_run(*loaded, a.case_folder / file::kGeometry, warnings);
  const json quality = read_json(a.case_folder / file::kQuality);
  const std::vector<int> used = used_frames(quality, loaded->frame_count);

  const LoadedFrames all(*loaded->pictures);
  const SomeFrames pictures(all, used);
  std::optional<LoadedFrames> all_masks;
  std::optional<SomeFrames> masks;
  if (loaded->masks) masks.emplace(all_masks.emplace(*loaded->masks), used);
  const std::vector<angiogram::ConeBeamFrame> places = std::exchange(run.frames, {});
  for (const int f : used) run.frames.push_back(places[std::size_t(f)]);
  run.pictures = &pictures;
  run.masks = masks ? &*masks : nullptr;
  run.times_s.clear();
  run.r_waves_s.clear();

  const CenterlineTree before = read_centerlines(a.case_folder / file::kCenterlines);
  const json air = quality.at("unattenuated");
  const reconstruction::TreeFit fit = reconstruction::fit_tree(
      run, air.is_null() ? 0.0 : air.get<double>(), before, a.fit, part(progress, 0.05, 0.95));
  if (!fit.converged)
    warnings.push_back(fmt::format("the fit has not converged in {} steps", fit.steps));
  for (const std::string& warning : warnings) reporter.warn("fit", warning);

  json result = to_json(fit, used);
  result["lesions"] = json::array();
  for (const json& lesion : read_json(a.case_folder / file::kLesions)) {
    result["lesions"].push_back(measure(lesion, before, fit));
    tell(reporter, result["lesions"].back());
  }
  write_centerlines(a.folder / "centerlines.vtp", fit.tree, fit.radius_sd);
  write_text_atomically(a.folder / "geometry.xml", reconstruction::rtk_geometry(fit.frames));
  write_text_atomically(a.folder / "fit.json", result.dump(2) + "\n");
  reporter.result((a.folder / "fit.json").string());
}

}  // namespace

CLI::App& add_fit_command(CLI::App& app, FitArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "fit",
      "the lines and radii of a case of a rotational run, fitted to its X-ray frames:\n"
      "centerlines.vtp with each radius' standard deviation, geometry.xml, fit.json");
  command.add_option("CASE", a.case_folder, "the case's folder")->required();
  command.add_option("RUN", a.run, "the rotational run that the case was made of")->required();
  command.add_option("-o,--output", a.folder, "folder of the results")
      ->required()
      ->type_name("DIR");
  command.add_option("--series", a.read.series, "run of a DICOM folder, from `angio inspect`");
  command.add_flag("--allow-lossy", a.read.allow_lossy, "also frames compressed with loss");
  command
      .add_option("--node-spacing", a.fit.node_spacing_mm,
                  "between places where a line may bend and its radius change, mm, 0.2 to 10; "
                  "0: half the mean radius, at least a pixel")
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--shift", a.fit.frame_shift_sd_mm,
                  "how far a frame may have been taken from its place, sd, mm, 0 to 20")
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--turn", a.fit.frame_turn_sd_degrees, "and how far turned, sd, degrees, 0 to 20")
      ->type_name("DEG")
      ->capture_default_str();
  add_output_options(command, a.shared);
  return command;
}

int do_fit(const FitArguments& a) {
  a.fit.validate();
  require_files(a.case_folder);
  try {
    fit_case(a);
  } catch (const json::exception&) {
    throw InputError(
        fmt::format("{} or {} in {} is damaged, or of an older program. Make the case "
                    "again: `angio run RUN -o CASE --from reconstruction`",
                    file::kQuality, file::kLesions, a.case_folder.string()));
  }
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
