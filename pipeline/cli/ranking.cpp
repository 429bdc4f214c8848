#include "pipeline/cli/ranking.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace angio::pipeline {
namespace {

bool is_determined(const Standing& s) { return s.certainty == Certainty::determined; }

/// The same with only the measures that every determined candidate has.
std::vector<Standing> comparable(std::vector<Standing> standings) {
  std::size_t measure_count = 0;
  for (const Standing& s : standings) measure_count = std::max(measure_count, s.measures.size());
  std::vector<char> is_known(measure_count, 1);
  for (const Standing& s : standings)
    for (std::size_t m = 0; m < measure_count && is_determined(s); ++m)
      if (m >= s.measures.size() || std::isnan(s.measures[m])) is_known[m] = 0;
  for (Standing& s : standings) {
    if (!is_determined(s)) {
      s = {s.certainty, 0, {}};
      continue;
    }
    std::vector<double> kept;
    for (std::size_t m = 0; m < measure_count; ++m)
      if (is_known[m] != 0) kept.push_back(s.measures[m]);
    s.measures = std::move(kept);
  }
  return standings;
}

/// Layer by layer: who is dominated by nobody that is left.
std::vector<int> fronts_of(const std::vector<Standing>& standings) {
  constexpr int kLeft = 0;
  std::vector<int> fronts(standings.size(), kLeft);
  const auto is_behind = [&](std::size_t c) {
    for (std::size_t other = 0; other < standings.size(); ++other)
      if (fronts[other] == kLeft && is_determined(standings[other]) &&
          standings[other].missed == standings[c].missed &&
          dominates(standings[other], standings[c]))
        return true;
    return false;
  };
  for (int front = 1;; ++front) {
    std::vector<std::size_t> layer;
    for (std::size_t c = 0; c < standings.size(); ++c)
      if (fronts[c] == kLeft && is_determined(standings[c]) && !is_behind(c)) layer.push_back(c);
    if (layer.empty()) break;
    for (const std::size_t c : layer) fronts[c] = front;
  }
  return fronts;
}

}  // namespace

bool dominates(const Standing& a, const Standing& b) {
  bool is_better = a.missed < b.missed;
  if (a.missed > b.missed) return false;
  for (std::size_t m = 0; m < std::min(a.measures.size(), b.measures.size()); ++m) {
    if (a.measures[m] > b.measures[m]) return false;
    is_better = is_better || a.measures[m] < b.measures[m];
  }
  return is_better;
}

std::vector<Ranked> rank_candidates(const std::vector<Standing>& given) {
  const std::vector<Standing> standings = comparable(given);
  const std::vector<int> fronts = fronts_of(standings);
  const auto key_of = [&](std::size_t c) {
    const Standing& s = standings[c];
    return std::tuple(s.certainty, s.missed, fronts[c], s.measures.empty() ? 0.0 : s.measures[0]);
  };
  std::vector<Ranked> ranked(standings.size());
  for (std::size_t c = 0; c < standings.size(); ++c) {
    ranked[c].front = fronts[c];
    for (std::size_t other = 0; other < standings.size(); ++other)
      if (key_of(other) < key_of(c)) ++ranked[c].rank;
  }
  return ranked;
}

}  // namespace angio::pipeline
