#pragma once

#include <utility>
#include <vector>

#include "simulation/newton/newton.hpp"
#include "simulation/newton/sparse_ldlt.hpp"

namespace angio::simulation::detail {

/// The volume inside a closed surface [mm^3]; without triangles 0.
double enclosed(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x);

/// The sparse linear system of one minimisation; its pattern and ordering are found once.
class NewtonSystem {
 public:
  NewtonSystem(const std::vector<char>& fixed, const Enclosure& enclosure);

  /// What is summed.
  enum class Part {
    gradient,  ///< the matrix stays that of the last time
    all,
    all_clamped,  ///< EnergyTerm::add
  };
  /// Sums the terms at x: gradient, volume and V', and the matrix, Hessian less pressure * V''.
  void assemble(const std::vector<const EnergyTerm*>& terms, const std::vector<Vec3>& x,
                double pressure, Part part);
  /// LDL^T of the matrix + shift * its mean diagonal.
  /// @return the number of negative eigenvalues; -1 where the factorisation broke down
  int factorize(double shift) { return solver_.factorize(matrix_, shift * mean_diagonal()); }

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
    return solver_.solve(right);
  }
  /// The vertices moved by t times a step of the free unknowns.
  [[nodiscard]] std::vector<Vec3> moved(const std::vector<Vec3>& x, const Eigen::VectorXd& step,
                                        double t) const;

  Eigen::VectorXd gradient;      ///< of the terms, free unknowns [uN]
  Eigen::VectorXd volume_slope;  ///< V' [mm^2]
  double force_scale = 0.0;      ///< root of the sum of the terms' squared forces [uN]
  double volume = 0.0;           ///< [mm^3]

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

}  // namespace angio::simulation::detail
