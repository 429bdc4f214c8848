#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "simulation/bodies/guidewire.hpp"
#include "simulation/contact/distance.hpp"
#include "simulation/step/status.hpp"
#include "testing/simulation/models.hpp"

/// The guidewire's rod inside a balloon that is inflated and emptied.
namespace angio::simulation {
namespace {

constexpr std::size_t kNodes = 24;

/// The model with a guidewire of 24 nodes from pole to pole.
SimulationModel wired(SimulationModel model, double length) {
  model.guidewire.clear();
  for (std::size_t i = 0; i < kNodes; ++i)
    model.guidewire.push_back({0.0, 0.0, length * (double(i) / (kNodes - 1) - 0.5)});
  return model;
}

/// Bends all that lies along z into a circle of the given radius in the plane of x and z.
void bend(double radius, SimulationModel& model) {
  const auto to_circle = [&](std::vector<Vec3>& points) {
    for (Vec3& p : points) {
      const double angle = p.z / radius, r = radius + p.x;
      p = {r * std::cos(angle) - radius, p.y, r * std::sin(angle)};
    }
  };
  to_circle(model.balloon.vertices);
  to_circle(model.guidewire);
  to_circle(model.wall.vertices);
}

SimulationOptions quick(double peak_atm) {
  SimulationOptions options;
  options.guidewire.model = GuidewireModel::rod;
  options.inflation.peak_pressure_atm = peak_atm;
  options.inflation.inflate_s = 0.5;
  options.inflation.hold_s = 0.1;
  options.inflation.deflate_s = 0.4;
  options.inflation.rest_s = 0.1;
  options.backend = Backend::cpu;
  return options;
}

std::vector<SimulationFrame> frames_of(const SimulationModel& model,
                                       const SimulationOptions& options) {
  std::vector<SimulationFrame> frames;
  simulate(model, options, [&](const SimulationFrame& f) { frames.push_back(f); });
  return frames;
}

/// Least room between a triangle of the balloon and a segment of the wire [mm].
double room(const std::vector<Vec3>& x, const Triangle& t, const std::vector<Vec3>& wire,
            std::size_t i) {
  const auto gap = [](const detail::GapWeights<double>& w, const std::array<Vec3, 4>& p) {
    Vec3 sum;
    for (std::size_t k = 0; k < 4; ++k) sum += w.w[k] * p[k];
    return norm(sum);
  };
  const auto corner = [&](std::size_t k) { return x[std::size_t(t[k % 3])]; };
  const Vec3 &a = wire[i], &b = wire[i + 1];
  double least = 1e30;
  for (std::size_t k = 0; k < 3; ++k)
    least = std::min(least, gap(detail::segment_segment_gap(corner(k), corner(k + 1), a, b),
                                {corner(k), corner(k + 1), a, b}));
  for (const Vec3& node : {a, b})
    least = std::min(least, gap(detail::point_triangle_gap(node, corner(0), corner(1), corner(2)),
                                {node, corner(0), corner(1), corner(2)}));
  return least;
}

/// The least room between balloon and shaft, over triangles that do not start within a contact
/// distance of it (the ends, which are tied); negative where one has gone into the other.
double clearance(const SimulationModel& model, const SimulationFrame& frame) {
  const double radius = 0.5 * GuidewireOptions{}.shaft_diameter_mm;
  const double least_start = SimulationOptions{}.contact.distance_mm;
  double least = 1e30;
  for (const Triangle& t : model.balloon.triangles)
    for (std::size_t i = 0; i + 1 < frame.guidewire.size(); ++i) {
      const double start = room(model.balloon.vertices, t, model.guidewire, i) - least_start;
      if (start > 0.0)
        least =
            std::min(least, room(frame.balloon, t, frame.guidewire, i) - std::min(radius, start));
    }
  return least;
}

testing::StenosedTube tube() {
  testing::StenosedTube tube;
  tube.balloon_rings = 20;
  tube.balloon_around = 12;
  tube.wall_rings = 41;
  tube.wall_around = 16;
  return tube;
}

SimulationModel free_balloon() {
  SimulationModel model = wired(testing::make_model(tube()), tube().balloon_length);
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  return model;
}

// The full balloon: a slack one takes one of many shapes, and touching the shaft picks another.
TEST(Guidewire, InAStraightBalloonItStaysAndChangesNothing) {
  const SimulationModel model = free_balloon();
  SimulationOptions options = quick(8.0);
  const auto with = frames_of(model, options);
  options.guidewire.model = GuidewireModel::none;
  const auto without = frames_of(model, options);
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t f = 0; f < with.size(); ++f) {
    EXPECT_EQ(without[f].guidewire.size(), kNodes);  // drawn
    if (with[f].phase == Phase::hold) {
      EXPECT_NEAR(with[f].balloon_diameter_mm, without[f].balloon_diameter_mm, 5e-3) << f;
    }
    for (std::size_t i = 0; i < kNodes; ++i)
      EXPECT_LT(distance(with[f].guidewire[i], model.guidewire[i]), 1e-2) << f << ' ' << i;
  }
}

TEST(Guidewire, AnEmptiedBalloonLiesOnTheShaftAndNeverInIt) {
  const SimulationModel model = free_balloon();
  SimulationOptions options = quick(6.0);
  options.inflation.control = InflationControl::pressure;
  options.inflation.deflate_pressure_atm = -0.5;
  const auto frames = frames_of(model, options);
  for (const SimulationFrame& frame : frames)
    EXPECT_GT(clearance(model, frame), 0.0) << frame.frame;
  EXPECT_LT(clearance(model, frames.back()), options.contact.distance_mm);
  EXPECT_EQ(frames.back().contact.count, 0);  // of the wall
}

// An arc is the elastica between two ends that are clamped along it: a straight wire that is bent
// into it stays there, until the balloon, which is not round in a bend, pushes it aside.
TEST(Guidewire, BentIntoAnArcItStaysInside) {
  SimulationModel model = wired(testing::make_model(tube()), tube().balloon_length);
  bend(15.0, model);
  SimulationOptions options = quick(2.0);
  options.inflation.inflate_s = options.inflation.deflate_s = 0.1;
  for (const SimulationFrame& frame : frames_of(model, options)) {
    EXPECT_GT(clearance(model, frame), 0.0) << frame.frame;
    for (std::size_t i = 0; i < kNodes; ++i)
      EXPECT_LT(distance(frame.guidewire[i], model.guidewire[i]), 0.2) << frame.frame << ' ' << i;
  }
}

// The slack membrane comes to lie on the shaft: 120 sweeps leave the first frame off by 15 %, and
// the next ones begin with that.
TEST(Guidewire, InABendItsFramesAreInBalanceFromTheFirstOn) {
  SimulationModel model = wired(testing::make_model(tube()), tube().balloon_length);
  bend(15.0, model);
  SimulationOptions options = quick(2.0);
  options.inflation.inflate_s = 0.1;
  options.inflation.deflate_s = 0.025;
  options.inflation.hold_s = options.inflation.rest_s = 0.0;
  const auto frames = frames_of(model, options);
  ASSERT_GT(frames.size(), 2U);
  EXPECT_LE(frames[1].residual, detail::kLaterResidual);
  for (const SimulationFrame& frame : frames)
    EXPECT_LE(frame.residual, detail::kBalanceMargin * detail::kOffBalance) << frame.frame;
}

// Of what pushes the end away, p pi R^2, the membrane carries a part.
TEST(Guidewire, AFreeTipGoesForwardAsTheBalloonFills) {
  const SimulationModel model = free_balloon();
  SimulationOptions options = quick(8.0);
  options.guidewire.tip = GuidewireTip::free;
  const auto frames = frames_of(model, options);
  const auto peak = std::max_element(
      frames.begin(), frames.end(),
      [](const auto& a, const auto& b) { return a.pressure_atm < b.pressure_atm; });
  const double grown = peak->guidewire.back().z - frames.front().guidewire.back().z;
  const double pressure = units::pascal_from_atm(peak->pressure_atm);
  const double radius = 0.5 * peak->balloon_diameter_mm;
  const double alone = pressure * units::kPi * radius * radius * tube().balloon_length /
                       detail::rod_section(options.guidewire).stretch;
  EXPECT_GT(grown, 0.01 * alone);
  EXPECT_LT(grown, alone);
  const auto pole = model.balloon.vertices.size() - 1;
  EXPECT_LT(distance(peak->balloon[pole], peak->guidewire.back()), 1e-5);
}

TEST(Guidewire, NeedsNodesToBend) {
  SimulationModel model = free_balloon();
  model.guidewire = {model.guidewire.front(), model.guidewire.back()};
  EXPECT_THROW(frames_of(model, quick(8.0)), InputError);
}

}  // namespace
}  // namespace angio::simulation
