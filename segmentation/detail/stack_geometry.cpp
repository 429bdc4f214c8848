#include "segmentation/detail/stack_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/statistics.hpp"
#include "core/units.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kOrthogonalTolerance = 1e-3;  ///< dot product of axes that are rounded decimals
constexpr double kParallelTolerance = 1e-4;    ///< difference of two slices' axes
constexpr double kPlaceTolerance = 0.01;       ///< of the spacing: counts as regular
constexpr double kPlaceLimit = 0.05;           ///< of the spacing: usable, with a warning
constexpr double kTiltedPlaceLimit = 0.5;      ///< of a pixel, sideways
constexpr double kTiltLimitDegrees = 0.1;
constexpr double kTiltMostDegrees = 45.0;  ///< gantries tilt by 30
constexpr double kLateralLimit = 0.1;      ///< of a pixel
constexpr double kSamePlace = 0.05;        ///< of the usual step
constexpr double kRounding = 1e-3;         ///< of positions written as decimals [mm]
constexpr double kSameAxisShift = 1e-3;    ///< of a pixel: not worth an interpolation
constexpr int kMostSlicesPerGap = 1000;

std::string incomplete_geometry(const std::vector<DicomFrame>& frames) {
  for (const auto& frame : frames) {
    const char* missing = !frame.has_spacing       ? "the pixel spacing"
                          : !frame.has_orientation ? "the image orientation"
                          : !frame.has_position    ? "the image position"
                                                   : nullptr;
    if (missing)
      return std::string(missing) +
             " is missing (without it no length can be measured; anonymisation may have removed "
             "it). Export the series with its geometry, or state the voxel size with --spacing";
    if (!(frame.spacing_i > 1e-4 && frame.spacing_j > 1e-4 && frame.spacing_i < 100.0 &&
          frame.spacing_j < 100.0))
      return "the pixel spacing is impossible (" + format_number(frame.spacing_j) + " x " +
             format_number(frame.spacing_i) + " mm). Export the series again";
    if (std::abs(norm(frame.axis_i) - 1.0) > kOrthogonalTolerance ||
        std::abs(norm(frame.axis_j) - 1.0) > kOrthogonalTolerance ||
        std::abs(dot(frame.axis_i, frame.axis_j)) > kOrthogonalTolerance)
      return "the image orientation is not two unit axes at right angles (the header is damaged). "
             "Export the series again";
    if (!(norm(frame.position) < 1e5))
      return "the image position is impossible (over 100 m away; the header is damaged). Export "
             "the series again";
  }
  return {};
}

std::string unlike_frames(const std::vector<DicomFrame>& frames) {
  const DicomFrame& first = frames.front();
  for (const auto& frame : frames) {
    if (norm(frame.axis_i - first.axis_i) > kParallelTolerance ||
        norm(frame.axis_j - first.axis_j) > kParallelTolerance)
      return "its slices have different orientations (they are not one stack). Choose a series of "
             "parallel slices";
    if (std::abs(frame.spacing_i - first.spacing_i) > 1e-6 * first.spacing_i ||
        std::abs(frame.spacing_j - first.spacing_j) > 1e-6 * first.spacing_j)
      return "its slices have different pixel spacings (they are not one stack). Choose a series "
             "of like slices";
  }
  return {};
}

/// Unit axes at exactly right angles, as near as possible to the written ones; the columns.
Mat3 orthonormal_axes(const DicomFrame& frame) {
  const Vec3 i = normalized(frame.axis_i);
  const Vec3 k = normalized(cross(i, frame.axis_j));
  const Vec3 j = cross(k, i);
  return {{{i.x, j.x, k.x}, {i.y, j.y, k.y}, {i.z, j.z, k.z}}};
}

/// The slices on the axes of the grid, sorted along its normal.
struct SortedSlices {
  Mat3 axes;
  std::vector<int> order;
  std::vector<Vec3> places;  ///< (along i, along j, height) [mm]
  std::vector<double> steps;
  double usual_step = 0.0;
};

SortedSlices sort_slices(const std::vector<DicomFrame>& frames) {
  SortedSlices sorted;
  sorted.axes = orthonormal_axes(frames.front());
  sorted.order.resize(frames.size());
  std::iota(sorted.order.begin(), sorted.order.end(), 0);
  std::vector<Vec3> places;
  for (const auto& frame : frames) places.push_back(transpose(sorted.axes) * frame.position);
  std::stable_sort(sorted.order.begin(), sorted.order.end(), [&](int a, int b) {
    return places[std::size_t(a)].z < places[std::size_t(b)].z;
  });
  for (int f : sorted.order) sorted.places.push_back(places[std::size_t(f)]);
  for (std::size_t k = 0; k + 1 < sorted.places.size(); ++k)
    sorted.steps.push_back(sorted.places[k + 1].z - sorted.places[k].z);
  std::vector<double> forward;  // copies lie at the same place but for rounding
  for (const double step : sorted.steps)
    if (step > kRounding) forward.push_back(step);
  if (!forward.empty()) sorted.usual_step = median(forward);
  return sorted;
}

/// Whether the next slice lies at the same place.
bool is_no_step(const SortedSlices& slices, double step) {
  return step < std::max(kRounding, kSamePlace * slices.usual_step);
}

std::string repeated_heights(const SortedSlices& slices) {
  const auto same = std::count_if(slices.steps.begin(), slices.steps.end(),
                                  [&](double step) { return is_no_step(slices, step); });
  if (same == 0) return {};
  return std::to_string(same) +
         (same == 1 ? " slice repeats a position" : " slices repeat positions") +
         " (several phases or reconstructions in one series, or copies that differ). Export one "
         "phase alone";
}

std::string uneven_heights(const SortedSlices& slices) {
  const double usual = slices.usual_step;
  for (std::size_t k = 0; k < slices.steps.size(); ++k) {
    const double step = slices.steps[k];
    const double height = slices.places[k].z;
    if (step > 1.5 * usual)
      return "a slice is missing between " + format_number(height) + " and " +
             format_number(slices.places[k + 1].z) + " mm along the stack (the usual step is " +
             format_number(usual) +
             " mm). Export the complete series, or interpolate across the gap with --resample";
    if (std::abs(step - usual) > 2.0 * kPlaceLimit * usual)
      return "the slices are unevenly spaced (steps of " + format_number(usual) + " and " +
             format_number(step) + " mm; a slice may be missing near " + format_number(height) +
             " mm). Export a series of even spacing, or interpolate with --resample";
  }
  return {};
}

/// The largest distance of a slice from a straight, even row: of the spacing along the normal, of
/// a pixel across it.
struct Unevenness {
  double along = 0.0;
  double across = 0.0;
};

Unevenness unevenness(const SortedSlices& slices, double pixel) {
  Unevenness worst;
  const Vec3 first = slices.places.front();
  const Vec3 way = slices.places.back() - first;
  const auto last = double(slices.places.size() - 1);
  for (std::size_t k = 0; k < slices.places.size(); ++k) {
    const Vec3 off = slices.places[k] - (first + (double(k) / last) * way);
    worst.along = std::max(worst.along, std::abs(off.z) * last / way.z);
    worst.across = std::max(worst.across, std::hypot(off.x, off.y) / pixel);
  }
  return worst;
}

/// The upright grid around all slices, and where they lie on it.
void enclose(const SortedSlices& slices, bool even_heights, StackGeometry& stack) {
  VolumeGeometry& grid = stack.geometry;
  Vec3 least = slices.places.front();
  Vec3 most = slices.places.front();
  for (const Vec3& place : slices.places)
    for (int axis = 0; axis < 2; ++axis) {
      least[axis] = std::min(least[axis], place[axis]);
      most[axis] = std::max(most[axis], place[axis]);
    }
  for (int axis = 0; axis < 2; ++axis) {
    const double pixels = (most[axis] - least[axis]) / grid.spacing[axis];
    grid.size[std::size_t(axis)] += int(std::ceil(pixels - kSameAxisShift));
  }
  stack.even_heights = even_heights;
  if (!even_heights) {
    const double length = slices.places.back().z - slices.places.front().z;
    grid.size[2] = int(std::lround(length / slices.usual_step)) + 1;
    grid.spacing.z = length / double(grid.size[2] - 1);
  }
  grid.origin = slices.axes * least;
  for (const Vec3& place : slices.places) stack.places.push_back(place - least);
}

void warn_of_resampling(const SortedSlices& slices, bool tilted, bool even_heights,
                        StackGeometry& stack) {
  if (tilted)
    stack.warnings.push_back("the stack leans by " + format_number(stack.tilt_degrees) +
                             " degrees (gantry tilt); its slices were shifted onto an upright grid "
                             "by cubic interpolation");
  else if (even_heights)
    stack.warnings.push_back(
        "slices are shifted against each other; they were brought onto one grid by cubic "
        "interpolation");
  if (!even_heights)
    stack.warnings.push_back(
        "the slices are unevenly spaced; they were interpolated to " +
        format_number(stack.geometry.spacing.z) + " mm across gaps of up to " +
        format_number(*std::max_element(slices.steps.begin(), slices.steps.end())) +
        " mm, and a narrowing inside a gap would not be seen");
}

void place(const SortedSlices& slices, double pixel, UnevenSlices uneven, StackGeometry& stack) {
  const Vec3 way = slices.places.back() - slices.places.front();
  const double lateral = std::hypot(way.x, way.y);
  const double tilt = std::atan2(lateral, way.z) * 180.0 / units::kPi;
  const bool tilted = tilt > kTiltLimitDegrees && lateral > kLateralLimit * pixel;
  if (tilted) stack.tilt_degrees = tilt;
  if (tilt > kTiltMostDegrees) {
    stack.problem = "the slices lean by " + format_number(tilt) +
                    " degrees (no gantry tilts so far; the header is damaged). Export it again";
    return;
  }
  const Unevenness worst = unevenness(slices, pixel);
  const bool wanted = uneven == UnevenSlices::resample;
  const bool even_heights = uneven_heights(slices).empty() && worst.along <= kPlaceLimit;
  if (!even_heights && !wanted) {
    stack.problem = uneven_heights(slices);
    if (stack.problem.empty())
      stack.problem = "a slice lies off the regular grid by " + format_number(100.0 * worst.along) +
                      " % of the spacing (lengths across it would be wrong). Export a series of "
                      "even spacing, or interpolate with --resample";
    return;
  }
  // A leaning slice is shifted to where it says it lies; there, rounded decimals do no harm.
  if (worst.across > (tilted ? kTiltedPlaceLimit : kPlaceLimit) && !wanted) {
    stack.problem = "a slice is shifted sideways by " + format_number(worst.across) +
                    " pixels against the others (lengths across it would be wrong). Export the "
                    "series again, or shift it back with --resample";
    return;
  }
  if (tilted || !even_heights || worst.across > kPlaceLimit) {
    enclose(slices, even_heights, stack);
    warn_of_resampling(slices, tilted, even_heights, stack);
  } else if (std::max(worst.along, worst.across) > kPlaceTolerance) {
    stack.warnings.push_back("the slices lie up to " +
                             format_number(100.0 * std::max(worst.along, worst.across)) +
                             " % of a voxel off a regular grid; read as regular");
  }
}

}  // namespace

StackGeometry stack_geometry(const std::vector<DicomFrame>& frames, int columns, int rows,
                             UnevenSlices uneven) {
  StackGeometry stack;
  stack.problem = incomplete_geometry(frames);
  if (stack.problem.empty()) stack.problem = unlike_frames(frames);
  if (stack.problem.empty() && frames.size() < 2)
    stack.problem = "it is one slice alone, not a volume. Give the folder of the whole series";
  if (!stack.problem.empty()) return stack;

  SortedSlices slices = sort_slices(frames);
  stack.problem = repeated_heights(slices);
  if (!stack.problem.empty()) return stack;
  const double length = slices.places.back().z - slices.places.front().z;
  if (length > slices.usual_step * kMostSlicesPerGap * double(frames.size())) {
    stack.problem = "its slices lie " + format_number(length) +
                    " mm apart (the header is damaged). Export the series again";
    return stack;
  }
  stack.order = slices.order;
  stack.geometry.size = {columns, rows, int(frames.size())};
  stack.geometry.spacing = {frames.front().spacing_i, frames.front().spacing_j,
                            length / double(frames.size() - 1)};
  stack.geometry.origin = frames[std::size_t(slices.order.front())].position;
  stack.geometry.direction = slices.axes;
  place(slices, std::min(frames.front().spacing_i, frames.front().spacing_j), uneven, stack);
  return stack;
}

std::vector<std::vector<int>> repeated_places(const std::vector<DicomFrame>& frames) {
  std::vector<std::vector<int>> groups;
  if (frames.size() < 2 || !incomplete_geometry(frames).empty() || !unlike_frames(frames).empty())
    return groups;
  const SortedSlices slices = sort_slices(frames);
  bool open = false;
  for (std::size_t k = 0; k < slices.steps.size(); ++k) {
    const bool same = is_no_step(slices, slices.steps[k]);
    if (same && !open) groups.push_back({slices.order[k]});
    if (same) groups.back().push_back(slices.order[k + 1]);
    open = same;
  }
  return groups;
}

}  // namespace angio::segmentation::detail
