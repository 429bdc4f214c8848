#include "simulation/contact/candidate_set.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <tuple>

#include "core/parallel.hpp"

namespace angio::simulation::detail {
namespace {

constexpr int kChunks = 32;

// counts[i]++ by any thread. What is put in order by it must be sorted afterwards.
std::size_t take_next(std::vector<int>& counts, int i) {
  return std::size_t(
      std::atomic_ref(counts[std::size_t(i)]).fetch_add(1, std::memory_order_relaxed));
}

// The candidates that each vertex is in.
void list_candidates(std::size_t vertex_count, CandidateSet& set) {
  const std::size_t count = set.candidates.size();
  set.ref_begin.assign(vertex_count + 1, 0);
  set.refs.resize(4 * count);
  const auto for_candidates = [&](const auto& body) {
    parallel_for(std::ptrdiff_t(count), [&](std::ptrdiff_t c) { body(std::size_t(c)); });
  };
  for_candidates([&](std::size_t c) {
    for (const int v : set.candidates[c].vertex) take_next(set.ref_begin, v + 1);
  });
  std::partial_sum(set.ref_begin.begin(), set.ref_begin.end(), set.ref_begin.begin());
  std::vector<int> next = set.ref_begin;
  for_candidates([&](std::size_t c) {
    for (int corner = 0; corner < 4; ++corner)
      set.refs[take_next(next, set.candidates[c].vertex[corner])] = {int(c), corner};
  });
  const auto key = [&](const ContactRef& ref) {
    return std::tuple(set.candidates[std::size_t(ref.pair)].gap, ref.pair, ref.corner);
  };
  parallel_for_uneven(std::ptrdiff_t(vertex_count), [&](std::ptrdiff_t v) {
    std::sort(set.refs.begin() + set.ref_begin[std::size_t(v)],
              set.refs.begin() + set.ref_begin[std::size_t(v) + 1],
              [&](const ContactRef& a, const ContactRef& b) { return key(a) < key(b); });
  });
}

}  // namespace

CandidateSet index_candidates(std::size_t vertex_count, const std::vector<Candidate>& candidates,
                              double radius, bool lists) {
  CandidateSet set;
  set.search_radius = radius;
  set.owned_begin.assign(vertex_count + 1, 0);
  for (const Candidate& c : candidates) ++set.owned_begin[std::size_t(c.vertex[0]) + 1];
  std::partial_sum(set.owned_begin.begin(), set.owned_begin.end(), set.owned_begin.begin());
  std::vector<int> next = set.owned_begin;
  set.candidates.resize(candidates.size());
  for (const Candidate& c : candidates)
    set.candidates[std::size_t(next[std::size_t(c.vertex[0])]++)] = c;
  const auto key = [](const Candidate& c) {
    return std::tuple(c.gap, c.edges, c.vertex[1], c.vertex[2], c.vertex[3]);
  };
  const auto begin = set.candidates.begin();
  const auto first_owner = [&](std::ptrdiff_t chunk) {  // of about as many candidates each
    const auto share = int(std::ptrdiff_t(candidates.size()) * chunk / kChunks);
    return std::lower_bound(set.owned_begin.begin(), set.owned_begin.end() - 1, share);
  };
  parallel_for_uneven(kChunks, [&](std::ptrdiff_t chunk) {
    for (auto owner = first_owner(chunk); owner != first_owner(chunk + 1); ++owner)
      std::sort(begin + owner[0], begin + owner[1],
                [&](const Candidate& a, const Candidate& b) { return key(a) < key(b); });
  });
  if (lists) list_candidates(vertex_count, set);
  return set;
}

}  // namespace angio::simulation::detail
