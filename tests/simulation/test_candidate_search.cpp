#include <gtest/gtest.h>

#include "testing/simulation/candidate_cases.hpp"
#include "testing/simulation/search_loops.hpp"

namespace angio::simulation::detail {
namespace {

// A search in the computer's memory, its loops in any order.
template <class Real>
struct Search {
  HostMemory memory;
  CandidateSearch<Real> view;

  Search(testing::CandidateCase<Real>& c, int capacity) {
    view = make_candidate_search<Real>(c.scene, c.options, 4, memory);
    view.x = c.x.data();
    view.velocity = c.velocity.data();
    view.x_before = c.x_before.data();
    view.status = &c.status;
    const auto size = std::size_t(capacity);
    view.capacity = capacity;
    view.found = memory.allocate<Candidate>(size);
    view.owned = memory.allocate<FoundEntry>(size);
    view.entries = memory.allocate<FoundEntry>(4 * size);
    view.list = memory.allocate<Candidate>(size);
    view.refs = memory.allocate<ContactRef>(4 * size);
  }

  void run(unsigned seed) {
    testing::ShuffledLoops loops(seed);
    search_candidates(loops, view);
  }

  [[nodiscard]] testing::FoundCandidates found() const {
    const auto count = std::size_t(*view.found_count()),
               vertices = std::size_t(view.vertex_count) + 1;
    return {{{view.list, view.list + count},
             {view.owned_begin, view.owned_begin + vertices},
             {double(view.radii->search), double(view.radii->self)}},
            {view.ref_begin, view.ref_begin + vertices},
            {view.refs, view.refs + 4 * count}};
  }
};

template <class Real>
class CandidateSearchIn : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(CandidateSearchIn, Precisions);

constexpr int kRoom = 100000;

TYPED_TEST(CandidateSearchIn, FindsAndOrdersWhatTheFinderDoes) {
  for (auto& c : testing::candidate_cases<TypeParam>()) {
    SCOPED_TRACE(c.name);
    Search<TypeParam> search(c, kRoom);
    search.run(1);
    const testing::FoundCandidates found = search.found();
    EXPECT_GT(found.set.candidates.size(), 100U);
    testing::expect_same(
        found, testing::ordered(c.scene, testing::expected_candidates(c, radii_of(search.view))));
  }
}

TYPED_TEST(CandidateSearchIn, DoesNotDependOnTheOrderOfThreads) {
  for (auto& c : testing::candidate_cases<TypeParam>()) {
    SCOPED_TRACE(c.name);
    Search<TypeParam> one(c, kRoom), two(c, kRoom);
    one.run(1);
    two.run(2);
    testing::expect_same(one.found(), two.found());
  }
}

TEST(CandidateSearch, LetsAStepGoOnAndReachesAsFarAsBodiesGo) {
  for (auto& c : testing::candidate_cases<double>()) {
    SCOPED_TRACE(c.name);
    Search<double> search(c, kRoom);
    search.run(1);
    const SearchRules& rules = search.view.rules;
    const SearchRadii<double>& radii = *search.view.radii;
    EXPECT_GT(radii.search - rules.range, 1.001 * 2.0 * rules.most_move);
    if (rules.self_distance > 0.0) {
      EXPECT_GT(radii.self - rules.self_distance, 1.001 * 2.0 * rules.most_move);
    }
    double moved = 0.0;  // half of the bodies' largest
    for (const Vec3& v : c.velocity) moved = std::max(moved, norm(v) * c.options.frame_s);
    EXPECT_GE(radii.search - rules.range, std::min(rules.most_reach, rules.frames * moved));
  }
}

TEST(CandidateSearch, OfAFrameUnderWayReachesAsFarAsItHasCome) {
  testing::CandidateCase<double> c = testing::candidate_cases<double>().front();
  Search<double> search(c, kRoom);
  search.run(1);
  const double before = search.view.radii->search;
  c.x[0].x += 0.02;
  c.status.stage = StepStage::sweeps;
  search.run(1);
  EXPECT_NEAR(search.view.radii->search - before, kAsFarAgain * 4 * 0.02, 1e-6);
}

TEST(CandidateSearch, WithoutRoomReachesNowhereAndSaysHowMuchItNeeds) {
  testing::CandidateCase<double> c = testing::candidate_cases<double>().front();
  Search<double> narrow(c, 50), wide(c, kRoom);
  narrow.run(1);
  wide.run(1);
  EXPECT_EQ(narrow.view.radii->search, 0.0);
  EXPECT_EQ(*narrow.view.found_count(), *wide.view.found_count());
  EXPECT_GT(wide.view.radii->search, 0.0);
}

}  // namespace
}  // namespace angio::simulation::detail
