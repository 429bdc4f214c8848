#include "datasets/detail/vessel_plan.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kLargestStepMm = 0.1;
constexpr double kSmallestStepMm = 0.02;

double smoothstep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double linear(const RadiusStretch& stretch, double s) {
  const double t = (s - stretch.start_mm) / (stretch.end_mm - stretch.start_mm);
  return stretch.radius_at_start_mm + t * (stretch.radius_at_end_mm - stretch.radius_at_start_mm);
}

double lesion_window(const LesionPlan& lesion, double s) {
  const double x = (s - lesion.center_mm) / lesion.length_mm;
  return std::abs(x) < 0.5 ? 0.5 * (1.0 + std::cos(2.0 * units::kPi * x)) : 0.0;
}

/// The step from s to s + ds along the axis: the integral of the tangent, by Gauss's rule of three
/// points (error of order ds^7).
Vec3 axis_step(const VesselPlan& plan, double s, double ds) {
  const double offset = std::sqrt(0.6) / 2.0;
  const Vec3 sum = 5.0 * plan.direction(s + ds * (0.5 - offset)) +
                   8.0 * plan.direction(s + ds * 0.5) +
                   5.0 * plan.direction(s + ds * (0.5 + offset));
  return (ds / 18.0) * sum;
}

/// Puts one ball at abscissa s, where the healthy axis is at `axis`.
void add_sample(const VesselPlan& plan, double s, const Vec3& axis, Branch& branch) {
  const double healthy = plan.healthy_radius(s);
  Vec3 center = axis, half_width;
  double radius = healthy;
  for (const LesionPlan& lesion : plan.lesions) {
    const double window = lesion_window(lesion, s);
    if (window == 0.0) continue;
    radius = healthy * (1.0 - lesion.depth * window);
    if (lesion.shape == LesionShape::concentric) continue;
    const Vec3 tangent = plan.direction(s);
    const Vec3 toward = normalized(lesion.toward - dot(lesion.toward, tangent) * tangent);
    if (lesion.shape == LesionShape::eccentric)
      center += (healthy - radius) * toward;
    else
      half_width = (healthy - radius) * toward;
  }
  branch.center.push_back(center);
  branch.radius.push_back(radius);
  branch.half_width.push_back(half_width);
  branch.healthy_mm.push_back(healthy);
}

double least_radius(const VesselPlan& plan) {
  double least = plan.radii.front().radius_at_start_mm;
  for (const RadiusStretch& stretch : plan.radii)
    least = std::min({least, stretch.radius_at_start_mm, stretch.radius_at_end_mm});
  double deepest = 0.0;
  for (const LesionPlan& lesion : plan.lesions) deepest = std::max(deepest, lesion.depth);
  return least * (1.0 - deepest);
}

}  // namespace

Vec3 VesselPlan::direction(double s) const {
  const auto& keys = directions;
  if (s <= keys.front().abscissa_mm) return normalized(keys.front().direction);
  if (s >= keys.back().abscissa_mm) return normalized(keys.back().direction);
  std::size_t k = 0;
  while (s >= keys[k + 1].abscissa_mm) ++k;
  const auto unit = [&](std::size_t i) { return normalized(keys[i].direction); };
  // Slope of the direction at a key; at the ends the axis runs straight.
  const auto slope = [&](std::size_t i) {
    if (i == 0 || i + 1 == keys.size()) return Vec3{};
    return (unit(i + 1) - unit(i - 1)) / (keys[i + 1].abscissa_mm - keys[i - 1].abscissa_mm);
  };
  const double width = keys[k + 1].abscissa_mm - keys[k].abscissa_mm;
  const double t = (s - keys[k].abscissa_mm) / width;
  const double t2 = t * t, t3 = t2 * t;
  return normalized((2 * t3 - 3 * t2 + 1) * unit(k) + ((t3 - 2 * t2 + t) * width) * slope(k) +
                    (3 * t2 - 2 * t3) * unit(k + 1) + ((t3 - t2) * width) * slope(k + 1));
}

double VesselPlan::healthy_radius(double s) const {
  std::size_t k = 0;
  while (k + 1 < radii.size() && s >= radii[k + 1].start_mm) ++k;
  const double here = linear(radii[k], s);
  if (k == 0 || radii[k].transition_mm <= 0.0) return here;
  const double before = linear(radii[k - 1], s);
  const double weight = smoothstep((s - radii[k].start_mm) / radii[k].transition_mm);
  return before + weight * (here - before);
}

Branch sample_vessel(const VesselPlan& plan) {
  const double wanted_step = std::clamp(0.25 * least_radius(plan), kSmallestStepMm, kLargestStepMm);
  const int step_count = std::max(4, int(std::ceil(plan.length_mm / wanted_step)));
  Branch branch;
  branch.step_mm = plan.length_mm / step_count;
  const auto extension = [&](double s) {
    return int(std::ceil(1.2 * plan.healthy_radius(s) / branch.step_mm));
  };
  branch.cut_at_start = !plan.begins_in_parent;
  branch.cut_at_end = !plan.ends_as_dome;
  branch.first_sample = branch.cut_at_start ? extension(0.0) : 0;
  branch.last_sample = branch.first_sample + step_count;
  const int sample_count =
      branch.last_sample + (branch.cut_at_end ? extension(plan.length_mm) : 0) + 1;

  Vec3 axis = plan.start;
  for (int i = 0; i > -branch.first_sample; --i)
    axis -= axis_step(plan, (i - 1) * branch.step_mm, branch.step_mm);
  for (int i = 0; i < sample_count; ++i) {
    const double s = (i - branch.first_sample) * branch.step_mm;
    add_sample(plan, s, axis, branch);
    axis += axis_step(plan, s, branch.step_mm);
  }
  return branch;
}

int sample_at(const Branch& branch, double abscissa_mm) {
  const int sample = branch.first_sample + int(std::lround(abscissa_mm / branch.step_mm));
  return std::clamp(sample, branch.first_sample, branch.last_sample);
}

}  // namespace angio::datasets::detail
