#include "simulation/newton/newton.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/newton/newton_system.hpp"

namespace angio::simulation::detail {

namespace {

constexpr double kArmijo = 1e-4;
constexpr int kMostHalvings = 40;
constexpr double kFirstShift = 1e-5;  // of the mean diagonal
constexpr double kLastShift = 1e5;
}  // namespace

// The loop over Newton's steps.
class Minimizer::Loop {
 public:
  Loop(std::vector<const EnergyTerm*> terms, const std::vector<char>& fixed,
       const NewtonOptions& options, const Enclosure& enclosure)
      : terms_(std::move(terms)),
        options_(options),
        enclosure_(enclosure),
        system_(fixed, enclosure) {}

  NewtonResult run(std::vector<Vec3>& x) {
    NewtonResult result;
    pressure_ = enclosure_.control == Enclosure::Control::pressure ? enclosure_.target
                                                                   : enclosure_.pressure_start;
    double enough = options_.tolerance, before = 0.0;
    for (;; ++result.iterations) {
      set_gas_pressure(enclosed(enclosure_.triangles, x));
      system_.assemble(terms_, x, pressure_, factor_serves_ ? Part::gradient : Part::all);
      result.residual = residual();
      if (result.iterations == 0) enough = std::max(enough, options_.reduction * result.residual);
      result.converged = result.residual <= enough;
      if (result.converged || result.iterations >= options_.most_iterations) break;
      const bool had_factor = factor_serves_;
      if (result.iterations > 0 && result.residual > options_.reuse * before)
        factor_serves_ = false;
      before = result.residual;
      if (had_factor) {
        if (factor_serves_) {
          step_by_last_factor();
          if (move(x)) continue;
          factor_serves_ = false;
        }
        system_.assemble(terms_, x, pressure_, Part::all);
      }
      if (!find_step(x) || !move(x)) break;
    }
    result.pressure = pressure_;
    result.volume = system_.volume;
    result.energy = energy(x);
    return result;
  }

 private:
  using Control = Enclosure::Control;
  using Part = NewtonSystem::Part;
  [[nodiscard]] bool holds(Control control) const {
    return !enclosure_.triangles.empty() && enclosure_.control == control;
  }

  void set_gas_pressure(double volume) {
    if (holds(Control::gas)) pressure_ = enclosure_.target / volume - enclosure_.outside;
  }

  [[nodiscard]] double residual() const {
    const double force = (system_.gradient - pressure_ * system_.volume_slope).norm();
    double r = system_.force_scale > 0.0 ? force / system_.force_scale : 0.0;
    if (holds(Control::volume)) r = std::max(r, std::abs(system_.volume / enclosure_.target - 1.0));
    return r;
  }

  [[nodiscard]] double energy(const std::vector<Vec3>& x) const {
    double sum = 0.0;
    for (const EnergyTerm* term : terms_) sum += term->value(x);
    return sum;
  }

  // What the line search lessens.
  [[nodiscard]] double merit(const std::vector<Vec3>& x) const {
    const double e = energy(x);
    if (enclosure_.triangles.empty()) return e;
    const double v = enclosed(enclosure_.triangles, x);
    if (holds(Control::pressure)) return e - pressure_ * v;
    if (holds(Control::gas))
      return v > 0.0 ? e - enclosure_.target * std::log(v) + enclosure_.outside * v
                     : std::numeric_limits<double>::infinity();
    return e + penalty_ * std::abs(v - enclosure_.target);
  }

  [[nodiscard]] bool is_coupled() const { return holds(Control::volume) || holds(Control::gas); }

  // A step by a matrix that described a minimum at another place: a descent all the same.
  void step_by_last_factor() {
    step_ = system_.solve(pressure_ * system_.volume_slope - system_.gradient);
    pressure_step_ = 0.0;
  }

  // The step of the free unknowns, with the matrix changed until it describes a minimum.
  bool find_step(const std::vector<Vec3>& x) {
    if (try_shift(0.0)) {
      factor_serves_ = options_.reuse > 0.0 && !is_coupled();
      return true;
    }
    system_.assemble(terms_, x, pressure_, Part::all_clamped);
    for (double shift = std::max(kFirstShift, 0.1 * last_shift_); shift < kLastShift; shift *= 10.0)
      if (try_shift(shift)) {
        last_shift_ = shift;
        return true;
      }
    return false;
  }

  bool try_shift(double shift) {
    const int negative = system_.factorize(shift);
    if (negative < 0) return false;
    const Eigen::VectorXd out = pressure_ * system_.volume_slope - system_.gradient;
    step_ = system_.solve(out);
    pressure_step_ = 0.0;
    if (enclosure_.triangles.empty() || holds(Control::pressure)) return negative == 0;
    by_pressure_ = system_.solve(system_.volume_slope);
    const double compliance = system_.volume_slope.dot(by_pressure_);  // dV/dp
    const double grown = system_.volume_slope.dot(step_);
    if (holds(Control::volume)) {
      if (!(negative == 0 ? compliance > 0.0 : negative == 1 && compliance < 0.0)) return false;
      pressure_step_ = (enclosure_.target - system_.volume - grown) / compliance;
    } else {
      const double stiffness = (pressure_ + enclosure_.outside) / system_.volume;  // -dp/dV
      const double divisor = 1.0 + stiffness * compliance;
      if (!(negative == 0 ? divisor > 0.0 : negative == 1 && divisor < 0.0)) return false;
      pressure_step_ = -stiffness * grown / divisor;
    }
    step_ += pressure_step_ * by_pressure_;
    return true;
  }

  // Moves along the step as far as it lessens the merit.
  bool move(std::vector<Vec3>& x) {
    penalty_ = 1.5 * std::max(std::abs(pressure_), std::abs(pressure_ + pressure_step_));
    double slope = (system_.gradient - pressure_ * system_.volume_slope).dot(step_);
    if (holds(Control::volume))
      slope += pressure_ * system_.volume_slope.dot(step_) -
               penalty_ * std::abs(system_.volume - enclosure_.target);
    const double before = merit(x);
    // Below this a difference of energies is rounding.
    const double noise = 1e-13 * (std::abs(before) + std::abs(pressure_) * system_.volume);
    double t = std::min(1.0, options_.longest_move / std::max(longest(), 1e-300));
    for (int k = 0; k < kMostHalvings; ++k, t *= 0.5) {
      std::vector<Vec3> trial = system_.moved(x, step_, t);
      const double enough = before + kArmijo * t * slope + noise;
      if (merit(trial) <= enough || corrected(trial, t, enough)) {
        x = std::move(trial);
        pressure_ += t * pressure_step_;
        return true;
      }
    }
    return false;
  }

  // A whole step under volume control misses the volume by its own curvature: a second step towards
  // it keeps the line search from cutting good steps (the Maratos effect).
  bool corrected(std::vector<Vec3>& trial, double t, double enough) const {
    if (!holds(Control::volume) || t < 1.0) return false;
    const double missing = enclosure_.target - enclosed(enclosure_.triangles, trial);
    std::vector<Vec3> better =
        system_.moved(trial, by_pressure_, missing / system_.volume_slope.dot(by_pressure_));
    if (!(merit(better) <= enough)) return false;
    trial = std::move(better);
    return true;
  }

  [[nodiscard]] double longest() const {  // of one coordinate, near enough
    return step_.size() > 0 ? step_.cwiseAbs().maxCoeff() : 0.0;
  }

  std::vector<const EnergyTerm*> terms_;
  NewtonOptions options_;
  const Enclosure& enclosure_;
  NewtonSystem system_;
  bool factor_serves_ = false;  // that of the last step
  double pressure_ = 0.0, pressure_step_ = 0.0, penalty_ = 0.0, last_shift_ = 0.0;
  Eigen::VectorXd step_, by_pressure_;
};

Minimizer::Minimizer(std::vector<const EnergyTerm*> terms, const std::vector<char>& fixed,
                     const NewtonOptions& options, const Enclosure& enclosure)
    : loop_(std::make_unique<Loop>(std::move(terms), fixed, options, enclosure)) {}
Minimizer::~Minimizer() = default;
NewtonResult Minimizer::run(std::vector<Vec3>& x) { return loop_->run(x); }

NewtonResult minimize(const std::vector<const EnergyTerm*>& terms, const std::vector<char>& fixed,
                      std::vector<Vec3>& x, const NewtonOptions& options,
                      const Enclosure& enclosure) {
  return Minimizer(terms, fixed, options, enclosure).run(x);
}

double InertiaTerm::value(const std::vector<Vec3>& x) const {
  double sum = 0.0;
  for (std::size_t v = 0; v < x.size(); ++v)
    sum += 0.5 * mass_[v] / (dt_ * dt_) * norm_squared(x[v] - x_inertial_[v]);
  return sum;
}

void InertiaTerm::add(const std::vector<Vec3>& x, bool, Assembly& out) const {
  for (std::size_t v = 0; v < x.size(); ++v) {
    const double k = mass_[v] / (dt_ * dt_);
    out.add_gradient(int(v), k * (x[v] - x_inertial_[v]));
    out.add_block(int(v), int(v), k * Mat3::identity());
  }
}

}  // namespace angio::simulation::detail
