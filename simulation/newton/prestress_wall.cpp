#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "simulation/materials/solid_flow.hpp"
#include "simulation/newton/wall_terms.hpp"
#include "simulation/wall.hpp"

/// How the wall's stress is found in the shape that was seen.
namespace angio::simulation {
namespace {

using namespace detail;

constexpr double kFirstStep = 1.0 / 3.0;  // of the pressure
constexpr double kLeastStep = 1.0 / 96.0;
constexpr double kGrowth = 1.5;  // of a step that went well
constexpr int kMostRounds = 60;
constexpr double kClose = 1e-3;        // [mm], sought
constexpr double kEnough = 1e-2;       // [mm], accepted
constexpr double kReduction = 0.6;     // of the imbalance, in one round
constexpr double kReuse = 0.8;         // of it, by a step with the last factorisation
constexpr double kLooser = 0.3;        // of the tissue's hold, each round that goes well
constexpr double kLeastHold = 3e-3;    // of it
constexpr double kGoodProgress = 0.8;  // of the displacement, from round to round
constexpr int kPatience = 8;           // rounds without any

// Of a pure stretch along the vessel that keeps the volume.
Mat3 axial_stretch(const Vec3& axial, double stretch) {
  const double across = 1.0 / std::sqrt(stretch);
  return across * Mat3::identity() + (stretch - across) * outer(axial, axial);
}

/// The iteration F0 <- dx/dX F0 (modified updated Lagrange: Gee, Foerster, Wall, Int. J. Numer.
/// Methods Biomed. Eng. 26 (2010) 52). It asks for no unloaded shape, which a wall without balance
/// need not have (an inverse displacement method goes through that shape, and buckles there); what
/// is sought, stresses in balance in the shape that was seen, is what it changes.
///
/// The surrounding tissue carries nothing in the shape that was seen. What its springs carry in a
/// round is therefore missing in the next: with their own stiffness the error falls as slowly as
/// they are stiff against the wall's bending. They are there to damp: their hold falls from round
/// to round, and rises where the wall does not come nearer.
class Prestress {
 public:
  Prestress(const LayeredWall& wall, const WallOptions& options)
      : wall_(wall),
        options_(options),
        model_(make_solid_model(wall, options)),
        stiffness_(model_.foundation),
        held_(stiffness_),
        solid_(model_),
        foundation_(held_, wall.vertices),
        enclosure_(lumen_enclosure(wall, 0.0)),
        newton_(
            {&solid_, &foundation_}, wall.fixed,
            {.most_iterations = 40, .tolerance = 1e-7, .reduction = kReduction, .reuse = kReuse},
            enclosure_) {
    out_.state = unloaded_state(wall);
    for (std::size_t p = 0; p < out_.state.prestress.size(); ++p)
      out_.state.prestress[p] = axial_stretch(wall.axial[p / kWedgePoints], options.axial_stretch);
  }

  WallSolution run() {
    double step = kFirstStep, last = 0.0;  // [mm]
    for (int round = 0; round < kMostRounds && step >= kLeastStep; ++round) {
      const double load = std::min(1.0, load_ + step);
      std::vector<Vec3> x = wall_.vertices;
      if (!balanced(load, x)) {
        if (load > load_)
          step *= 0.5;
        else
          hold_tighter();
        continue;
      }
      const bool is_full = load_ == 1.0;
      load_ = load;
      measure(x);
      if (load == 1.0 && (out_.displacement_mm <= kClose || is_stuck())) break;
      if (is_full && out_.displacement_mm > kGoodProgress * last)
        hold_tighter();
      else
        hold_ = std::max(kLeastHold, kLooser * hold_);
      last = out_.displacement_mm;
      gather(x);
      yield();
      step *= kGrowth;
    }
    out_.load = load_;
    out_.converged = load_ == 1.0 && out_.displacement_mm <= kEnough;
    return std::move(out_);
  }

 private:
  // A wall whose layers have no room buckles from round to round: none has come nearer for a while,
  // and this one is among the nearest.
  bool is_stuck() {
    if (out_.displacement_mm < kGoodProgress * nearest_mm_) {
      nearest_mm_ = out_.displacement_mm;
      rounds_since_ = 0;
      return false;
    }
    return nearest_mm_ > kEnough && ++rounds_since_ >= kPatience &&
           kGoodProgress * out_.displacement_mm <= nearest_mm_;
  }

  void hold_tighter() { hold_ = std::min(1.0, hold_ / (kLooser * kLooser)); }

  // Newton's method from the shape that was seen, as far as a round needs it.
  bool balanced(double load, std::vector<Vec3>& x) {
    set_memory(out_.state, model_);
    for (std::size_t v = 0; v < held_.size(); ++v) held_[v] = hold_ * stiffness_[v];
    enclosure_.target = load * units::kPascalPerKilopascal * options_.blood_pressure_kpa;
    const NewtonResult result = newton_.run(x);
    out_.iterations += result.iterations;
    out_.residual = result.residual;
    return result.converged;
  }

  void measure(const std::vector<Vec3>& x) {
    out_.displacement_mm = 0.0;
    for (std::size_t v = 0; v < x.size(); ++v)
      if (const double d = distance(x[v], wall_.vertices[v]); d > out_.displacement_mm) {
        out_.displacement_mm = d;
        out_.place = wall_.vertices[v];
      }
    out_.state.vertices = x;
  }

  // F0 <- dx/dX F0 with one dilatation per wedge, as its energy sees it.
  void gather(const std::vector<Vec3>& x) {
    for (std::size_t w = 0; w < model_.region.size(); ++w) {
      const std::array<Vec3, 6> now = corners_of(model_, static_cast<int>(w), x);
      const std::array<Vec3, 6> seen = corners_of(model_, static_cast<int>(w), wall_.vertices);
      const double ratio = wedge_volume(now.data()) / wedge_volume(seen.data());
      for (std::size_t q = 0; q < kWedgePoints; ++q) {
        Mat3& f0 = out_.state.prestress[kWedgePoints * w + q];
        const double volume = ratio * determinant(f0);
        f0 = solid::deformation(model_.mesh_points[kWedgePoints * w + q], now.data()) * f0;
        f0 = std::cbrt(volume / determinant(f0)) * f0;
      }
    }
  }

  // A wall that is seen at rest is nowhere above its yield stress: what would be hands its load on.
  void yield() {
    parallel_for(static_cast<std::ptrdiff_t>(model_.region.size()), [&](std::ptrdiff_t index) {
      const auto w = static_cast<std::size_t>(index);
      SolidWedge<double> wedge = model_.view(nullptr).wedge(static_cast<int>(w));
      wedge.law.creep = 0.0;  // it had all the time
      for (std::size_t q = 0; q < kWedgePoints; ++q) {
        Mat3& f0 = out_.state.prestress[kWedgePoints * w + q];
        const FlowStep<double> flow = flow_solid(wedge.law, wedge.fiber, f0, 0.0);
        if (flow.strain > 0.0) f0 = f0 * inverse(flow.growth);
      }
    });
  }

  const LayeredWall& wall_;
  const WallOptions& options_;
  SolidModel model_;
  std::vector<double> stiffness_;  // of the tissue [uN/mm], shape [vertex]
  std::vector<double> held_;       // what of it holds in this round
  SolidTerm solid_;
  FoundationTerm foundation_;
  Enclosure enclosure_;
  Minimizer newton_;
  double load_ = 0.0;                                       // share of the pressure that is reached
  double hold_ = 1.0;                                       // share of the tissue's stiffness
  double nearest_mm_ = std::numeric_limits<double>::max();  // under the full load
  int rounds_since_ = 0;
  WallSolution out_;
};

}  // namespace

WallSolution prestress_wall(const LayeredWall& wall, const WallOptions& options) {
  options.validate();
  check_wall(wall, options);
  return Prestress(wall, options).run();
}

}  // namespace angio::simulation
