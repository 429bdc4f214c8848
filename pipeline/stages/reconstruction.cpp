#include "reconstruction/reconstruction.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/nrrd.hpp"
#include "pipeline/stages/loaded_frames.hpp"
#include "pipeline/stages/reconstruction.hpp"
#include "pipeline/stages/views.hpp"
#include "reconstruction/geometry_file.hpp"
#include "reconstruction/shown_frames.hpp"
#include "segmentation/read_run.hpp"
#include "segmentation/read_views.hpp"

namespace angio::pipeline {
namespace {

using angiogram::ConeBeamFrame;
using segmentation::LoadedRun;

/// How the picture lies that was turned clockwise by a quarter.
ConeBeamFrame turned(const ConeBeamFrame& frame) {
  return {frame.source,    frame.place(0, frame.rows - 1),
          -frame.row_step, frame.column_step,
          frame.rows,      frame.columns};
}

ConeBeamFrame mirrored(const ConeBeamFrame& frame) {
  return {frame.source,       frame.place(frame.columns - 1, 0),
          -frame.column_step, frame.row_step,
          frame.columns,      frame.rows};
}

std::vector<ConeBeamFrame> frames_by_file(const LoadedRun& loaded,
                                          const std::filesystem::path& file) {
  std::vector<ConeBeamFrame> frames = reconstruction::read_geometry(
      file, {{loaded.columns, loaded.rows}, loaded.run.detector_spacing_mm, loaded.first_pixel_mm});
  if (int(frames.size()) != loaded.frame_count)
    throw InputError(
        fmt::format("the geometry file {} holds {} frames, the run {} (it is another "
                    "run's). Give the one that belongs to it",
                    file.filename().string(), frames.size(), loaded.frame_count));
  return frames;
}

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

/// @param used  frames of the run, numbered from 0
nlohmann::json to_json(const reconstruction::GatingQuality& gating, const std::vector<int>& used,
                       const reconstruction::ReconstructionOptions& options) {
  nlohmann::json frames = nlohmann::json::array();
  for (const int frame : used) frames.push_back(frame + 1);
  return {
      {"gated", gating.is_gated},
      {"by_r_waves", gating.by_r_waves},
      {"heart_rate_per_min", gating.heart_rate_per_min > 0.0
                                 ? nlohmann::json(gating.heart_rate_per_min)
                                 : nlohmann::json()},
      {"beats", gating.beats},
      {"motion_rms_mm", gating.signal_rms_mm},
      {"motion_f_ratio", gating.signal_f_ratio},
      {"phase_percent", gating.is_gated ? nlohmann::json(options.phase_percent) : nlohmann::json()},
      {"frames_used", frames}};
}

nlohmann::json to_json(const reconstruction::Reconstruction& result) {
  const reconstruction::RunQuality& q = result.quality;
  return {{"frames", q.frame_count},
          {"arc_degrees", q.arc_degrees},
          {"shortest_arc_degrees", q.shortest_arc_degrees},
          {"largest_step_degrees", q.largest_step_degrees},
          {"source_to_isocentre_mm", q.source_to_isocentre_mm},
          {"pixel_at_isocentre_mm", q.pixel_at_isocentre_mm},
          {"field_radius_mm", q.field_radius_mm},
          {"unattenuated", q.is_subtracted ? nlohmann::json() : nlohmann::json(q.unattenuated)},
          {"truncated_percent", q.truncated_percent},
          {"noise_per_mm", number(q.noise_per_mm)},
          {"method", reconstruction::kMethodNames[int(q.method)]},
          {"iterations", q.iterations},
          {"converged", q.has_converged},
          {"line_integral_residual", number(q.line_integral_residual)},
          {"line_integral_noise", number(q.line_integral_noise)},
          {"subtracted", q.is_subtracted},
          {"given_residual_pixels", number(q.given_residual_pixels)},
          {"residual_pixels", number(q.residual_pixels)},
          {"calibration_passes", q.calibration_passes},
          {"doubt", result.doubt.empty() ? nlohmann::json() : nlohmann::json(result.doubt)},
          {"backend", result.backend},
          {"device", result.device.empty() ? nlohmann::json() : nlohmann::json(result.device)}};
}

}  // namespace

void write_shown_frames(const std::filesystem::path& out, const reconstruction::ShownFrames& shown,
                        bool is_subtracted) {
  formats::write_nrrd(out / "frames.nrrd", shown.pictures, formats::NrrdEncoding::gzip);
  nlohmann::json places = nlohmann::json::array();
  for (std::size_t n = 0; n < shown.frames.size(); ++n)
    places.push_back({{"frame", shown.indices[n] + 1},
                      {"matrix", angiogram::ConeBeamView(shown.frames[n]).matrix()}});
  write_text_atomically(
      out / "frames.json",
      nlohmann::json{{"subtracted", is_subtracted}, {"frames", places}}.dump(2) + "\n");
}

std::vector<double> in_seconds(std::vector<double> times_ms) {
  constexpr double kMsPerSecond = 1000.0;
  for (double& time : times_ms) time /= kMsPerSecond;
  return times_ms;
}

std::vector<ConeBeamFrame> frames_by_header(const LoadedRun& loaded) {
  const segmentation::ProjectionRun& run = loaded.run;
  const int quarters = ((int(std::lround(run.picture_turn_degrees / 90.0)) % 4) + 4) % 4;
  angiogram::CArmMount mount;
  mount.source_to_detector_mm = run.source_to_detector_mm.value();
  mount.source_to_isocentre_mm = run.source_to_isocentre_mm.value();
  mount.columns = quarters % 2 == 0 ? loaded.columns : loaded.rows;
  mount.rows = quarters % 2 == 0 ? loaded.rows : loaded.columns;
  mount.column_spacing_mm = run.detector_spacing_mm[0];
  mount.row_spacing_mm = run.detector_spacing_mm[1];
  mount.central_column =
      0.5 * (mount.columns - 1) - run.middle_offset_mm[0] / mount.column_spacing_mm;
  mount.central_row = 0.5 * (mount.rows - 1) - run.middle_offset_mm[1] / mount.row_spacing_mm;
  std::vector<ConeBeamFrame> frames;
  for (std::size_t f = 0; f < std::size_t(loaded.frame_count); ++f) {
    ConeBeamFrame frame = angiogram::c_arm_frame(
        {run.primary_angles_degrees[f], run.secondary_angles_degrees[f]}, mount);
    for (int q = 0; q < quarters; ++q) frame = turned(frame);
    frames.push_back(run.picture_is_mirrored ? mirrored(frame) : frame);
  }
  return frames;
}

std::optional<reconstruction::OpenField> open_field_of(const LoadedRun& loaded) {
  const auto& open = loaded.run.open_field;
  if (!open) return {};
  return reconstruction::OpenField{(*open)[0] - 1, (*open)[1] - 1, (*open)[2] - 1, (*open)[3] - 1};
}

reconstruction::RotationalRun rotational_run(const LoadedRun& loaded,
                                             const std::filesystem::path& geometry,
                                             std::vector<std::string>& warnings) {
  reconstruction::RotationalRun run;
  run.frames = geometry.empty() ? frames_by_header(loaded) : frames_by_file(loaded, geometry);
  if (loaded.run.pixel_relation == "LOG")
    run.relation = reconstruction::PixelRelation::logarithmic;
  else if (loaded.run.pixel_relation == "DISP")
    warnings.emplace_back(
        "the run's pixels are scaled for display (Pixel Intensity Relationship DISP); they were "
        "taken to be linear in the beam's intensity, and attenuation is not to scale");
  else if (loaded.run.pixel_relation != "LIN")
    warnings.emplace_back(
        "the run does not say that its pixels are linear in the beam's intensity; they were taken "
        "so, and attenuation is not to scale");
  run.times_s = in_seconds(loaded.run.frame_times_ms);
  run.r_waves_s = in_seconds(loaded.run.r_wave_times_ms);
  run.open_field = open_field_of(loaded);
  return run;
}

void do_reconstruction(StageWork& work, const ReconstructionSettings& settings) {
  if (work.input.empty())
    throw InputError(
        "the case holds no X-ray frames to reconstruct from (they are never copied). Give the "
        "run again: `angio run INPUT -o CASE --from reconstruction`",
        ExitCode::no_input);
  const segmentation::ReadOptions& input = settings.get<&Config::input>();
  const auto geometry = work.geometry.empty() ? segmentation::RunGeometry::by_header
                                              : segmentation::RunGeometry::given;
  std::optional<LoadedRun> loaded;
  if (input.views.empty())
    loaded = segmentation::read_run(work.input, input, geometry, part(work.progress, 0.0, 0.05));
  if (!loaded) {
    const auto views = segmentation::read_views(work.input, input, part(work.progress, 0.0, 0.05));
    if (!views)
      throw InputError(
          "the input holds no rotational run and no views any more (it has changed). Run again");
    return do_views(work, *views, settings);
  }
  keep(work.warnings, loaded->warnings);
  work.input_description = loaded->source_description;
  reconstruction::RotationalRun run = rotational_run(*loaded, work.geometry, work.warnings);
  const LoadedFrames pictures(*loaded->pictures);
  run.pictures = &pictures;
  std::optional<LoadedFrames> masks;
  if (loaded->masks) run.masks = &masks.emplace(*loaded->masks);
  const reconstruction::Reconstruction result = reconstruction::reconstruct_volume(
      run, settings.get<&Config::reconstruction>(), part(work.progress, 0.05, 0.95));
  keep(work.warnings, result.warnings);
  work.progress.report(0.95, "writing");
  formats::write_nrrd(work.out / "volume.nrrd", result.volume, formats::NrrdEncoding::raw);
  write_text_atomically(work.out / "geometry.xml", reconstruction::rtk_geometry(result.frames));
  nlohmann::json quality = to_json(result);
  quality["gating"] =
      to_json(result.quality.gating, result.used, settings.get<&Config::reconstruction>());
  write_text_atomically(work.out / "quality.json", quality.dump(2) + "\n");
  write_shown_frames(work.out, reconstruction::show_frames(run, result), run.masks != nullptr);
}

}  // namespace angio::pipeline
