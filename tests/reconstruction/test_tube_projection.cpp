#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "angiogram/cone_beam.hpp"
#include "reconstruction/detail/self_calibration.hpp"
#include "reconstruction/detail/tube_chord.hpp"
#include "reconstruction/detail/tube_projection.hpp"

namespace angio::reconstruction::detail {
namespace {

using angiogram::ConeBeamFrame;

/// A frame that looks along none of the axes.
ConeBeamFrame askew() {
  angiogram::CArmMount mount;
  mount.columns = 96;
  mount.rows = 128;
  mount.column_spacing_mm = mount.row_spacing_mm = 0.45;  // 0.3 mm at the isocentre
  mount.central_column = 47.5;
  mount.central_row = 63.5;
  return angiogram::c_arm_frame({25.0, 20.0}, mount);
}

TEST(BlurredChord, IsTheMeanOfTheChord) {
  for (const double d : {0.0, 0.7, 1.38, 1.5, 1.62}) {
    double sum = 0.0;
    constexpr int kSteps = 200000;
    for (int n = 0; n < kSteps; ++n) {
      const double x = d + 0.3 * ((n + 0.5) / kSteps - 0.5);
      sum += 2.0 * std::sqrt(std::max(0.0, 1.5 * 1.5 - x * x)) / kSteps;
    }
    EXPECT_NEAR(blurred_chord(d, 1.5, 0.3).value, sum, 1e-6) << d;
  }
}

TEST(BlurredChord, ItsDerivativesAreThoseOfItsDifferences) {
  constexpr double kStep = 1e-6;
  for (const double d : {0.1, 0.9, 1.4, 1.55}) {
    const auto at = [](double x, double r, double w) { return blurred_chord(x, r, w).value; };
    const TubeChord chord = blurred_chord(d, 1.5, 0.3);
    EXPECT_NEAR(chord.by_distance,
                (at(d + kStep, 1.5, 0.3) - at(d - kStep, 1.5, 0.3)) / (2 * kStep), 1e-6);
    EXPECT_NEAR(chord.by_radius, (at(d, 1.5 + kStep, 0.3) - at(d, 1.5 - kStep, 0.3)) / (2 * kStep),
                1e-6);
    EXPECT_NEAR(chord.by_width, (at(d, 1.5, 0.3 + kStep) - at(d, 1.5, 0.3 - kStep)) / (2 * kStep),
                1e-6);
  }
}

/// By steps along the ray, from the foot to where it leaves the tube r(s) = exp(L + L' s + L'' s^2
/// / 2) around a straight axis.
double stepped_way(const ObliqueTube& tube) {
  constexpr double kStep = 1e-4;
  double way = 0.0;
  for (const double side : {-kStep, kStep})
    for (double t = 0.0;; t += side, way += kStep) {
      const double s = tube.cosine * t;
      const double r = std::exp(tube.log_radius + tube.slope * s + 0.5 * tube.bend * s * s);
      if (std::hypot(tube.distance, t * std::sqrt(1.0 - tube.cosine * tube.cosine)) >= r) break;
    }
  return way;
}

TEST(ObliqueChord, IsTheWayThroughAThroatAndABulge) {
  ObliqueTube tube;
  tube.log_radius = std::log(0.7);
  tube.width = 1e-3;
  for (const double bend : {0.3, -0.3})
    for (const double cosine : {0.0, 0.4, 0.7}) {
      tube.bend = bend;
      tube.cosine = cosine;
      const double way = stepped_way(tube);
      EXPECT_NEAR(oblique_chord(tube).way.value, way, 0.02 * way) << bend << " " << cosine;
    }
  // At 45 degrees a throat is seen 7 % wider than an even tube of its radius.
  tube.bend = 0.3;
  tube.cosine = std::sqrt(0.5);
  EXPECT_GT(oblique_chord(tube).way.value, 1.06 * 2.0 * 0.7 / std::sqrt(0.5));
  // Where the tube widens, the middle of the way lies on its wide side.
  tube.slope = 0.2;
  EXPECT_GT(oblique_chord(tube).middle.value, 0.0);
}

TEST(ObliqueChord, ItsDerivativesAreThoseOfItsDifferences) {
  constexpr double kStep = 1e-6;
  const std::array<std::pair<double ObliqueTube::*, double ObliqueLength::*>, 6> all = {{
      {&ObliqueTube::distance, &ObliqueLength::by_distance},
      {&ObliqueTube::log_radius, &ObliqueLength::by_log_radius},
      {&ObliqueTube::slope, &ObliqueLength::by_slope},
      {&ObliqueTube::bend, &ObliqueLength::by_bend},
      {&ObliqueTube::cosine, &ObliqueLength::by_cosine},
      {&ObliqueTube::width, &ObliqueLength::by_width},
  }};
  for (const double bend : {0.4, -0.4})
    for (const auto& [parameter, derivative] : all) {
      const ObliqueTube tube{0.35, std::log(0.9), 0.25, bend, 0.6, 0.3};
      ObliqueTube plus = tube, minus = tube;
      plus.*parameter += kStep;
      minus.*parameter -= kStep;
      const ObliqueChord chord = oblique_chord(tube), a = oblique_chord(plus),
                         b = oblique_chord(minus);
      EXPECT_NEAR(chord.way.*derivative, (a.way.value - b.way.value) / (2.0 * kStep), 1e-6);
      EXPECT_NEAR(chord.middle.*derivative, (a.middle.value - b.middle.value) / (2.0 * kStep),
                  1e-6);
    }
}

/// Two branches that leave each other, seen from the side and askew.
CenterlineTree fork() {
  CenterlineTree tree;
  for (const double turn : {0.0, 0.35}) {
    CenterlinePath& path = tree.paths.emplace_back();
    for (int n = 0; n <= 60; ++n) {
      const double z = -12.0 + 0.4 * n;
      path.points.push_back({0.02 * z * z + (z > 0.0 ? turn * z : 0.0), 0.01 * z * z, z});
      path.inscribed_radius.push_back(1.4 - 0.02 * n);
    }
    path.abscissa = arc_length(path.points);
  }
  return tree;
}

/// Every pixel's way, of the rays that pass a tube.
std::vector<double> ways(const ConeBeamFrame& frame, const TreeCurves& curves, double width) {
  const FrameRays rays(frame);
  const SampledCurves sampled = sample_curves(curves);
  std::vector<double> all(std::size_t(frame.columns * frame.rows), 0.0);
  const auto hits = find_hits(rays, sampled, width, Reach::tube, {});
  for (std::size_t h = 0; h < hits.size();) {
    const std::size_t first = h;
    while (h < hits.size() && hits[h].pixel == hits[first].pixel) ++h;
    all[std::size_t(hits[first].pixel)] =
        way_of_ray(rays, sampled, width, hits.data() + first, hits.data() + h, nullptr);
  }
  return all;
}

/// The derivative of every pixel's way in a direction of the parameters, as the gradients say.
std::vector<double> ways_by(const ConeBeamFrame& frame, const TreeCurves& curves, double width,
                            const std::function<double(const WayGradient&)>& in) {
  const FrameRays rays(frame);
  const SampledCurves sampled = sample_curves(curves);
  std::vector<double> all(std::size_t(frame.columns * frame.rows), 0.0);
  const auto hits = find_hits(rays, sampled, width, Reach::tube, {});
  for (std::size_t h = 0; h < hits.size();) {
    const std::size_t first = h;
    while (h < hits.size() && hits[h].pixel == hits[first].pixel) ++h;
    WayGradient gradient;
    way_of_ray(rays, sampled, width, hits.data() + first, hits.data() + h, &gradient);
    all[std::size_t(hits[first].pixel)] = in(gradient);
  }
  return all;
}

/// The share of pixels whose two derivatives differ: where an edge jumps, differences say nothing.
double share_apart(const std::vector<double>& analytic, const std::vector<double>& plus,
                   const std::vector<double>& minus, double step) {
  int counted = 0, apart = 0;
  for (std::size_t p = 0; p < analytic.size(); ++p) {
    const double by_difference = (plus[p] - minus[p]) / (2.0 * step);
    if (analytic[p] == 0.0 && by_difference == 0.0) continue;
    ++counted;
    apart += std::abs(analytic[p] - by_difference) > 2e-3 * (1.0 + std::abs(by_difference));
  }
  EXPECT_GT(counted, 20);
  return double(apart) / counted;
}

TEST(WayOfRay, ItsDerivativesAreThoseOfItsDifferences) {
  constexpr double kStep = 1e-5;
  const ConeBeamFrame frame = askew();
  const TreeCurves curves = make_curves(fork(), 1.5, 0.5);
  const int parameters = 3 * curves.node_count();
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<double> direction(std::size_t(parameters), 0.0);
    for (double& d : direction) d = normal(random);
    const auto analytic = ways_by(frame, curves, 1.2, [&](const WayGradient& g) {
      double sum = 0.0;
      for (const auto& [index, by] : g.by_parameter) sum += by * direction[std::size_t(index)];
      return sum;
    });
    const auto at = [&](double way) {
      std::vector<double> by = direction;
      for (double& b : by) b *= way;
      TreeCurves there = curves;
      move_curves(there, by);
      return ways(frame, there, 1.2);
    };
    EXPECT_LT(share_apart(analytic, at(kStep), at(-kStep), kStep), 0.01);
  }
}

TEST(WayOfRay, ItsDerivativesByMotionAndWidthAreThoseOfItsDifferences) {
  constexpr double kStep = 1e-5;
  const ConeBeamFrame frame = askew();
  const TreeCurves curves = make_curves(fork(), 1.5, 0.5);
  for (std::size_t m = 0; m < 6; ++m) {
    const auto moved_by = [&](double size) {
      Motion motion;
      (m < 3 ? motion.turn : motion.shift)[int(m % 3)] = size;
      return ways(moved(frame, motion), curves, 1.2);
    };
    const auto analytic =
        ways_by(frame, curves, 1.2, [&](const WayGradient& g) { return g.by_motion[m]; });
    // The width of the box goes with the depth, by 1 / 800 a mm, which the gradient leaves out.
    EXPECT_LT(share_apart(analytic, moved_by(kStep), moved_by(-kStep), kStep), 0.03) << m;
  }
  const auto analytic =
      ways_by(frame, curves, 1.2, [](const WayGradient& g) { return g.by_width; });
  EXPECT_LT(share_apart(analytic, ways(frame, curves, 1.2 * std::exp(kStep)),
                        ways(frame, curves, 1.2 * std::exp(-kStep)), kStep),
            0.01);
}

TEST(WayOfRay, CountsOnceWhereBranchesLieInEachOther) {
  CenterlineTree tree = fork();
  TreeCurves once = make_curves({{tree.paths[0]}}, 1.5, 0.5);
  // The same line, a hair beside.
  CenterlineTree twice{{tree.paths[0], tree.paths[0]}};
  for (Vec3& point : twice.paths[1].points) point.x += 1e-6;
  const ConeBeamFrame frame = askew();
  const auto one = ways(frame, once, 1.2), two = ways(frame, make_curves(twice, 1.5, 0.5), 1.2);
  for (std::size_t p = 0; p < one.size(); ++p) EXPECT_NEAR(one[p], two[p], 1e-3);
}

}  // namespace
}  // namespace angio::reconstruction::detail
