#pragma once

#include <Eigen/SparseCore>
#include <vector>

namespace angio::simulation::detail {

/// L D L^T of a sparse symmetric matrix, not necessarily positive definite, by dense blocks: a
/// vertex has three unknowns and a wall many vertices on top of each other, so that columns come in
/// groups of the same pattern. Threads share subtrees of the elimination, then the strips of the
/// fronts above them: the same bits on any number of them. The signs of D are those of the
/// eigenvalues (Sylvester).
///
/// Source: Duff, Reid, ACM Trans. Math. Softw. 9 (1983) 302 (multifrontal elimination); Liu, SIAM
///         Rev. 34 (1992) 82 (elimination tree, its postorder, supernodes); ordering: Eigen's AMD
class SparseLdlt {
 public:
  using Matrix = Eigen::SparseMatrix<double>;

  /// Finds ordering and blocks of a pattern.
  ///
  /// @param lower  its lower triangle; every diagonal entry is there
  void analyze(const Matrix& lower);

  /// @param lower  of the pattern that was analysed
  /// @param shift  added to the diagonal
  /// @return       the number of negative eigenvalues; -1 where a pivot is zero or not finite
  int factorize(const Matrix& lower, double shift);

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const;

 private:
  using Dense = Eigen::MatrixXd;
  /// Columns that are eliminated together.
  struct Block {
    int first = 0, count = 0;    ///< columns
    int parent = -1;             ///< block that takes what is left
    std::vector<int> children;   ///< blocks that leave something to this one
    std::vector<int> rows;       ///< `count` own ones, then those below, ascending
    std::vector<int> in_parent;  ///< place of each row below among the parent's rows
    Dense l;                     ///< unit lower, shape [rows, count]; above its diagonal: not used
  };
  /// Blocks in postorder that depend on no other.
  struct Subtree {
    int first, last;
  };
  struct Entry {
    int row, column;  ///< places in the front
    int value;        ///< of the matrix
  };

  void order(const Matrix& lower);
  [[nodiscard]] std::vector<int> parents_of(const Matrix& pattern) const;
  void find_blocks(const Matrix& pattern, const std::vector<int>& parent);
  void place_in_parents();
  void find_subtrees();
  void place_entries(const Matrix& lower);
  // Factorises a block's front. @return as factorize, of the block alone
  int eliminate(int b, const Matrix& lower, double shift, std::vector<Dense>& left);

  std::vector<int> position_;  ///< of an unknown in the order of elimination
  std::vector<Block> blocks_;
  std::vector<int> block_of_;      ///< a column
  std::vector<Subtree> subtrees_;  ///< that threads share
  std::vector<int> trunk_;         ///< the blocks above them, from the leaves down
  std::vector<int> entry_begin_;
  std::vector<Entry> entries_;  ///< of the matrix, by block
  Eigen::VectorXd d_;
};

}  // namespace angio::simulation::detail
