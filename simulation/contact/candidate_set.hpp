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
  SearchRadii<double> radii;
};

/// @param candidates  all pairs nearer than `radius`, in any order
CandidateSet index_candidates(std::size_t vertex_count, const std::vector<Candidate>& candidates,
                              double radius);

}  // namespace angio::simulation::detail
