#include "simulation/newton/sparse_ldlt.hpp"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.hpp"
#include "simulation/newton/eliminate_front.hpp"

namespace angio::simulation::detail {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

// The lower triangle with its unknowns renumbered, columns sorted.
SparseLdlt::Matrix renumbered(const SparseLdlt::Matrix& lower, const std::vector<int>& position) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(at(lower.nonZeros()));
  for (int column = 0; column < lower.outerSize(); ++column)
    for (SparseLdlt::Matrix::InnerIterator it(lower, column); it; ++it) {
      const int a = position[at(it.row())], b = position[at(it.col())];
      entries.emplace_back(std::max(a, b), std::min(a, b), 1.0);
    }
  SparseLdlt::Matrix out(lower.rows(), lower.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

// Children before parents, each subtree in one piece.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int count = static_cast<int>(parent.size());
  std::vector<int> first_child(parent.size(), -1), next(parent.size(), -1), place(parent.size());
  std::vector<int> roots;
  for (int i = count - 1; i >= 0; --i) {
    if (parent[at(i)] < 0) {
      roots.push_back(i);
      continue;
    }
    next[at(i)] = first_child[at(parent[at(i)])];
    first_child[at(parent[at(i)])] = i;
  }
  std::vector<int> stack = roots;
  int done = 0;
  while (!stack.empty()) {
    const int i = stack.back();
    if (const int child = first_child[at(i)]; child >= 0) {
      first_child[at(i)] = next[at(child)];
      stack.push_back(child);
    } else {
      place[at(i)] = done++;
      stack.pop_back();
    }
  }
  return place;
}

}  // namespace

void SparseLdlt::analyze(const Matrix& lower) {
  order(lower);
  const Matrix pattern = renumbered(lower, position_);
  find_blocks(pattern, parents_of(pattern));
  place_in_parents();
  find_subtrees();
  place_entries(lower);
}

void SparseLdlt::order(const Matrix& lower) {
  const Matrix whole = lower.selfadjointView<Eigen::Lower>();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(whole, permutation);
  position_.resize(at(lower.rows()));
  for (int i = 0; i < static_cast<int>(position_.size()); ++i)  // it maps places to unknowns
    position_[at(permutation.indices()(i))] = i;
  const std::vector<int> place = postorder(parents_of(renumbered(lower, position_)));
  for (int& p : position_) p = place[at(p)];
}

// The elimination tree: the first row below the diagonal of each column of L (Liu 1992, 4.2).
std::vector<int> SparseLdlt::parents_of(const Matrix& pattern) const {
  const Matrix rows = pattern.transpose();  // column i: the entries of row i left of the diagonal
  std::vector<int> parent(at(pattern.cols()), -1), ancestor(parent.size(), -1);
  for (int i = 0; i < rows.outerSize(); ++i)
    for (Matrix::InnerIterator it(rows, i); it; ++it)
      for (int k = static_cast<int>(it.row()); k != i;) {
        const int up = ancestor[at(k)];
        ancestor[at(k)] = i;
        if (up < 0) {
          parent[at(k)] = i;
          break;
        }
        k = up;
      }
  return parent;
}

// Chains of columns whose patterns are the same, or nearly: a few zeros more are worth it.
void SparseLdlt::find_blocks(const Matrix& pattern, const std::vector<int>& parent) {
  constexpr std::size_t kMoreRows = 12;
  std::size_t first_size = 0;  // of the front that the block's first column asks for
  const auto columns = static_cast<int>(parent.size());
  std::vector<std::vector<int>> below(parent.size());  // rows of each column, until they are used
  blocks_.clear();
  block_of_.assign(parent.size(), -1);
  for (int j = 0; j < columns; ++j) {
    std::vector<int> rows = std::move(below[at(j)]);
    for (Matrix::InnerIterator it(pattern, j); it; ++it)
      if (it.row() > j) rows.push_back(static_cast<int>(it.row()));
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (parent[at(j)] >= 0) {
      std::vector<int>& up = below[at(parent[at(j)])];
      std::copy_if(rows.begin(), rows.end(), std::back_inserter(up),
                   [&](int r) { return r != parent[at(j)]; });
    }
    Block* last = blocks_.empty() ? nullptr : &blocks_.back();
    // What the last column had below it, this one has too.
    const bool follows = last != nullptr && parent[at(j - 1)] == j &&
                         at(last->count) + 1 + rows.size() <= first_size + kMoreRows;
    if (!follows) {
      blocks_.push_back({});
      last = &blocks_.back();
      last->first = j;
      first_size = 1 + rows.size();
    }
    ++last->count;
    last->rows = std::move(rows);  // below this column; its block's own are put before them below
    block_of_[at(j)] = static_cast<int>(blocks_.size()) - 1;
  }
  for (Block& block : blocks_) {
    std::vector<int> own(at(block.count));
    std::iota(own.begin(), own.end(), block.first);
    block.rows.insert(block.rows.begin(), own.begin(), own.end());
  }
}

void SparseLdlt::place_in_parents() {
  for (Block& block : blocks_) {
    if (block.rows.size() == at(block.count)) continue;
    block.parent = block_of_[at(block.rows[at(block.count)])];
    blocks_[at(block.parent)].children.push_back(static_cast<int>(&block - blocks_.data()));
    const std::vector<int>& rows = blocks_[at(block.parent)].rows;
    for (std::size_t r = at(block.count); r < block.rows.size(); ++r)
      block.in_parent.push_back(static_cast<int>(
          std::lower_bound(rows.begin(), rows.end(), block.rows[r]) - rows.begin()));
  }
}

void SparseLdlt::place_entries(const Matrix& lower) {
  std::vector<std::vector<Entry>> lists(blocks_.size());
  for (int column = 0, value = 0; column < lower.outerSize(); ++column)
    for (Matrix::InnerIterator it(lower, column); it; ++it, ++value) {
      const int a = position_[at(it.row())], b = position_[at(it.col())];
      const int block = block_of_[at(std::min(a, b))];
      const std::vector<int>& rows = blocks_[at(block)].rows;
      lists[at(block)].push_back(
          {static_cast<int>(std::lower_bound(rows.begin(), rows.end(), std::max(a, b)) -
                            rows.begin()),
           std::min(a, b) - blocks_[at(block)].first, value});
    }
  entries_.clear();
  entry_begin_.assign(1, 0);
  for (const auto& list : lists) {
    entries_.insert(entries_.end(), list.begin(), list.end());
    entry_begin_.push_back(static_cast<int>(entries_.size()));
  }
}

// Subtrees of about equal work, which can be eliminated at the same time. In postorder the blocks
// of a subtree are in one piece.
void SparseLdlt::find_subtrees() {
  constexpr double kMostShare = 1.0 / 32.0;  // of all work
  std::vector<double> work(blocks_.size(), 0.0);
  std::vector<int> first(blocks_.size());
  double whole = 0.0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) first[b] = static_cast<int>(b);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    const auto rows = static_cast<double>(block.rows.size());
    work[b] += rows * rows * block.count;
    whole += rows * rows * block.count;
    if (block.parent < 0) continue;
    work[at(block.parent)] += work[b];
    first[at(block.parent)] = std::min(first[at(block.parent)], first[b]);
  }
  const auto is_small = [&](int b) { return work[at(b)] <= kMostShare * whole; };
  subtrees_.clear();
  trunk_.clear();
  for (int b = 0; b < static_cast<int>(blocks_.size()); ++b) {
    const int parent = blocks_[at(b)].parent;
    if (!is_small(b))
      trunk_.push_back(b);
    else if (parent < 0 || !is_small(parent))
      subtrees_.push_back({first[at(b)], b});
  }
  std::stable_sort(subtrees_.begin(), subtrees_.end(), [&](const Subtree& a, const Subtree& b) {
    return work[at(a.last)] > work[at(b.last)];
  });
}

int SparseLdlt::factorize(const Matrix& lower, double shift) {
  d_.resize(lower.rows());
  std::vector<Dense> left(blocks_.size());  // what a block's elimination leaves to its parent
  std::vector<int> negative(blocks_.size(), 0);
  parallel_for_uneven(static_cast<std::ptrdiff_t>(subtrees_.size()), [&](std::ptrdiff_t s) {
    for (int b = subtrees_[at(s)].first; b <= subtrees_[at(s)].last; ++b)
      negative[at(b)] = eliminate(b, lower, shift, left);
  });
  for (const int b : trunk_) negative[at(b)] = eliminate(b, lower, shift, left);
  int sum = 0;
  for (const int own : negative) {
    if (own < 0) return -1;
    sum += own;
  }
  return sum;
}

int SparseLdlt::eliminate(int b, const Matrix& lower, double shift, std::vector<Dense>& left) {
  Block& block = blocks_[at(b)];
  const auto size = static_cast<Eigen::Index>(block.rows.size());
  Dense front = Dense::Zero(size, size);
  for (int e = entry_begin_[at(b)]; e < entry_begin_[at(b) + 1]; ++e)
    front(entries_[at(e)].row, entries_[at(e)].column) += lower.valuePtr()[entries_[at(e)].value];
  for (Eigen::Index i = 0; i < block.count; ++i) front(i, i) += shift;
  for (const int child : block.children) {
    const std::vector<int>& to = blocks_[at(child)].in_parent;
    Dense& from = left[at(child)];
    for (Eigen::Index j = 0; j < from.cols(); ++j)
      for (Eigen::Index i = j; i < from.rows(); ++i) front(to[at(i)], to[at(j)]) += from(i, j);
    from.resize(0, 0);
  }
  const int negative = eliminate_front(front.data(), size, block.count, d_.data() + block.first);
  block.l = front.leftCols(block.count);
  const Eigen::Index rest = size - block.count;
  if (block.parent >= 0) left[at(b)] = front.bottomRightCorner(rest, rest);
  return negative;
}

Eigen::VectorXd SparseLdlt::solve(const Eigen::VectorXd& right) const {
  Eigen::VectorXd x(right.size());
  for (Eigen::Index i = 0; i < right.size(); ++i) x(position_[at(i)]) = right(i);
  Eigen::VectorXd gathered;
  for (const Block& block : blocks_) {
    auto own = x.segment(block.first, block.count);
    block.l.topRows(block.count).triangularView<Eigen::UnitLower>().solveInPlace(own);
    gathered = block.l.bottomRows(block.l.rows() - block.count) * own;
    for (Eigen::Index i = 0; i < gathered.size(); ++i)
      x(block.rows[at(i + block.count)]) -= gathered(i);
  }
  x = x.cwiseQuotient(d_);
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    const Eigen::Index rest = block->l.rows() - block->count;
    gathered.resize(rest);
    for (Eigen::Index i = 0; i < rest; ++i) gathered(i) = x(block->rows[at(i + block->count)]);
    auto own = x.segment(block->first, block->count);
    own -= block->l.bottomRows(rest).transpose() * gathered;
    block->l.topRows(block->count).transpose().triangularView<Eigen::UnitUpper>().solveInPlace(own);
  }
  Eigen::VectorXd out(right.size());
  for (Eigen::Index i = 0; i < right.size(); ++i) out(i) = x(position_[at(i)]);
  return out;
}

}  // namespace angio::simulation::detail
