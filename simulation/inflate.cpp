#include "simulation/inflate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/error.hpp"
#include "core/units.hpp"
#include "simulation/detail/capsule.hpp"
#include "simulation/detail/material.hpp"
#include "simulation/detail/membrane_term.hpp"

namespace angio::simulation {
namespace {

using namespace detail;
using Control = Enclosure::Control;

constexpr double kMostGrowth = 1.25;  // of the volume in one step; more may be a jump
constexpr double kLeastStep = 1e-4;   // of a target, before a limit point is believed
constexpr int kMostIterations = 40;   // of a step: what takes longer is better halved

void check(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return;
  char text[200];
  std::snprintf(text, sizeof text, "%s is %g (it must lie in [%g, %g])", field, value, low, high);
  throw OptionError(text);
}

// A spring that holds the end of a piece of tube plane, over the membrane's stiffness: the ends are
// out of plane by its inverse.
constexpr double kPlaneStiffness = 1e3;

Capsule mesh_of(const FreeBalloon& balloon, int around) {
  return balloon.ends == BalloonEnds::hemispheres
             ? make_capsule(balloon.radius_mm, balloon.length_mm, around)
             : make_tube_piece(balloon.radius_mm, around);
}

std::vector<char> fixed_of(const Capsule& capsule, BalloonEnds ends) {
  std::vector<char> fixed = detail::without_rigid_motion(capsule);
  if (ends == BalloonEnds::hemispheres) return fixed;
  // The poles hold nothing here: three vertices on the axes x and y do, against shift and turn.
  const int first = capsule.middle_ring * capsule.around;
  fixed[std::size_t(first)] = fixed[std::size_t(first + capsule.around / 2)] = kFixedY;
  fixed[std::size_t(first + capsule.around / 4)] = kFixedX;
  const auto hold = [&](int ring, int pole) {
    for (int k = 0; k < capsule.around; ++k)
      fixed[std::size_t(ring * capsule.around + k)] |= kFixedZ;
    fixed[std::size_t(pole)] |= kFixedZ;
  };
  hold(capsule.first_ring, capsule.low_pole);
  if (ends == BalloonEnds::fixed_length) hold(capsule.last_ring, capsule.high_pole);
  return fixed;
}

// A balloon at rest, on its way through states of rest.
class Bench {
 public:
  Bench(const FreeBalloon& balloon, const InflateOptions& options)
      : capsule_(mesh_of(balloon, options.around)),
        wall_mm_(balloon.material.wall_mm),
        skin_(skin_law(balloon.material), capsule_.skin, capsule_.mesh.vertices, wall_mm_,
              hoop_fibres(capsule_.skin, capsule_.mesh.vertices, {{0, 0, 0}, {0, 0, 1}})),
        plane_(capsule_, kPlaneStiffness *
                             (moduli(balloon.material).c1 + moduli(balloon.material).c2) *
                             wall_mm_),
        terms_{&skin_},
        fixed_(fixed_of(capsule_, balloon.ends)),
        x_(capsule_.mesh.vertices),
        lengths_(balloon.length_mm / capsule_.length) {
    if (balloon.ends == BalloonEnds::tube) terms_.push_back(&plane_);
    newton_.tolerance = options.tolerance;
    newton_.most_iterations = kMostIterations;
    state_.volume = enclosed_volume(capsule_.mesh);
    const double r = balloon.radius_mm, caps = balloon.ends == BalloonEnds::hemispheres ? r : 0.0;
    smooth_volume_ = units::kPi * r * r * (balloon.length_mm + 4.0 / 3.0 * caps) / state_.volume;
  }
  Bench(const Bench&) = delete;  // terms_ points into it
  Bench& operator=(const Bench&) = delete;

  // The balloon's enclosed volume over that of what is meshed, unloaded: facets lie around the
  // circle, and a piece of tube is short.
  [[nodiscard]] double smooth_volume() const { return smooth_volume_; }
  [[nodiscard]] double volume() const { return smooth_volume_ * state_.volume; }

  // Goes on to a pressure [Pa] or volume [mm^3] that is no less than the present one.
  // @return false if there is no state of rest on the way; the last one is kept
  bool advance(Control control, double target) {
    double at = control == Control::pressure ? state_.pressure : state_.volume;
    double step = control == Control::pressure ? target - at
                                               : std::min(target - at, (kMostGrowth - 1.0) * at);
    while (step > 0.0) {
      const double next = target - at <= 1.001 * step ? target : at + step;
      if (try_state(control, next)) {
        at = next;
        step = std::min(2.0 * step, target - at);
        if (control == Control::volume) step = std::min(step, (kMostGrowth - 1.0) * at);
      } else {
        step = 0.5 * (next - at);
        if (step < kLeastStep * target) return false;
      }
    }
    return true;
  }

  [[nodiscard]] InflationPoint measure() const {
    InflationPoint point;
    point.pressure_atm = units::atm_from_pascal(state_.pressure);
    point.volume_mm3 = volume();
    point.energy_mj = 1e-6 * lengths_ * state_.energy;
    point.residual = state_.residual;
    point.length_mm = lengths_ * (mean_z(capsule_.last_ring) - mean_z(capsule_.first_ring));
    point.diameter_mm = 2.0 * mean_radius(capsule_.middle_ring) / capsule_.circle_factor;
    point.wall_mm = thickness_at_middle();
    return point;
  }

 private:
  bool try_state(Control control, double target) {
    std::vector<Vec3> x = x_;
    const NewtonResult result =
        minimize(terms_, fixed_, x, newton_,
                 {capsule_.mesh.triangles, control, target, 0.0, state_.pressure});
    if (!result.converged || result.volume > kMostGrowth * state_.volume ||
        !(result.volume > state_.volume))
      return false;
    x_ = std::move(x);
    state_ = result;
    return true;
  }

  [[nodiscard]] double mean_z(int ring) const {
    double sum = 0.0;
    for (int k = 0; k < capsule_.around; ++k) sum += x_[std::size_t(ring * capsule_.around + k)].z;
    return sum / capsule_.around;
  }

  [[nodiscard]] double mean_radius(int ring) const {
    double sum = 0.0;
    for (int k = 0; k < capsule_.around; ++k) {
      const Vec3& p = x_[std::size_t(ring * capsule_.around + k)];
      sum += std::hypot(p.x, p.y);
    }
    return sum / capsule_.around;
  }

  // H / sqrt(I3) of the triangles on both sides of the middle ring.
  [[nodiscard]] double thickness_at_middle() const {
    const auto area = [](const std::vector<Vec3>& x, const Triangle& t) {
      const Vec3& a = x[std::size_t(t[0])];
      return norm(cross(x[std::size_t(t[1])] - a, x[std::size_t(t[2])] - a));
    };
    double before = 0.0, now = 0.0;
    const int first = capsule_.middle_ring * capsule_.around, last = first + capsule_.around;
    for (const Triangle& t : capsule_.skin)
      if (std::any_of(t.begin(), t.end(), [&](int v) { return v >= first && v < last; })) {
        before += area(capsule_.mesh.vertices, t);
        now += area(x_, t);
      }
    return wall_mm_ * before / now;
  }

  Capsule capsule_;
  double wall_mm_;
  MembraneTerm skin_;
  PlaneTerm plane_;
  std::vector<const EnergyTerm*> terms_;
  std::vector<char> fixed_;
  NewtonOptions newton_;
  std::vector<Vec3> x_;
  NewtonResult state_;
  double lengths_;  // of what is meshed in the balloon
  double smooth_volume_ = 1.0;
};

void check_volumes(const std::vector<double>& volumes, double unloaded) {
  for (const double v : volumes) {
    if (v >= unloaded * (1.0 - 1e-9)) continue;
    char text[250];
    std::snprintf(text, sizeof text,
                  "a volume of %g mm3 is asked for (the balloon encloses %g mm3 unloaded; below "
                  "that its thin wall collapses in folds). Ask for more",
                  v, unloaded);
    throw InputError(text, ExitCode::usage);
  }
}

}  // namespace

void FreeBalloon::validate() const {
  check("balloon.radius_mm", radius_mm, 0.1, 50.0);
  check("balloon.length_mm", length_mm, 0.5, 500.0);
  SimulationOptions options;
  options.balloon = material;
  options.validate();
  if (material.chart.empty()) return;
  const double charted = 0.5 * rest_diameter_mm(material.chart);
  check("balloon.radius_mm (of the chart)", radius_mm, 0.999 * charted, 1.001 * charted);
}

void InflateOptions::validate() const {
  if (pressures_atm.empty() == volumes_mm3.empty())
    throw OptionError("inflate.pressures and inflate.volumes are " +
                      std::string(volumes_mm3.empty() ? "both missing" : "both given") +
                      " (the balloon is held at one or the other). Give one of them");
  for (const double p : pressures_atm) check("inflate.pressures", p, 0.0, 100.0);
  for (const double v : volumes_mm3) check("inflate.volumes", v, 0.0, 1e7);
  check("inflate.around", around, 8.0, 256.0);
  if (around % 4 != 0)
    throw OptionError("inflate.around is " + std::to_string(around) +
                      " (it must be a multiple of 4)");
  check("inflate.tolerance", tolerance, 1e-12, 1e-3);
}

FreeBalloon free_balloon(const CatalogueBalloon& balloon) {
  balloon.validate();
  FreeBalloon free;
  free.radius_mm = 0.5 * rest_diameter_mm(balloon);
  free.length_mm = balloon.length_mm;
  free.material.name = balloon.material;
  free.material.wall_mm = balloon.wall_mm;
  free.material.chart = balloon.chart;
  return free;
}

std::vector<InflationPoint> inflate(const FreeBalloon& balloon, const InflateOptions& options,
                                    const Progress& progress) {
  balloon.validate();
  options.validate();
  Bench bench(balloon, options);
  const Control control = options.volumes_mm3.empty() ? Control::pressure : Control::volume;
  check_volumes(options.volumes_mm3, bench.volume());
  std::vector<double> targets;
  for (const double v : options.volumes_mm3) targets.push_back(v / bench.smooth_volume());
  for (const double p : options.pressures_atm) targets.push_back(units::pascal_from_atm(p));
  std::vector<std::size_t> order(targets.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return targets[a] < targets[b]; });
  std::vector<InflationPoint> points(targets.size());
  bool found = true;
  for (std::size_t i = 0; i < order.size(); ++i) {
    found = found && bench.advance(control, targets[order[i]]);
    points[order[i]] = bench.measure();
    points[order[i]].converged = found;
    progress.report(double(i + 1) / double(order.size()), "inflate");
  }
  return points;
}

}  // namespace angio::simulation
