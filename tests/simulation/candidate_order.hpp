#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "simulation/contact/candidates.hpp"

namespace angio::simulation::testing {

/// Candidates by their vertices: those of two searches can then be told apart one by one.
inline std::vector<detail::Candidate> by_vertices(std::vector<detail::Candidate> candidates) {
  const auto key = [](const detail::Candidate& c) {
    return std::tuple(c.edges, c.vertex[0], c.vertex[1], c.vertex[2], c.vertex[3]);
  };
  std::sort(candidates.begin(), candidates.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return candidates;
}

}  // namespace angio::simulation::testing
