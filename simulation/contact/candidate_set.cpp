#include "simulation/contact/candidate_set.hpp"

#include <algorithm>
#include <numeric>

#include "core/parallel.hpp"
#include "simulation/contact/candidate_gap.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kChunks = 32;

}  // namespace

CandidateSet index_candidates(std::size_t vertex_count, const std::vector<Candidate>& candidates,
                              double radius) {
  CandidateSet set;
  set.radii.search = radius;
  set.owned_begin.assign(vertex_count + 1, 0);
  for (const Candidate& c : candidates) ++set.owned_begin[std::size_t(c.vertex[0]) + 1];
  std::partial_sum(set.owned_begin.begin(), set.owned_begin.end(), set.owned_begin.begin());
  std::vector<int> next = set.owned_begin;
  set.candidates.resize(candidates.size());
  for (const Candidate& c : candidates)
    set.candidates[std::size_t(next[std::size_t(c.vertex[0])]++)] = c;
  const auto begin = set.candidates.begin();
  const auto first_owner = [&](std::ptrdiff_t chunk) {  // of about as many candidates each
    const auto share = int(std::ptrdiff_t(candidates.size()) * chunk / kChunks);
    return std::lower_bound(set.owned_begin.begin(), set.owned_begin.end() - 1, share);
  };
  parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
    for (auto owner = first_owner(chunk); owner != first_owner(chunk + 1); ++owner)
      std::sort(begin + owner[0], begin + owner[1], comes_before);
  });
  return set;
}

}  // namespace angio::simulation::detail
