#include "centerline/detail/section.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "centerline/detail/contour.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kMostOrder = 4;
constexpr int kMostTerms = 2 * kMostOrder + 1;
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostTerms, 1>;
using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostTerms, kMostTerms>;

Coefficients harmonics(int terms, double theta) {
  Coefficients basis(terms);
  basis[0] = 1.0;
  for (int m = 1; 2 * m < terms; ++m) {
    basis[2 * m - 1] = std::cos(m * theta);
    basis[2 * m] = std::sin(m * theta);
  }
  return basis;
}

double angle_of(std::size_t ray, std::size_t count) {
  return 2.0 * units::kPi * double(ray) / double(count);
}

struct RadiusFit {
  Coefficients terms;
  double noise = 0.0;  ///< sd of what is left [mm]
};

/// r(theta) as a short Fourier series, by least squares with Huber weights.
RadiusFit fit_radii(const std::vector<double>& radii, int terms) {
  std::vector<Coefficients> basis;
  for (std::size_t i = 0; i < radii.size(); ++i)
    basis.push_back(harmonics(terms, angle_of(i, radii.size())));
  std::vector<double> weight(radii.size(), 1.0), residual(radii.size());
  RadiusFit fit;
  for (int pass = 0; pass < 3; ++pass) {
    Normal left = Normal::Zero(terms, terms);
    Coefficients right = Coefficients::Zero(terms);
    for (std::size_t i = 0; i < radii.size(); ++i) {
      left += weight[i] * basis[i] * basis[i].transpose();
      right += weight[i] * radii[i] * basis[i];
    }
    fit.terms = left.ldlt().solve(right);
    for (std::size_t i = 0; i < radii.size(); ++i)
      residual[i] = std::abs(radii[i] - fit.terms.dot(basis[i]));
    fit.noise = 1.4826 * median(residual);
    const double scale = std::max(fit.noise, 1e-6 * radii[0]);
    for (std::size_t i = 0; i < radii.size(); ++i)
      weight[i] = residual[i] > 1.5 * scale ? 1.5 * scale / residual[i] : 1.0;
  }
  return fit;
}

/// Shrinks each harmonic by what the noise is expected to add to it (positive-part James-Stein):
/// a round vessel with a noisy wall stays round, a truly flat one stays flat.
///
/// @param samples  independent wall positions round the section
Coefficients shrink_harmonics(RadiusFit fit, double samples) {
  const auto terms = double(fit.terms.size());
  const double left_over = std::max(1.0 - terms / samples, 0.25);
  const double variance = 2.0 * fit.noise * fit.noise / left_over / samples;  // of one coefficient
  for (int c = 1; c + 1 < fit.terms.size(); c += 2) {
    const double power = fit.terms[c] * fit.terms[c] + fit.terms[c + 1] * fit.terms[c + 1];
    const double keep = power > 0.0 ? std::max(0.0, 1.0 - 2.0 * variance / power) : 0.0;
    fit.terms[c] *= keep;
    fit.terms[c + 1] *= keep;
  }
  return fit.terms;
}

/// Rays that leave through a side branch say nothing about the circle: cut them short.
std::vector<double> clip_long(const std::vector<double>& radii) {
  std::vector<double> sorted = radii, clipped = radii;
  std::sort(sorted.begin(), sorted.end());
  const double longest = 2.5 * sorted[sorted.size() / 5];
  // A slit is long to both sides, the mouth of a branch to one.
  for (std::size_t i = 0; i < radii.size(); ++i)
    clipped[i] =
        std::min(radii[i], std::max(longest, 1.5 * radii[(i + radii.size() / 2) % radii.size()]));
  return clipped;
}

}  // namespace

Section measure_section(const Wall& wall, const Vec3& point, const Vec3& normal,
                        const SectionOptions& options) {
  Section section;
  section.center = point;
  const Vec3 u = any_perpendicular(normal);
  const Vec3 v = cross(normal, u);
  const auto count = std::size_t(options.ray_count);
  std::vector<double> radii(count);
  Contour contour(count);
  double expected = options.expected;
  for (int pass = 0; pass <= options.refinements; ++pass) {
    for (std::size_t i = 0; i < count; ++i) {
      const double theta = angle_of(i, count);
      const Vec3 direction = std::cos(theta) * u + std::sin(theta) * v;
      radii[i] = wall.ray(section.center, direction,
                          kLongestRay * std::max(expected, 0.5 * options.extent));
      if (radii[i] <= 0.0) return section;
    }
    const double samples =
        std::clamp(2.0 * units::kPi * median(radii) / wall.resolution(), 8.0, double(count));
    const int order = std::clamp(int((samples - 1.0) / 5.0), 2, kMostOrder);
    const Coefficients fit = shrink_harmonics(fit_radii(clip_long(radii), 2 * order + 1), samples);
    for (std::size_t i = 0; i < count; ++i) {
      const double theta = angle_of(i, count);
      const double r = std::max(fit.dot(harmonics(2 * order + 1, theta)), 0.0);
      contour[i] = {r * std::cos(theta), r * std::sin(theta)};
    }
    const double most_shift = options.most_shift * std::max(expected, 0.5 * options.extent);
    const Circle circle = largest_circle(contour, most_shift);
    section.inscribed_radius = circle.radius;
    const Point2 shift = section_middle(contour, circle, most_shift);
    section.extent = contour_extent(contour, shift);
    section.center += shift.x * u + shift.y * v;
    expected = std::max(section.inscribed_radius, 0.5 * wall.resolution());
  }
  const double step = 2.0 * units::kPi / double(count);
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += radii[i] * radii[(i + 1) % count];
  section.area = 0.5 * sum * step;  // sin(step) of the polygon becomes step of the circle
  section.valid = section.inscribed_radius > 0.0;
  return section;
}

}  // namespace angio::centerline
