#pragma once

#include <vector>

namespace angio::pipeline {

/// How sure a candidate's result is; the better first.
enum class Certainty { determined, not_determined, failed };

/// What a candidate is ranked by.
struct Standing {
  Certainty certainty = Certainty::failed;
  int missed = 0;                ///< limits that it does not keep
  std::vector<double> measures;  ///< less is better, the deciding one first; NaN: not known
};

struct Ranked {
  int rank = 1;  ///< 1 and one more for each candidate that is better; equal ones share it
  int front =
      0;  ///< among those that miss as many limits: 0, dominated by none; 1, by some of 0...
};

/// Whether `a` is nowhere worse than `b`, in limits missed and in measures, and somewhere better.
///
/// @param a, b  determined; what is not known of one of them does not count
bool dominates(const Standing& a, const Standing& b);

/// Determined results come before those that are not, and those before failures, which are equal
/// among themselves. Of the determined ones come first: fewer limits missed; the earlier front of
/// dominance (Pareto's, layer by layer); the smaller first measure. So no candidate comes before
/// one that dominates it. A measure that is not known of every determined candidate counts for
/// none.
///
/// @param standings  shape [candidate]; as many measures each
/// @return shape [candidate], in the same order; it depends on no candidate's place
std::vector<Ranked> rank_candidates(const std::vector<Standing>& standings);

}  // namespace angio::pipeline
