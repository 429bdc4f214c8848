#include "reconstruction/reconstruction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/collimator.hpp"
#include "reconstruction/detail/few_views.hpp"
#include "reconstruction/detail/frame_checks.hpp"
#include "reconstruction/detail/gating.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/detail/plane_frames.hpp"
#include "reconstruction/detail/seen_field.hpp"
#include "reconstruction/detail/self_calibration.hpp"
#include "reconstruction/detail/volume_task.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;

void check(const std::vector<angiogram::ConeBeamFrame>& frames) {
  ANGIO_EXPECT(!frames.empty());
  for (const angiogram::ConeBeamFrame& frame : frames)
    if (frame.columns != frames.front().columns || frame.rows != frames.front().rows)
      throw InputError("the frames of the run differ in size. Give one run");
  if (frames.front().columns < 16 || frames.front().rows < 16)
    throw InputError("the frames are under 16 pixels wide or high (icons). Give the run itself");
}

void check_views(const std::vector<angiogram::ConeBeamFrame>& frames) {
  if (int(frames.size()) < kLeastViews)
    throw InputError(fmt::format(
        "the run has {} frames, or so many of one phase of the heart (from fewer than {} sides "
        "vessels look narrowed where they are not). Give a rotational run, 19 frames or more over "
        "180 degrees, or a wider reconstruction.phase_width_percent",
        frames.size(), kLeastViews));
}

RunQuality judge(bool has_masks, const Orbit& orbit, const PlaneGrid& plane, const Field& field) {
  RunQuality quality;
  quality.frame_count = int(orbit.angle.size());
  quality.arc_degrees = orbit.arc() * units::kDegreesPerRadian;
  quality.largest_step_degrees = orbit.largest_step * units::kDegreesPerRadian;
  quality.source_to_isocentre_mm = orbit.radius[orbit.radius.size() / 2];
  quality.shortest_arc_degrees =
      180.0 +
      2.0 * std::asin(field.radius / quality.source_to_isocentre_mm) * units::kDegreesPerRadian;
  quality.pixel_at_isocentre_mm = plane.sample_mm;
  quality.field_radius_mm = field.radius;
  quality.is_subtracted = has_masks;
  return quality;
}

std::string doubt_of_arc(const RunQuality& quality) {
  constexpr double kMostShort = 20.0;
  if (quality.method == Method::few_views ||
      quality.arc_degrees > quality.shortest_arc_degrees - kMostShort)
    return {};
  return fmt::format(
      "the run turns by {:.0f} of the {:.0f} degrees that its field needs: widths are wrong along "
      "the direction that is missing, and streaks may be taken for vessels. Give a run of a longer "
      "arc",
      quality.arc_degrees, quality.shortest_arc_degrees);
}

constexpr double kPoorPixels = 1.5;  ///< vessels of so few pixels have other diameters then

/// Where the frames and the volume do not agree, it tells of no diameter, and of no lesion.
std::string doubt_of_path(const RunQuality& quality) {
  const bool is_fitted = quality.calibration_passes > 0;
  const double residual = is_fitted ? quality.residual_pixels : quality.given_residual_pixels;
  if (residual <= kPoorPixels) return {};
  return fmt::format(
      "the frames see the vessels {:.1f} pixels beside where the volume has them{}: they move, or "
      "the volume is poor. Trust no diameter without looking at the frames "
      "(reconstruction/frames.nrrd, the report's sheet)",
      residual, is_fitted ? "" : ", and the C-arm's path could not be fitted to them");
}

/// What was found of a collimator that no header names.
std::string doubt_of_leaves(const RotationalRun& run) {
  if (!run.open_field) return {};
  const OpenField whole = whole_field(run.frames.front()), open = *run.open_field;
  return fmt::format(
      "a collimator, or a filter before the beam, that the header does not name stands in all "
      "frames: {} columns at the left, {} at the right, {} rows above and {} below were left out. "
      "Look whether it is one (reconstruction/frames.nrrd, the report's sheet)",
      open.first_column, whole.last_column - open.last_column, open.first_row,
      whole.last_row - open.last_row);
}

std::vector<std::string> warnings_of(const RotationalRun& run, const RunQuality& quality) {
  std::vector<std::string> warnings;
  if (quality.arc_degrees < quality.shortest_arc_degrees)
    warnings.push_back(fmt::format(
        "the run turns by {:.0f} degrees; to see all of its field from all sides it would need "
        "{:.0f}. Vessels are blurred along the direction that is missing",
        quality.arc_degrees, quality.shortest_arc_degrees));
  // As many views as a circle over the field has samples across, times pi / 2, leave no streaks.
  const double needed =
      quality.pixel_at_isocentre_mm / quality.field_radius_mm * units::kDegreesPerRadian;
  constexpr double kCoarse = 10.0;
  if (quality.method == Method::few_views)
    warnings.push_back(fmt::format(
        "the vessels alone were fitted to {} frames, up to {:.1f} degrees apart; what is as wide "
        "as bone is not in the volume{}",
        quality.frame_count, quality.largest_step_degrees,
        quality.has_converged ? "" : ", and the fit was ended before it stood still"));
  if (quality.method == Method::few_views && !run.masks)
    warnings.emplace_back(
        "few views and no mask run: where a vessel crosses the edge of a bone it may look narrowed "
        "or cut. Compare a throat with the frames (reconstruction/frames.nrrd, the report's "
        "sheet)");
  if (quality.method != Method::few_views && quality.largest_step_degrees > kCoarse * needed)
    warnings.push_back(fmt::format(
        "there are {} frames, up to {:.1f} degrees apart; streaks come from bright places",
        quality.frame_count, quality.largest_step_degrees));
  if (quality.gating.is_gated)
    warnings.push_back(fmt::format(
        "the vessels move with the heart ({:.0f} beats a minute, told by {}): {} frames of one "
        "phase were taken",
        quality.gating.heart_rate_per_min,
        quality.gating.by_r_waves ? "the R waves" : "the frames themselves", quality.frame_count));
  if (quality.given_residual_pixels > 0.5 && quality.calibration_passes > 0)
    warnings.push_back(fmt::format(
        "{} went {:.1f} pixels beside the path that it was said to go; its path was fitted "
        "to the vessels, to {:.2f} pixels",
        quality.gating.is_gated ? "the C-arm, or the patient's breath," : "the C-arm",
        quality.given_residual_pixels, quality.residual_pixels));
  if (quality.truncated_percent > 0.0)
    warnings.push_back(fmt::format(
        "{:.0f} % of the rows end within the body; they were continued, and attenuation near the "
        "edge of the field is less sure",
        quality.truncated_percent));
  if (!run.masks)
    warnings.emplace_back("scattered radiation is not corrected for: dense places look thinner");
  return warnings;
}

ProjectedBack project_back(const VolumeTask& task, Backend backend, const Progress& progress) {
  return backend == Backend::cuda ? project_back_on_gpu(task, progress)
                                  : project_back_on_cpu(task, progress);
}

constexpr double kSparseDegrees = 3.5;  ///< streaks cost accuracy from here on

/// By the frames as the header has them: where a calibration moves them is no reason to change it.
Method method_for(const ReconstructionOptions& options, const Orbit& orbit) {
  if (options.method != Method::automatic) return options.method;
  return orbit.largest_step * units::kDegreesPerRadian > kFewViewsDegrees ? Method::few_views
                                                                          : Method::fdk;
}

/// The vessels alone, from frames that are few.
void iterate(const RotationalRun& run, double air, const Orbit& orbit, const PlaneGrid& plane,
             const Grids& grids, Reconstruction& result, const Progress& progress) {
  const VesselFrames frames = read_vessel_frames(run, air, orbit, plane, part(progress, 0.0, 0.2));
  const ChosenVoxels voxels = choose_voxels(frames, grids.columns);
  const FewViews found = reconstruct_few_views(frames, voxels, part(progress, 0.25, 1.0));
  result.quality.iterations = found.iterations;
  result.quality.has_converged = found.has_converged;
  result.quality.line_integral_residual = found.residual;
  result.quality.line_integral_noise = frames.noise;
  result.volume.geometry = grids.geometry;
  result.volume.values = to_slices(in_columns(voxels, found.values), grids.columns);
}

/// A volume by the frames' places as they are.
/// @param options  its backend and method settled
Reconstruction reconstruct_once(const RotationalRun& run, double air,
                                const ReconstructionOptions& options, const Progress& progress) {
  const Orbit orbit = fit_orbit(run.frames);
  const PlaneGrid plane = plane_grid(run.frames, orbit);
  const Field field =
      common_field(run.frames, orbit, run.open_field.value_or(whole_field(run.frames.front())));
  const Grids grids = make_grids(orbit, field, plane, options);
  Reconstruction result;
  result.frames = run.frames;
  result.quality = judge(run.masks != nullptr, orbit, plane, field);
  result.quality.method = options.method;
  if (result.quality.method == Method::few_views) {
    iterate(run, air, orbit, plane, grids, result, progress);
    return result;
  }
  ProjectedBack back = project_back({run, orbit, plane, grids.columns, air, options.window},
                                    options.backend, progress);
  result.gpu = back.gpu;
  result.quality.truncated_percent = back.truncated_percent;
  result.volume.geometry = grids.geometry;
  result.volume.values = std::move(back.values);
  fill_outside(grids.columns, result.volume);
  result.quality.noise_per_mm = noise_of(result.volume);
  return result;
}

/// How each frame stands where it sees the vessels as the volume has them.
struct Alignment {
  std::vector<Motion> motions;
  double moved_pixels = 0.0;  ///< root mean square over the frames
  int fitted = 0;
};

/// @param run    its frames as given
/// @param every  which of them are fitted
Alignment align(const RotationalRun& run, double air, const Reconstruction& from,
                const std::vector<Motion>& motions, int every, double blur_pixels,
                const Progress& progress) {
  Alignment alignment{motions, 0.0, 0};
  const std::vector<BrightPoint> points =
      find_bright_points(from.volume, from.quality.noise_per_mm);
  if (points.empty()) return alignment;
  const int count = int(run.frames.size()), at_a_time = frames_at_a_time(run.frames);
  const std::size_t pixels =
      std::size_t(run.frames.front().columns) * std::size_t(run.frames.front().rows);
  std::vector<double> moved(run.frames.size(), 0.0);
  std::vector<char> fitted(run.frames.size(), 0);
  for (int first = 0; first < count; first += at_a_time * every) {
    progress.report(double(first) / count,
                    fmt::format("fitting the C-arm's path, frame {} of {}", first + 1, count));
    std::vector<int> some;
    for (int f = first; f < std::min(count, first + at_a_time * every); f += every)
      some.push_back(f);
    const std::vector<float> integrals =
        every == 1 ? read_line_integrals(run, first, int(some.size()), air)
                   : read_line_integrals(run, some, air);
    parallel_for_uneven(std::ptrdiff_t(some.size()), [&](std::ptrdiff_t n) {
      const std::size_t index = std::size_t(some[std::size_t(n)]);
      const auto begin = integrals.begin() + std::ptrdiff_t(std::size_t(n) * pixels);
      const FrameFit fit = fit_frame(run.frames[index], motions[index],
                                     {begin, begin + std::ptrdiff_t(pixels)}, points, blur_pixels);
      alignment.motions[index] = fit.motion;
      moved[index] = fit.moved_pixels;
      fitted[index] = fit.is_fitted;
    });
  }
  double squares = 0.0;
  for (std::size_t f = 0; f < moved.size(); ++f) {
    squares += moved[f] * moved[f];
    alignment.fitted += fitted[f];
  }
  alignment.moved_pixels = std::sqrt(squares / std::max(1, alignment.fitted));
  return alignment;
}

/// Have frames that were moved lost sight of each other? Then what they were fitted to is no
/// vessel.
bool ran_away(const RotationalRun& run) {
  try {
    common_field(run.frames, fit_orbit(run.frames),
                 run.open_field.value_or(whole_field(run.frames.front())));
    return false;
  } catch (const InputError&) {
    return true;
  }
}

/// Reconstructs, moves the frames, and so on, until they stay.
/// @param is_gated  the vessels breathe from frame to frame, as the C-arm sways
Reconstruction calibrate(const RotationalRun& given_run, double air,
                         const ReconstructionOptions& options, bool is_gated,
                         const Progress& progress) {
  constexpr int kMostPasses = 8;
  constexpr int kFramesToJudge = 24;
  constexpr double kEnough = 0.3;   // of a pixel or a voxel; less may be the noise of the fit
  constexpr double kWorthIt = 0.5;  // of the residual by the header
  constexpr double kSlow = 0.8;     // what is left is noise
  // Breath moves vessels by several of their widths: they are looked for from afar at first.
  constexpr double kBlur = 0.8, kFirstBlur = 1.5, kGatedBlur = 6.0;
  const double first_blur = is_gated ? kGatedBlur : kFirstBlur;
  // How many passes it will take is not known: the first takes up to 0.4, each other one 0.4 of
  // what is left.
  const auto part_of = [&](int pass, double half) {
    return Progress([&progress, pass, half](double fraction, std::string_view what) {
      constexpr double kPart = 0.4;
      progress.report(1.0 - std::pow(1.0 - kPart, pass) * (1.0 - kPart * 0.5 * (half + fraction)),
                      what);
    });
  };
  RotationalRun run = given_run;
  std::vector<Motion> motions(run.frames.size());
  Reconstruction result = reconstruct_once(run, air, options, part_of(0, 0.0));
  const double coarse =
      std::max(1.0, result.volume.geometry.spacing.x / result.quality.pixel_at_isocentre_mm);
  // Some of the frames tell whether there is anything to do.
  const int every = std::max(1, int(run.frames.size()) / kFramesToJudge);
  const Alignment judged =
      align(given_run, air, result, motions, every, coarse * kBlur, part_of(0, 1.0));
  const double given =
      judged.fitted > 0 ? judged.moved_pixels : std::numeric_limits<double>::quiet_NaN();
  double last = given;
  bool was_from_afar = false, is_lost = false;
  int passes = 0;
  Reconstruction as_given;
  for (bool stays = !(given > coarse * kEnough); !stays && !is_lost && passes < kMostPasses;) {
    const double blur = std::max(kBlur, first_blur / double(1 << passes));
    const Alignment found =
        align(given_run, air, result, motions, 1, coarse * blur, part_of(passes, 1.0));
    if (2 * found.fitted < int(run.frames.size())) break;
    stays = passes > 0 && !was_from_afar && found.moved_pixels > kSlow * last;
    was_from_afar = is_gated && blur > kBlur;
    last = found.moved_pixels;
    if (stays) break;
    if (passes == 0) as_given = std::move(result);
    motions = found.motions;
    take_out_common(motions);
    for (std::size_t f = 0; f < motions.size(); ++f)
      run.frames[f] = moved(given_run.frames[f], motions[f]);
    ++passes;
    is_lost = ran_away(run);
    if (!is_lost) result = reconstruct_once(run, air, options, part_of(passes, 0.0));
  }
  if (is_lost || (passes > 0 && last > kWorthIt * given)) {
    // The fit cannot tell the path from its noise: the header's stands.
    result = std::move(as_given);
    run.frames = given_run.frames;
    last = given;
    passes = 0;
  }
  result.quality.given_residual_pixels = given;
  result.quality.residual_pixels = last;
  result.quality.calibration_passes = passes;
  result.frames = run.frames;
  return result;
}

Reconstruction reconstruct_on(Backend backend, const RotationalRun& run, double air,
                              ReconstructionOptions options, bool is_gated,
                              const Progress& progress) {
  options.backend = backend;
  Reconstruction result = options.calibrate ? calibrate(run, air, options, is_gated, progress)
                                            : reconstruct_once(run, air, options, progress);
  // Few views are iterated over by the CPU.
  const bool by_gpu = backend == Backend::cuda && result.quality.method == Method::fdk;
  result.backend = by_gpu ? "cuda" : "cpu";
  if (by_gpu) result.device = gpu_name();
  return result;
}

/// Where the options say; of `automatic` the GPU, and the CPU where there is none or it fails.
Reconstruction reconstruct_anywhere(const RotationalRun& run, double air,
                                    const ReconstructionOptions& options, bool is_gated,
                                    const Progress& progress) {
  if (options.backend == Backend::cuda) require_gpu();
  if (options.backend != Backend::automatic)
    return reconstruct_on(options.backend, run, air, options, is_gated, progress);
  if (gpu_name().empty())
    return reconstruct_on(Backend::cpu, run, air, options, is_gated, progress);
  try {
    return reconstruct_on(Backend::cuda, run, air, options, is_gated, progress);
  } catch (const Error& error) {
    if (error.exit_code() != ExitCode::unavailable) throw;
    Reconstruction result = reconstruct_on(Backend::cpu, run, air, options, is_gated, progress);
    result.warnings.push_back("the CPU was used instead: " + std::string(error.what()));
    return result;
  }
}

}  // namespace

void ReconstructionOptions::validate() const {
  if (!(voxel_mm == 0.0 || (voxel_mm >= 0.05 && voxel_mm <= 5.0)))
    throw OptionError("reconstruction.voxel_mm: must be in [0.05, 5], or 0 for a pixel's size");
  if (!(air >= 0.0 && air < 1e9))
    throw OptionError("reconstruction.air: must be in [0, 1e9); 0 is the brightest pixel");
  if (!(phase_percent >= 0.0 && phase_percent < 100.0))
    throw OptionError("reconstruction.phase_percent: must be in [0, 100)");
  if (!(phase_width_percent >= 2.0 && phase_width_percent <= 100.0))
    throw OptionError("reconstruction.phase_width_percent: must be in [2, 100]");
  if (largest_side < 16 || largest_side > 2048)
    throw OptionError("reconstruction.largest_side: must be in [16, 2048]");
}

RunForecast forecast_run(const std::vector<angiogram::ConeBeamFrame>& frames, bool has_masks,
                         const ReconstructionOptions& options,
                         const std::optional<OpenField>& open) {
  constexpr double kPartOfPixel = 0.1, kPartWhereSparse = 0.2;
  options.validate();
  check(frames);
  check_views(frames);
  const Orbit orbit = fit_orbit(frames);
  const PlaneGrid plane = plane_grid(frames, orbit);
  const Field field = common_field(frames, orbit, open.value_or(whole_field(frames.front())));
  RunForecast forecast;
  forecast.quality = judge(has_masks, orbit, plane, field);
  forecast.quality.method = method_for(options, orbit);
  forecast.grid = make_grids(orbit, field, plane, options).geometry;
  forecast.is_sparse = forecast.quality.largest_step_degrees > kSparseDegrees;
  if (forecast.quality.arc_degrees >= forecast.quality.shortest_arc_degrees)
    forecast.radius_error_mm = (forecast.is_sparse ? kPartWhereSparse : kPartOfPixel) *
                               std::max(plane.sample_mm, forecast.grid.longest_spacing());
  return forecast;
}

std::optional<HeartForecast> forecast_heart(const std::vector<double>& times_s,
                                            const std::vector<double>& r_waves_s,
                                            const ReconstructionOptions& options) {
  if (times_s.size() < 2 || r_waves_s.size() < 2) return {};
  HeartForecast forecast;
  forecast.beats_per_min =
      60.0 * double(r_waves_s.size() - 1) / (r_waves_s.back() - r_waves_s.front());
  forecast.beats = (times_s.back() - times_s.front()) * forecast.beats_per_min / 60.0;
  forecast.phase_frames =
      int(frames_of_phase(cardiac_phases(times_s, r_waves_s), options.phase_percent / 100.0,
                          options.phase_width_percent / 100.0)
              .size());
  return forecast;
}

Reconstruction reconstruct_volume(const RotationalRun& given_run,
                                  const ReconstructionOptions& options, const Progress& progress) {
  RotationalRun run = given_run;
  options.validate();
  ANGIO_EXPECT(run.pictures != nullptr);
  check(run.frames);
  fit_orbit(run.frames);  // refuses what does not turn, before pixels are read
  check_views(run.frames);
  const double air = run.masks ? 1.0 : options.air > 0.0 ? options.air : unattenuated(run);
  std::string doubt_of_field;
  if (!run.open_field) {
    run.open_field = open_field(run);
    doubt_of_field = doubt_of_leaves(run);
  }
  const Gate gate = gate_run(run, air, options, part(progress, 0.0, 0.1));
  const GatedRun gated(run, gate.frames);
  const Progress rest = part(progress, options.gating == Gating::off ? 0.0 : 0.1, 1.0);
  const RotationalRun& taken = gate.quality.is_gated ? gated.run() : run;
  check_views(taken.frames);  // a narrow phase may leave few
  std::vector<std::string> doubts{doubt_of_field, gate.warning, doubt_of_relation(run),
                                  doubt_of_scale(run, air), doubt_of_filling(run)};
  ReconstructionOptions settled = options;
  settled.method = method_for(options, fit_orbit(taken.frames));
  Reconstruction result = reconstruct_anywhere(taken, air, settled, gate.quality.is_gated, rest);
  result.quality.unattenuated = run.masks ? 0.0 : air;
  result.quality.gating = gate.quality;
  result.doubt = doubt_of_arc(result.quality);
  std::string off_the_frames = doubt_of_path(result.quality);
  if (result.doubt.empty())
    result.doubt = std::move(off_the_frames);
  else
    doubts.push_back(std::move(off_the_frames));
  const std::vector<std::string> warnings = warnings_of(run, result.quality);
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  if (!gate.quality.is_gated)
    doubts.push_back(doubt_of_filling(run, air, result.frames, result.volume));
  for (const std::string& doubt : doubts)
    if (!doubt.empty()) result.warnings.push_back(doubt);
  std::vector<angiogram::ConeBeamFrame> frames = run.frames;
  for (std::size_t n = 0; n < gate.frames.size(); ++n)
    frames[std::size_t(gate.frames[n])] = result.frames[n];
  result.frames = std::move(frames);
  result.used = gate.frames;
  return result;
}

}  // namespace angio::reconstruction
