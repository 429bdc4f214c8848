#include "reconstruction/reconstruction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/back_projection.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/detail/plane_frames.hpp"
#include "reconstruction/detail/ramp_filter.hpp"
#include "reconstruction/detail/ray_weights.hpp"
#include "reconstruction/detail/self_calibration.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;
constexpr double kPerDegree = 180.0 / units::kPi;
/// Frames in memory at a time: their filtered values stay in the processor's cache while all voxels
/// are gone through.
constexpr std::size_t kBytesAtATime = std::size_t(16) << 20;

void check(const std::vector<angiogram::ConeBeamFrame>& frames) {
  ANGIO_EXPECT(!frames.empty());
  for (const angiogram::ConeBeamFrame& frame : frames)
    if (frame.columns != frames.front().columns || frame.rows != frames.front().rows)
      throw InputError("the frames of the run differ in size. Give one run");
  if (frames.front().columns < 16 || frames.front().rows < 16)
    throw InputError("the frames are under 16 pixels wide or high (icons). Give the run itself");
}

/// What every frame sees around the axis.
struct Field {
  double radius = 0.0, low = 0.0, high = 0.0;  ///< [mm], along the axis from the isocentre
};

Field common_field(const std::vector<angiogram::ConeBeamFrame>& frames, const Orbit& orbit) {
  Field field{1e9, -1e9, 1e9};
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double half = seen_half_width(frames[f], orbit, f), away = orbit.radius[f];
    field.radius = std::min(field.radius, half * away / std::hypot(half, away));
    const SeenHeight seen = seen_height(frames[f], orbit, f);
    field.low = std::max(field.low, seen.low);
    field.high = std::min(field.high, seen.high);
  }
  if (!(field.radius > 0.0) || !(field.high > field.low))
    throw InputError(
        "no place around the axis is seen by every frame (the detector is off the axis, or its "
        "distances are wrong). Check the distances and the geometry");
  return field;
}

struct Grids {
  ColumnGrid columns;
  VolumeGeometry geometry;
};

/// Voxels over the field, in whole voxels around the isocentre.
Grids make_grids(const Orbit& orbit, const Field& field, const PlaneGrid& plane,
                 const ReconstructionOptions& options) {
  const double height = field.high - field.low, side = std::max(2.0 * field.radius, height);
  const double voxel = options.voxel_mm > 0.0
                           ? options.voxel_mm
                           : std::max(plane.sample_mm, side / options.largest_side);
  const auto count = [&](double length) { return std::max(2, int(length / voxel)); };
  Grids grids;
  ColumnGrid& c = grids.columns;
  c.i_count = c.j_count = count(2.0 * field.radius);
  c.k_count = count(height);
  c.voxel = float(voxel);
  const auto first = [&](int n) { return -0.5 * (n - 1) * voxel; };
  const double middle = 0.5 * (field.low + field.high);
  c.first_x = c.first_y = float(first(c.i_count));
  c.first_z = float(middle + first(c.k_count));
  c.field_radius = float(field.radius);
  VolumeGeometry& g = grids.geometry;
  g.size = {c.i_count, c.j_count, c.k_count};
  g.spacing = {voxel, voxel, voxel};
  for (int row = 0; row < 3; ++row) {
    g.direction(row, 0) = orbit.first_direction[row];
    g.direction(row, 1) = orbit.second_direction[row];
    g.direction(row, 2) = orbit.axis[row];
  }
  g.origin = orbit.isocentre + double(c.first_x) * orbit.first_direction +
             double(c.first_y) * orbit.second_direction + double(c.first_z) * orbit.axis;
  return grids;
}

int frames_at_a_time(const RotationalRun& run) {
  const angiogram::ConeBeamFrame& frame = run.frames.front();
  const std::size_t bytes = std::size_t(frame.columns) * std::size_t(frame.rows) * sizeof(float);
  return std::clamp(int(kBytesAtATime / bytes), 4, 32);
}

/// Line integrals of some frames, filtered, on their planes.
class FrameFilter {
 public:
  FrameFilter(const RotationalRun& run, const Orbit& orbit, const PlaneGrid& plane, double air,
              FilterWindow window)
      : run_(run),
        orbit_(orbit),
        plane_(plane),
        air_(air),
        ramp_(plane.u_count, plane.sample_mm, window) {}

  FilteredFrames filter(int first, int count);
  [[nodiscard]] double truncated_percent() const {
    return rows_ == 0 ? 0.0 : 100.0 * double(truncated_) / double(rows_);
  }

 private:
  void filter_rows(std::vector<float>& plane, std::size_t frame, const PlaneFrame& place,
                   std::size_t& truncated) const;

  const RotationalRun& run_;
  const Orbit& orbit_;
  PlaneGrid plane_;
  double air_;
  RampFilter ramp_;
  std::size_t rows_ = 0, truncated_ = 0;
};

void FrameFilter::filter_rows(std::vector<float>& plane, std::size_t frame, const PlaneFrame& place,
                              std::size_t& truncated) const {
  const std::size_t width = std::size_t(plane_.u_count);
  std::vector<double> across(width);
  for (std::size_t i = 0; i < width; ++i)
    across[i] = double(place.first_u) + double(i) * plane_.sample_mm;
  const std::vector<float> weights = ray_weights(orbit_, frame, across);
  const float arc = float(orbit_.step[frame]);
  const double radius = orbit_.radius[frame];
  RampFilter::Workspace workspace(ramp_);
  for (int j = 0; j < plane_.v_count; ++j) {
    float* row = plane.data() + std::size_t(j) * width;
    truncated += is_truncated(row, plane_.u_count);
    const double v = double(place.first_v) + j * plane_.sample_mm - double(place.height);
    for (std::size_t i = 0; i < width; ++i)
      row[i] *=
          weights[i] * float(radius / std::sqrt(radius * radius + across[i] * across[i] + v * v));
    ramp_.filter(row, workspace);
    for (std::size_t i = 0; i < width; ++i) row[i] *= arc;
  }
}

FilteredFrames FrameFilter::filter(int first, int count) {
  const std::size_t pixels =
      std::size_t(run_.frames.front().columns) * std::size_t(run_.frames.front().rows);
  const std::vector<float> pictures = read_line_integrals(run_, first, count, air_);
  FilteredFrames filtered;
  filtered.u_count = plane_.u_count;
  filtered.v_count = plane_.v_count;
  filtered.frames.resize(std::size_t(count));
  const std::size_t samples = std::size_t(plane_.u_count) * std::size_t(plane_.v_count);
  filtered.values.resize(samples * std::size_t(count));
  std::vector<std::size_t> truncated(std::size_t(count), 0);
  parallel_for(count, [&](std::ptrdiff_t n) {
    const std::size_t index = std::size_t(first) + std::size_t(n);
    const angiogram::ConeBeamFrame& frame = run_.frames[index];
    const float* picture = pictures.data() + std::size_t(n) * pixels;
    std::vector<float> plane = bring_onto_plane(picture, frame, orbit_, index, plane_);
    const PlaneFrame place = place_on_plane(frame, orbit_, index, plane_);
    filter_rows(plane, index, place, truncated[std::size_t(n)]);
    filtered.frames[std::size_t(n)] = place;
    float* turned = filtered.values.data() + std::size_t(n) * samples;
    for (int j = 0; j < plane_.v_count; ++j)
      for (int i = 0; i < plane_.u_count; ++i)
        turned[std::size_t(i) * std::size_t(plane_.v_count) + std::size_t(j)] =
            plane[std::size_t(j) * std::size_t(plane_.u_count) + std::size_t(i)];
  });
  rows_ += std::size_t(count) * std::size_t(plane_.v_count);
  for (const std::size_t rows : truncated) truncated_ += rows;
  return filtered;
}

/// Columns of voxels as a volume; those outside the field get the median of what is inside.
Volume<float> to_volume(const Grids& grids, std::vector<float> sums) {
  const ColumnGrid& c = grids.columns;
  const auto is_inside = [&](int i, int j) {
    const float x = c.first_x + float(i) * c.voxel, y = c.first_y + float(j) * c.voxel;
    return x * x + y * y <= c.field_radius * c.field_radius;
  };
  const auto column = [&](int i, int j) {
    return sums.data() +
           (std::size_t(j) * std::size_t(c.i_count) + std::size_t(i)) * std::size_t(c.k_count);
  };
  std::vector<float> some;
  constexpr int kEvery = 5;
  for (int j = 0; j < c.j_count; j += kEvery)
    for (int i = 0; i < c.i_count; i += kEvery)
      for (int k = 0; is_inside(i, j) && k < c.k_count; k += kEvery)
        some.push_back(column(i, j)[k]);
  float median = 0.0F;
  if (!some.empty()) {
    std::nth_element(some.begin(), some.begin() + std::ptrdiff_t(some.size() / 2), some.end());
    median = some[some.size() / 2];
  }
  Volume<float> volume(grids.geometry, median);
  parallel_for(c.k_count, [&](std::ptrdiff_t k) {
    for (int j = 0; j < c.j_count; ++j)
      for (int i = 0; i < c.i_count; ++i)
        if (is_inside(i, j)) volume.at(i, j, int(k)) = column(i, j)[k];
  });
  return volume;
}

/// From the median of the differences between neighbours along i: 0.6745 sqrt(2) sd of the noise.
double noise_of(const Volume<float>& volume) {
  std::vector<float> steps;
  const auto& size = volume.geometry.size;
  for (int k = 0; k < size[2]; k += 3)
    for (int j = 0; j < size[1]; j += 3)
      for (int i = 1; i < size[0]; i += 3) {
        const float step = std::abs(volume.at(i, j, k) - volume.at(i - 1, j, k));
        if (step > 0.0F) steps.push_back(step);
      }
  if (steps.empty()) return 0.0;
  std::nth_element(steps.begin(), steps.begin() + std::ptrdiff_t(steps.size() / 2), steps.end());
  return double(steps[steps.size() / 2]) / (0.6745 * std::sqrt(2.0));
}

RunQuality judge(bool has_masks, const Orbit& orbit, const PlaneGrid& plane, const Field& field) {
  RunQuality quality;
  quality.frame_count = int(orbit.angle.size());
  quality.arc_degrees = orbit.arc() * kPerDegree;
  quality.largest_step_degrees = orbit.largest_step * kPerDegree;
  quality.source_to_isocentre_mm = orbit.radius[orbit.radius.size() / 2];
  quality.shortest_arc_degrees =
      180.0 + 2.0 * std::asin(field.radius / quality.source_to_isocentre_mm) * kPerDegree;
  quality.pixel_at_isocentre_mm = plane.sample_mm;
  quality.field_radius_mm = field.radius;
  quality.is_subtracted = has_masks;
  return quality;
}

std::vector<std::string> warnings_of(const RotationalRun& run, const RunQuality& quality) {
  std::vector<std::string> warnings;
  if (quality.arc_degrees < quality.shortest_arc_degrees)
    warnings.push_back(fmt::format(
        "the run turns by {:.0f} degrees; to see all of its field from all sides it would need "
        "{:.0f}. Vessels are blurred along the direction that is missing",
        quality.arc_degrees, quality.shortest_arc_degrees));
  // As many views as a circle over the field has samples across, times pi / 2, leave no streaks.
  const double needed = quality.pixel_at_isocentre_mm / quality.field_radius_mm * kPerDegree;
  constexpr double kCoarse = 10.0;
  if (quality.largest_step_degrees > kCoarse * needed)
    warnings.push_back(fmt::format(
        "there are {} frames, up to {:.1f} degrees apart; streaks come from bright places",
        quality.frame_count, quality.largest_step_degrees));
  if (quality.given_residual_pixels > 0.5)
    warnings.push_back(fmt::format(
        "the C-arm went {:.1f} pixels beside the path that its header tells; its path was fitted "
        "to the vessels, to {:.2f} pixels",
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

/// A volume by the frames' places as they are.
Reconstruction reconstruct_once(const RotationalRun& run, double air,
                                const ReconstructionOptions& options, const Progress& progress) {
  const Orbit orbit = fit_orbit(run.frames);
  const PlaneGrid plane = plane_grid(run.frames, orbit);
  const Field field = common_field(run.frames, orbit);
  const Grids grids = make_grids(orbit, field, plane, options);
  Reconstruction result;
  result.frames = run.frames;
  result.quality = judge(run.masks != nullptr, orbit, plane, field);
  FrameFilter filter(run, orbit, plane, air, options.window);
  std::vector<float> sums(grids.geometry.voxel_count(), 0.0F);
  const int count = int(run.frames.size()), at_a_time = frames_at_a_time(run);
  for (int first = 0; first < count; first += at_a_time) {
    const int number = std::min(at_a_time, count - first);
    progress.report(double(first) / count,
                    fmt::format("projecting back, frame {} of {}", first + 1, count));
    back_project(filter.filter(first, number), grids.columns, sums);
  }
  result.quality.truncated_percent = filter.truncated_percent();
  result.volume = to_volume(grids, std::move(sums));
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
  const int count = int(run.frames.size()), at_a_time = frames_at_a_time(run);
  const std::size_t pixels =
      std::size_t(run.frames.front().columns) * std::size_t(run.frames.front().rows);
  std::vector<double> moved(run.frames.size(), 0.0);
  std::vector<char> fitted(run.frames.size(), 0);
  for (int first = 0; first < count; first += at_a_time) {
    const int number = std::min(at_a_time, count - first);
    progress.report(double(first) / count,
                    fmt::format("fitting the C-arm's path, frame {} of {}", first + 1, count));
    const std::vector<float> integrals = read_line_integrals(run, first, number, air);
    parallel_for_uneven(number, [&](std::ptrdiff_t n) {
      const std::size_t index = std::size_t(first) + std::size_t(n);
      if (index % std::size_t(every) != 0) return;
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

/// Reconstructs, moves the frames, and so on, until they stay.
Reconstruction calibrate(const RotationalRun& given_run, double air,
                         const ReconstructionOptions& options, const Progress& progress) {
  constexpr int kMostPasses = 8;
  constexpr int kFramesToJudge = 24;
  constexpr double kEnough = 0.3;   // of a pixel or a voxel; less may be the noise of the fit
  constexpr double kWorthIt = 0.5;  // of the residual by the header
  constexpr double kSlow = 0.8;     // what is left is noise
  constexpr double kFirstBlur = 1.5, kBlur = 0.8;
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
  int passes = 0;
  Reconstruction as_given;
  for (bool stays = !(given > coarse * kEnough); !stays && passes < kMostPasses;) {
    const Alignment found =
        align(given_run, air, result, motions, 1, coarse * (passes == 0 ? kFirstBlur : kBlur),
              part_of(passes, 1.0));
    if (2 * found.fitted < int(run.frames.size())) break;
    stays = passes > 0 && found.moved_pixels > kSlow * last;
    last = found.moved_pixels;
    if (stays) break;
    if (passes == 0) as_given = std::move(result);
    motions = found.motions;
    take_out_common(motions);
    for (std::size_t f = 0; f < motions.size(); ++f)
      run.frames[f] = moved(given_run.frames[f], motions[f]);
    result = reconstruct_once(run, air, options, part_of(++passes, 0.0));
  }
  if (passes > 0 && last > kWorthIt * given) {
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

}  // namespace

void ReconstructionOptions::validate() const {
  if (!(voxel_mm == 0.0 || (voxel_mm >= 0.05 && voxel_mm <= 5.0)))
    throw OptionError("reconstruction.voxel_mm: must be in [0.05, 5], or 0 for a pixel's size");
  if (!(air >= 0.0 && air < 1e9))
    throw OptionError("reconstruction.air: must be in [0, 1e9); 0 is the brightest pixel");
  if (largest_side < 16 || largest_side > 2048)
    throw OptionError("reconstruction.largest_side: must be in [16, 2048]");
}

RunForecast forecast_run(const std::vector<angiogram::ConeBeamFrame>& frames, bool has_masks,
                         const ReconstructionOptions& options) {
  constexpr double kSparseDegrees = 3.5;
  constexpr double kPartOfPixel = 0.1, kPartWhereSparse = 0.2;
  options.validate();
  check(frames);
  const Orbit orbit = fit_orbit(frames);
  const PlaneGrid plane = plane_grid(frames, orbit);
  const Field field = common_field(frames, orbit);
  RunForecast forecast;
  forecast.quality = judge(has_masks, orbit, plane, field);
  forecast.grid = make_grids(orbit, field, plane, options).geometry;
  forecast.is_sparse = forecast.quality.largest_step_degrees > kSparseDegrees;
  if (forecast.quality.arc_degrees >= forecast.quality.shortest_arc_degrees)
    forecast.radius_error_mm = (forecast.is_sparse ? kPartWhereSparse : kPartOfPixel) *
                               std::max(plane.sample_mm, forecast.grid.longest_spacing());
  return forecast;
}

Reconstruction reconstruct_volume(const RotationalRun& run, const ReconstructionOptions& options,
                                  const Progress& progress) {
  options.validate();
  ANGIO_EXPECT(run.pictures != nullptr);
  check(run.frames);
  fit_orbit(run.frames);  // refuses what does not turn, before pixels are read
  const double air = run.masks ? 1.0 : options.air > 0.0 ? options.air : unattenuated(run);
  Reconstruction result = options.calibrate ? calibrate(run, air, options, progress)
                                            : reconstruct_once(run, air, options, progress);
  result.quality.unattenuated = run.masks ? 0.0 : air;
  result.warnings = warnings_of(run, result.quality);
  return result;
}

}  // namespace angio::reconstruction
