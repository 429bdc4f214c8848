#include "simulation/newton/newton_system.hpp"

#include <algorithm>
#include <cmath>

namespace angio::simulation::detail {
namespace {

// Forces are measured against at least those of this strain: an unloaded state has none.
constexpr double kLeastStrain = 1e-6;

double extent(const std::vector<Vec3>& x) {
  double most = 0.0;
  for (const Vec3& p : x) most = std::max(most, distance(p, x[0]));
  return most;
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

double enclosed(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x) {
  if (triangles.empty()) return 0.0;
  const Vec3 origin = x[std::size_t(triangles[0][0])];
  double sum = 0.0;
  for (const auto& [a, b, c] : triangles)
    sum += dot(x[std::size_t(a)] - origin,
               cross(x[std::size_t(b)] - origin, x[std::size_t(c)] - origin));
  return sum / 6.0;
}

void Assembly::add_block(int i, int j, const Mat3& block) {
  if (wants_blocks_) blocks_.push_back({i, j, block});
}

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
                            double pressure, Part part) {
  assembly_.blocks_.clear();
  assembly_.wants_blocks_ = part != Part::gradient;
  gradient.setZero(unknown_count_);
  double squared = 0.0;
  for (const EnergyTerm* term : terms) {
    assembly_.gradient_.assign(x.size(), {});
    term->add(x, part == Part::all_clamped, assembly_);
    gradient += free_part(assembly_.gradient_);
    for (const Vec3& g : assembly_.gradient_) squared += norm_squared(g);
  }
  add_volume(x, pressure);
  if (assembly_.wants_blocks()) {
    find_pattern();
    fill_matrix();
  }
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

}  // namespace angio::simulation::detail
