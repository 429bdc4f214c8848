#pragma once

#include <cstddef>
#include <vector>

#include "simulation/step/contact_pairs.hpp"

namespace angio::simulation::detail {

/// Candidates as a step takes them: those of a vertex by ascending gap, then by vertices, so that
/// their order depends neither on how they were found nor on the number of threads.
struct CandidateSet {
  std::vector<Candidate> candidates;
  std::vector<int> owned_begin;  ///< by first vertex, shape [vertex + 1]
  std::vector<int> ref_begin;    ///< shape [vertex + 1]; or empty
  std::vector<ContactRef> refs;  ///< candidates that a vertex is in, by ascending gap; or empty
  double search_radius = 0.0;    ///< [mm]
  double self_radius = 0.0;      ///< of a surface with itself [mm]
};

/// @param candidates  all pairs nearer than `radius`, in any order
/// @param lists       are those that each vertex is in listed (ref_begin, refs)?
CandidateSet index_candidates(std::size_t vertex_count, const std::vector<Candidate>& candidates,
                              double radius, bool lists = true);

}  // namespace angio::simulation::detail
