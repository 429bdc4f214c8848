#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "pipeline/cli/ranking.hpp"
#include "pipeline/cli/variants.hpp"

namespace angio::pipeline {
namespace {

/// Few distinct numbers, so that candidates tie and dominate each other often.
std::vector<Standing> random_standings(unsigned seed, std::size_t count) {
  std::mt19937 random(seed);
  const auto below = [&](unsigned n) { return int(random() % n); };
  std::vector<Standing> standings;
  for (std::size_t c = 0; c < count; ++c) {
    Standing one{Certainty(std::max(0, below(5) - 2)), below(3), {}};
    for (int m = 0; m < 4; ++m) one.measures.push_back(below(4));
    standings.push_back(one);
  }
  if (seed % 3 == 0) standings[0].measures[2] = kNotMeasured;
  return standings;
}

TEST(Ranking, DoesNotDependOnTheOrderOfTheCandidates) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const auto standings = random_standings(seed, 12);
    const auto ranked = rank_candidates(standings);
    std::vector<std::size_t> order(standings.size());
    std::iota(order.begin(), order.end(), 0U);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed + 1000));
    std::vector<Standing> shuffled;
    for (const std::size_t c : order) shuffled.push_back(standings[c]);
    const auto again = rank_candidates(shuffled);
    for (std::size_t i = 0; i < order.size(); ++i) {
      EXPECT_EQ(again[i].rank, ranked[order[i]].rank) << seed;
      EXPECT_EQ(again[i].front, ranked[order[i]].front) << seed;
    }
  }
}

TEST(Ranking, PutsNoCandidateBeforeOneThatDominatesIt) {
  int pairs = 0;
  for (unsigned seed = 1; seed < 150; seed += 3) {  // all measures known
    const auto standings = random_standings(seed, 12);
    const auto ranked = rank_candidates(standings);
    for (std::size_t a = 0; a < standings.size(); ++a)
      for (std::size_t b = 0; b < standings.size(); ++b) {
        if (standings[a].certainty != Certainty::determined ||
            standings[b].certainty != Certainty::determined ||
            !dominates(standings[a], standings[b]))
          continue;
        ++pairs;
        EXPECT_LT(ranked[a].rank, ranked[b].rank) << seed;
      }
  }
  EXPECT_GT(pairs, 100);
}

TEST(Ranking, GoesByCertaintyThenByLimitsThenByTheRest) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const auto standings = random_standings(seed, 12);
    const auto ranked = rank_candidates(standings);
    for (std::size_t a = 0; a < standings.size(); ++a)
      for (std::size_t b = 0; b < standings.size(); ++b) {
        if (standings[a].certainty < standings[b].certainty) {
          EXPECT_LT(ranked[a].rank, ranked[b].rank);
        } else if (standings[a].certainty == Certainty::determined &&
                   standings[b].certainty == Certainty::determined &&
                   standings[a].missed < standings[b].missed) {
          EXPECT_LT(ranked[a].rank, ranked[b].rank);
        }
      }
  }
}

TEST(Ranking, EqualsShareARankAndTheNextOneCountsThem) {
  const Standing good{Certainty::determined, 0, {20, 25, 9, -1}},
      worse{Certainty::determined, 1, {20, 25, 9, -1}}, failed{Certainty::failed, 0, {}};
  const auto ranked = rank_candidates({failed, good, worse, good, failed});
  EXPECT_EQ(ranked[1].rank, 1);
  EXPECT_EQ(ranked[3].rank, 1);
  EXPECT_EQ(ranked[2].rank, 3);
  EXPECT_EQ(ranked[0].rank, 4);
  EXPECT_EQ(ranked[4].rank, 4);
}

TEST(Ranking, AMeasureThatIsNotKnownOfAllCountsForNone) {
  const auto one = [](double residual, double injury) {
    return Standing{Certainty::determined, 0, {residual, injury}};
  };
  const auto ranked = rank_candidates({one(20, 5), one(20, kNotMeasured), one(10, 50)});
  EXPECT_EQ(ranked[2].rank, 1);
  EXPECT_EQ(ranked[0].rank, 2);
  EXPECT_EQ(ranked[1].rank, 2);
  EXPECT_EQ(ranked[1].front, 2);
  EXPECT_EQ(ranked[2].front, 1);
}

}  // namespace
}  // namespace angio::pipeline
