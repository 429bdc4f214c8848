#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/units.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kOrthogonalTolerance = 1e-3;  ///< dot product of axes that are rounded decimals
constexpr double kParallelTolerance = 1e-4;    ///< difference of two slices' axes
constexpr double kPlaceTolerance = 0.01;       ///< of the spacing: counts as regular
constexpr double kPlaceLimit = 0.05;           ///< of the spacing: usable, with a warning
constexpr double kTiltLimitDegrees = 0.1;
constexpr double kLateralLimit = 0.1;  ///< of a pixel

std::string incomplete_geometry(const std::vector<DicomFrame>& frames) {
  for (const auto& frame : frames) {
    const char* missing = !frame.has_spacing       ? "the pixel spacing"
                          : !frame.has_orientation ? "the image orientation"
                          : !frame.has_position    ? "the image position"
                                                   : nullptr;
    if (missing)
      return std::string(missing) +
             " is missing (without it no length can be measured; anonymisation may have removed "
             "it). Export the series with its geometry";
    if (!(frame.spacing_i > 1e-4 && frame.spacing_j > 1e-4 && frame.spacing_i < 100.0 &&
          frame.spacing_j < 100.0))
      return "the pixel spacing is impossible (" + format_number(frame.spacing_j) + " x " +
             format_number(frame.spacing_i) + " mm). Export the series again";
    if (std::abs(norm(frame.axis_i) - 1.0) > kOrthogonalTolerance ||
        std::abs(norm(frame.axis_j) - 1.0) > kOrthogonalTolerance ||
        std::abs(dot(frame.axis_i, frame.axis_j)) > kOrthogonalTolerance)
      return "the image orientation is not two unit axes at right angles (the header is damaged). "
             "Export the series again";
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

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// @param heights  ascending, along the normal [mm]
std::string uneven_heights(const std::vector<double>& heights) {
  std::vector<double> steps(heights.size() - 1);
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) steps[k] = heights[k + 1] - heights[k];
  const double usual = median_of(steps);
  const double tiny =
      std::max(1e-4, 0.05 * std::max(usual, *std::max_element(steps.begin(), steps.end())));
  const auto same = std::count_if(steps.begin(), steps.end(), [&](double s) { return s < tiny; });
  if (same > 0)
    return std::to_string(same) +
           (same == 1 ? " slice repeats a position" : " slices repeat positions") +
           " (several phases or reconstructions in one series, or copies). Export one phase alone";
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (steps[k] > 1.5 * usual)
      return "a slice is missing between " + format_number(heights[k]) + " and " +
             format_number(heights[k + 1]) + " mm along the stack (the usual step is " +
             format_number(usual) + " mm). Export the complete series";
    if (std::abs(steps[k] - usual) > 2.0 * kPlaceLimit * usual)
      return "the slices are unevenly spaced (steps of " + format_number(usual) + " and " +
             format_number(steps[k]) + " mm; a slice may be missing near " +
             format_number(heights[k]) + " mm). Export a series of even spacing";
  }
  return {};
}

}  // namespace

StackGeometry stack_geometry(const std::vector<DicomFrame>& frames, int columns, int rows) {
  StackGeometry stack;
  stack.problem = incomplete_geometry(frames);
  if (stack.problem.empty()) stack.problem = unlike_frames(frames);
  if (stack.problem.empty() && frames.size() < 2)
    stack.problem = "it is one slice alone, not a volume. Give the folder of the whole series";
  if (!stack.problem.empty()) return stack;

  const Mat3 axes = orthonormal_axes(frames.front());
  const Vec3 normal{axes(0, 2), axes(1, 2), axes(2, 2)};
  stack.order.resize(frames.size());
  std::iota(stack.order.begin(), stack.order.end(), 0);
  const auto height = [&](int f) { return dot(frames[std::size_t(f)].position, normal); };
  std::stable_sort(stack.order.begin(), stack.order.end(),
                   [&](int a, int b) { return height(a) < height(b); });
  std::vector<double> heights;
  for (int f : stack.order) heights.push_back(height(f));
  stack.problem = uneven_heights(heights);
  if (!stack.problem.empty()) return stack;

  const Vec3 first = frames[std::size_t(stack.order.front())].position;
  const Vec3 last = frames[std::size_t(stack.order.back())].position;
  const double length = heights.back() - heights.front();
  const double spacing = length / double(frames.size() - 1);
  const double lateral = norm((last - first) - length * normal);
  const double pixel = std::min(frames.front().spacing_i, frames.front().spacing_j);
  const double tilt = std::atan2(lateral, length) * 180.0 / units::kPi;
  if (tilt > kTiltLimitDegrees && lateral > kLateralLimit * pixel) {
    stack.problem = "the slices are shifted along the stack by " + format_number(tilt) +
                    " degrees (gantry tilt: the volume is sheared). Export it resampled without "
                    "tilt";
    return stack;
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    const Vec3 place = first + (double(k) / double(heights.size() - 1)) * (last - first);
    const Vec3 off = frames[std::size_t(stack.order[k])].position - place;
    const double along = std::abs(dot(off, normal)) / spacing;
    worst = std::max({worst, along, norm(off - dot(off, normal) * normal) / pixel});
  }
  if (worst > kPlaceLimit) {
    stack.problem = "a slice lies off the regular grid by " + format_number(100.0 * worst) +
                    " % of a voxel (lengths across it would be wrong). Export a series of even "
                    "spacing";
    return stack;
  }
  if (worst > kPlaceTolerance)
    stack.warnings.push_back("the slices lie up to " + format_number(100.0 * worst) +
                             " % of a voxel off a regular grid; read as regular");
  stack.geometry.size = {columns, rows, int(frames.size())};
  stack.geometry.spacing = {frames.front().spacing_i, frames.front().spacing_j, spacing};
  stack.geometry.origin = first;
  stack.geometry.direction = axes;
  return stack;
}

}  // namespace angio::segmentation::detail
