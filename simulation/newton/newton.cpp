#include "simulation/newton/newton.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "simulation/newton/sparse_ldlt.hpp"

namespace angio::simulation::detail {

// The sparse linear system of one minimisation; its pattern and ordering are found once.
class NewtonSystem {
 public:
  NewtonSystem(const std::vector<char>& fixed, const Enclosure& enclosure);

  // Sums the terms at x: gradient, Hessian less pressure * V'', volume and V'.
  void assemble(const std::vector<const EnergyTerm*>& terms, const std::vector<Vec3>& x,
                double pressure, bool clamp);
  // LDL^T of the matrix + shift * its mean diagonal.
  // @return the number of negative eigenvalues; -1 where the factorisation broke down
  int factorize(double shift) { return solver_.factorize(matrix_, shift * mean_diagonal()); }

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    return solver_.solve(right);
  }
  // The vertices moved by t times a step of the free unknowns.
  [[nodiscard]] std::vector<Vec3> moved(const std::vector<Vec3>& x, const Eigen::VectorXd& step,
                                        double t) const;

  Eigen::VectorXd gradient;      // of the terms, free unknowns [uN]
  Eigen::VectorXd volume_slope;  // V' [mm^2]
  double force_scale = 0.0;      // root of the sum of the terms' squared forces [uN]
  double volume = 0.0;           // [mm^3]

 private:
  void add_volume(const std::vector<Vec3>& x, double pressure);
  void find_pattern();
  void fill_matrix();
  [[nodiscard]] double mean_diagonal() const;  // [uN/mm]
  [[nodiscard]] Eigen::VectorXd free_part(const std::vector<Vec3>& a) const;
  [[nodiscard]] int unknown(int v, int axis) const { return unknown_[std::size_t(3 * v + axis)]; }
  // Row and column in the lower triangle of entry (r, c) of block (i, j); row -1: it has no place.
  [[nodiscard]] std::pair<int, int> place(int i, int j, int r, int c) const;

  const Enclosure& enclosure_;
  std::vector<int> unknown_;  // of each vertex and axis; -1: it does not move
  int unknown_count_ = 0;
  Assembly assembly_;
  std::vector<std::pair<int, int>> pattern_;  // of the blocks that the slots belong to
  std::vector<int> slots_;                    // 9 a block, into the matrix's values
  std::vector<int> diagonal_slots_;
  Eigen::SparseMatrix<double> matrix_;
  SparseLdlt solver_;
};

namespace {

constexpr double kArmijo = 1e-4;
constexpr int kMostHalvings = 40;
constexpr double kFirstShift = 1e-5;  // of the mean diagonal
constexpr double kLastShift = 1e5;
// Forces are measured against at least those of this strain: an unloaded state has none.
constexpr double kLeastStrain = 1e-6;

double extent(const std::vector<Vec3>& x) {
  double most = 0.0;
  for (const Vec3& p : x) most = std::max(most, distance(p, x[0]));
  return most;
}

double enclosed(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x) {
  if (triangles.empty()) return 0.0;
  const Vec3 origin = x[std::size_t(triangles[0][0])];
  double sum = 0.0;
  for (const auto& [a, b, c] : triangles)
    sum += dot(x[std::size_t(a)] - origin,
               cross(x[std::size_t(b)] - origin, x[std::size_t(c)] - origin));
  return sum / 6.0;
}

// s [a]x, with [a]x b = a x b.
Mat3 cross_matrix(double s, const Vec3& a) {
  Mat3 m;
  m(0, 1) = -s * a.z;
  m(0, 2) = s * a.y;
  m(1, 0) = s * a.z;
  m(1, 2) = -s * a.x;
  m(2, 0) = -s * a.y;
  m(2, 1) = s * a.x;
  return m;
}

bool moves(char fixed, int axis) {
  const char own = axis == 0 ? kFixedX : (axis == 1 ? kFixedY : kFixedZ);
  return (fixed & char(kFixedAll | own)) == 0;
}

}  // namespace

void Assembly::add_block(int i, int j, const Mat3& block) { blocks_.push_back({i, j, block}); }

NewtonSystem::NewtonSystem(const std::vector<char>& fixed, const Enclosure& enclosure)
    : enclosure_(enclosure), unknown_(3 * fixed.size(), -1) {
  for (std::size_t v = 0; v < fixed.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      if (moves(fixed[v], axis)) unknown_[3 * v + std::size_t(axis)] = unknown_count_++;
}

Eigen::VectorXd NewtonSystem::free_part(const std::vector<Vec3>& a) const {
  Eigen::VectorXd out(unknown_count_);
  for (std::size_t v = 0; v < a.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      if (const int u = unknown(int(v), axis); u >= 0) out(u) = a[v][axis];
  return out;
}

std::vector<Vec3> NewtonSystem::moved(const std::vector<Vec3>& x, const Eigen::VectorXd& step,
                                      double t) const {
  std::vector<Vec3> out = x;
  for (std::size_t v = 0; v < x.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      if (const int u = unknown(int(v), axis); u >= 0) out[v][axis] += t * step(u);
  return out;
}

void NewtonSystem::assemble(const std::vector<const EnergyTerm*>& terms, const std::vector<Vec3>& x,
                            double pressure, bool clamp) {
  assembly_.blocks_.clear();
  gradient.setZero(unknown_count_);
  double squared = 0.0;
  for (const EnergyTerm* term : terms) {
    assembly_.gradient_.assign(x.size(), {});
    term->add(x, clamp, assembly_);
    gradient += free_part(assembly_.gradient_);
    for (const Vec3& g : assembly_.gradient_) squared += norm_squared(g);
  }
  add_volume(x, pressure);
  find_pattern();
  fill_matrix();
  force_scale = std::max(std::sqrt(squared + pressure * pressure * volume_slope.squaredNorm()),
                         kLeastStrain * mean_diagonal() * extent(x));
}

double NewtonSystem::mean_diagonal() const {
  double sum = 0.0;
  for (const int s : diagonal_slots_) sum += std::abs(matrix_.valuePtr()[s]);
  return sum / std::max(1, unknown_count_);
}

void NewtonSystem::add_volume(const std::vector<Vec3>& x, double pressure) {
  volume = enclosed(enclosure_.triangles, x);
  std::vector<Vec3> slope(x.size());
  if (enclosure_.triangles.empty()) {
    volume_slope = free_part(slope);
    return;
  }
  const Vec3 origin = x[std::size_t(enclosure_.triangles[0][0])];
  for (const Triangle& t : enclosure_.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3], m = t[(k + 2) % 3];
      const Vec3 opposite = x[std::size_t(m)] - origin;
      slope[std::size_t(m)] +=
          (1.0 / 6.0) * cross(x[std::size_t(i)] - origin, x[std::size_t(j)] - origin);
      // d2V/dx_i dx_j = -[x_m]x / 6
      assembly_.add_block(i, j, cross_matrix(pressure / 6.0, opposite));
    }
  volume_slope = free_part(slope);
}

std::pair<int, int> NewtonSystem::place(int i, int j, int r, int c) const {
  const int row = unknown(i, r), column = unknown(j, c);
  if (row < 0 || column < 0 || (i == j && r < c)) return {-1, -1};
  return {std::max(row, column), std::min(row, column)};
}

void NewtonSystem::find_pattern() {
  const auto& blocks = assembly_.blocks_;
  const auto same = [&] {
    if (pattern_.size() != blocks.size()) return false;
    for (std::size_t b = 0; b < blocks.size(); ++b)
      if (pattern_[b] != std::pair(blocks[b].i, blocks[b].j)) return false;
    return true;
  };
  if (!pattern_.empty() && same()) return;
  pattern_.clear();
  for (const auto& block : blocks) pattern_.emplace_back(block.i, block.j);
  std::vector<std::pair<int, int>> pairs;
  for (const auto& [i, j] : pattern_) pairs.emplace_back(std::minmax(i, j));
  const auto sort_out = [](std::vector<std::pair<int, int>>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  sort_out(pairs);
  std::vector<std::pair<int, int>> entries;  // column, row
  for (int u = 0; u < unknown_count_; ++u) entries.emplace_back(u, u);
  for (const auto& [i, j] : pairs)
    for (int k = 0; k < 9; ++k)
      if (const auto [row, column] = place(i, j, k / 3, k % 3); row >= 0)
        entries.emplace_back(column, row);
  sort_out(entries);
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(entries.size());
  for (const auto& [column, row] : entries) triplets.emplace_back(row, column, 1.0);
  matrix_.resize(unknown_count_, unknown_count_);
  matrix_.setFromTriplets(triplets.begin(), triplets.end());
  const auto slot = [&](int row, int column) {
    const int* rows = matrix_.innerIndexPtr();
    const int* begin = matrix_.outerIndexPtr() + column;
    return int(std::lower_bound(rows + begin[0], rows + begin[1], row) - rows);
  };
  slots_.assign(9 * blocks.size(), -1);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (int k = 0; k < 9; ++k)
      if (const auto [row, column] = place(blocks[b].i, blocks[b].j, k / 3, k % 3); row >= 0)
        slots_[9 * b + std::size_t(k)] = slot(row, column);
  diagonal_slots_.clear();
  for (int u = 0; u < unknown_count_; ++u) diagonal_slots_.push_back(slot(u, u));
  solver_.analyze(matrix_);
}

void NewtonSystem::fill_matrix() {
  double* values = matrix_.valuePtr();
  std::fill(values, values + matrix_.nonZeros(), 0.0);
  const auto& blocks = assembly_.blocks_;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (int k = 0; k < 9; ++k)
      if (const int s = slots_[9 * b + std::size_t(k)]; s >= 0)
        values[s] += blocks[b].value(k / 3, k % 3);
}

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
      system_.assemble(terms_, x, pressure_, false);
      result.residual = residual();
      if (result.iterations == 0) enough = std::max(enough, options_.reduction * result.residual);
      result.converged = result.residual <= enough;
      if (result.converged || result.iterations >= options_.most_iterations) break;
      if (result.iterations > 0 && result.residual > options_.reuse * before)
        factor_serves_ = false;
      before = result.residual;
      if (factor_serves_) {
        step_by_last_factor();
        if (move(x)) continue;
        factor_serves_ = false;
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
    system_.assemble(terms_, x, pressure_, true);
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
