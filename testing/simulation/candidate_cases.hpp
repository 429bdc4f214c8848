#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "simulation/backends/host_memory.hpp"
#include "simulation/contact/make_candidate_search.hpp"
#include "simulation/step/convert.hpp"
#include "testing/simulation/folded.hpp"
#include "testing/simulation/models.hpp"

/// Searches for candidates, and what CandidateFinder's parts find in their place.
namespace angio::simulation::testing {

/// Bodies that have moved.
template <class Real>
struct CandidateCase {
  std::string name;
  SimulationOptions options;
  detail::Scene scene;
  std::vector<Vec3T<Real>> x, velocity, x_before;
  detail::StepStatus status;

  /// @param jitter  of each vertex [mm]
  /// @param moved   of each vertex in the frame before [mm]
  CandidateCase(std::string called, const SimulationModel& model, const SimulationOptions& chosen,
                double jitter, double moved)
      : name(std::move(called)), options(chosen), scene(detail::make_scene(model, options)) {
    x = detail::local<Real>(scene, scene.start);
    x_before = x;
    velocity.resize(x.size());
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (std::size_t v = 0; v < x.size(); ++v) {
      x[v] += detail::converted<Real>(jitter * Vec3{any(random), any(random), any(random)});
      velocity[v] = {Real(moved / options.frame_s * any(random)), 0, 0};
    }
  }

  [[nodiscard]] std::vector<Vec3> points() const { return detail::converted_all<double>(x); }
};

inline SimulationModel tube_in_tube() {
  StenosedTube tube;
  tube.start_radius = 0.7;
  tube.balloon_rings = 13;
  tube.balloon_around = 12;
  tube.wall_rings = 31;
  tube.wall_around = 12;
  SimulationModel model = make_model(tube);
  model.guidewire.clear();
  for (int i = 0; i < 24; ++i)
    model.guidewire.push_back({0.0, 0.0, tube.balloon_length * (i / 23.0 - 0.5)});
  return model;
}

/// A balloon in a vessel at rest and under way, one with a rod in it, one whose folds and wall meet
/// themselves, and folds alone.
template <class Real>
std::vector<CandidateCase<Real>> candidate_cases() {
  SimulationOptions plain, with_rod, with_self;
  plain.contact.self_contact = false;
  with_rod = plain;
  with_rod.guidewire.model = GuidewireModel::rod;
  with_self.contact.self_contact = true;
  std::vector<CandidateCase<Real>> cases;
  cases.emplace_back("at rest", tube_in_tube(), plain, 0.0, 0.0);
  cases.emplace_back("under way", tube_in_tube(), plain, 0.05, 0.06);
  cases.emplace_back("with a rod", tube_in_tube(), with_rod, 0.03, 0.1);
  cases.emplace_back("folds", folded_model({}), with_self, 0.002, 0.01);
  cases.emplace_back("wall and balloon with themselves", tube_in_tube(), plain, 0.02, 0.02);
  cases.back().scene.self_distance = 0.03;
  return cases;
}

/// What a search has made.
struct FoundCandidates {
  detail::CandidateSet set;
  std::vector<int> ref_begin;
  std::vector<detail::ContactRef> refs;
};

/// The candidates within the radii by another way; in no order.
template <class Real>
std::vector<detail::Candidate> expected_candidates(const CandidateCase<Real>& c,
                                                   const detail::SearchRadii<double>& radii) {
  const std::vector<Vec3> x = c.points();
  std::vector<detail::Candidate> all = detail::find_candidates(c.scene, x, radii.search);
  detail::add_rod_candidates(c.scene, x, c.options.contact.distance_mm, radii.search, all);
  if (c.scene.self_distance > 0.0) {
    detail::add_balloon_self_candidates(c.scene, x, radii.self, all);
    detail::add_wall_self_candidates(c.scene, x, radii.self, all);
  }
  return all;
}

/// Candidates in the order that a step takes them in.
inline FoundCandidates ordered(const detail::Scene& scene,
                               const std::vector<detail::Candidate>& candidates) {
  FoundCandidates out{detail::index_candidates(scene.start.size(), candidates, 0.0), {0}, {}};
  const std::vector<detail::Candidate>& list = out.set.candidates;
  std::vector<std::vector<detail::ContactRef>> refs(scene.start.size());
  for (std::size_t i = 0; i < list.size(); ++i)
    for (int corner = 0; corner < 4; ++corner)
      refs[std::size_t(list[i].vertex[corner])].push_back({int(i), corner});
  for (std::vector<detail::ContactRef>& of_vertex : refs) {
    std::stable_sort(of_vertex.begin(), of_vertex.end(), [&](const auto& a, const auto& b) {
      return list[std::size_t(a.pair)].gap < list[std::size_t(b.pair)].gap;
    });
    out.refs.insert(out.refs.end(), of_vertex.begin(), of_vertex.end());
    out.ref_begin.push_back(int(out.refs.size()));
  }
  return out;
}

/// The same candidates in the same order, each listed at its vertices in the same order.
inline void expect_same(const FoundCandidates& found, const FoundCandidates& expected) {
  EXPECT_EQ(found.set.owned_begin, expected.set.owned_begin);
  EXPECT_EQ(found.ref_begin, expected.ref_begin);
  ASSERT_EQ(found.set.candidates.size(), expected.set.candidates.size());
  const auto key = [](const detail::Candidate& c) {
    return std::tuple(c.vertex[0], c.vertex[1], c.vertex[2], c.vertex[3], c.edges, c.shaft, c.self,
                      c.radius, c.distance, c.gap);
  };
  for (std::size_t i = 0; i < found.set.candidates.size(); ++i)
    ASSERT_EQ(key(found.set.candidates[i]), key(expected.set.candidates[i])) << i;
  ASSERT_EQ(found.refs.size(), expected.refs.size());
  for (std::size_t i = 0; i < found.refs.size(); ++i)
    ASSERT_EQ(std::tuple(found.refs[i].pair, found.refs[i].corner),
              std::tuple(expected.refs[i].pair, expected.refs[i].corner))
        << i;
}

/// The same candidates, whatever their order, with the same numbers but for rounding.
inline void expect_same_pairs(std::vector<detail::Candidate> found,
                              std::vector<detail::Candidate> expected) {
  ASSERT_EQ(found.size(), expected.size());
  const auto key = [](const detail::Candidate& c) {
    return std::tuple(c.edges, c.self, c.vertex[0], c.vertex[1], c.vertex[2], c.vertex[3], c.shaft);
  };
  const auto before = [&](const auto& a, const auto& b) { return key(a) < key(b); };
  std::sort(found.begin(), found.end(), before);
  std::sort(expected.begin(), expected.end(), before);
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(key(found[i]), key(expected[i])) << i;
    EXPECT_NEAR(found[i].gap, expected[i].gap, 1e-6F) << i;
    EXPECT_NEAR(found[i].radius, expected[i].radius, 1e-6F) << i;
    EXPECT_NEAR(found[i].distance, expected[i].distance, 1e-6F) << i;
  }
}

}  // namespace angio::simulation::testing
