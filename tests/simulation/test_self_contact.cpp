#include <gtest/gtest.h>

#include <random>

#include "core/error.hpp"
#include "simulation/backends/host_memory.hpp"
#include "simulation/contact/candidate_set.hpp"
#include "simulation/contact/candidates.hpp"
#include "simulation/run/measure.hpp"
#include "simulation/step/make_views.hpp"
#include "simulation/step/program.hpp"
#include "simulation/step/team.hpp"
#include "testing/simulation/folded.hpp"
#include "testing/simulation/models.hpp"

namespace angio::simulation::detail {
namespace {

SimulationOptions with_self_contact() {
  SimulationOptions options;
  options.contact.self_contact = true;
  options.backend = Backend::cpu;
  return options;
}

// A step's view with the candidates of one surface, found at the start positions.
struct Folds {
  static constexpr double kReach = 0.12;

  SimulationModel model;
  Scene scene;
  HostMemory memory;
  StepView<double> view;
  StepStatus status;
  CpuTeam::Shared shared;
  CpuTeam team{0, 1, shared};

  /// @param self_distance  0: that of the scene
  explicit Folds(const SimulationModel& balloon, double self_distance = 0.0)
      : model(balloon), scene(make_scene(model, with_self_contact())) {
    if (self_distance > 0.0) scene.self_distance = self_distance;
    view = make_view<double>(scene, with_self_contact(), memory);
    renew();
    std::fill_n(view.contact.near.max_move, scene.vertex_count(), 0.01);
    measure_areas(team, view);
  }

  /// Finds the candidates where the vertices are now.
  void renew() {
    const std::vector<Vec3> x = positions();
    std::vector<Candidate> found;
    add_balloon_self_candidates(scene, x, kReach, found);
    add_wall_self_candidates(scene, x, kReach, found);
    const CandidateSet set = index_candidates(x.size(), found, kReach);
    view.contact.near.listed_begin = memory.allocate<int>(x.size());
    view.contact.candidates = {int(set.candidates.size()),
                               memory.store(set.candidates),
                               memory.store(set.owned_begin),
                               view.contact.near.listed_begin,
                               nullptr,
                               memory.store(x),
                               memory.store(std::vector<SearchRadii<double>>{{1.0, kReach}})};
    view.contact.near.pairs = memory.allocate<NearPair<double>>(found.size());
    view.contact.near.refs = memory.allocate<ContactRef>(4 * found.size());
    view.contact.near.bounds = memory.allocate<MotionBound<double>>(4 * found.size());
  }

  [[nodiscard]] std::vector<Vec3> positions() const {
    return {view.motion.x, view.motion.x + scene.vertex_count()};
  }
  bool search() {
    const bool done = search_pairs(team, view, status);
    if (done) refresh(team, view);
    return done;
  }
  /// Of all vertices, and what each side of each pair gives [uN].
  [[nodiscard]] VertexForces<double> forces() const {
    VertexForces<double> sum;
    for (int v = 0; v < scene.vertex_count(); ++v) add_contact(view, v, OneLane{}, sum);
    return sum;
  }
};

TEST(SelfContact, HasAllCandidatesThatShareNoVertex) {
  const Folds folds(testing::folded_model({}));
  const Scene& scene = folds.scene;
  const auto& x = scene.start;
  const auto at = [&](int v) { return x[std::size_t(v)]; };
  const auto near = [&](const GapWeights<double>& g, int a, int b, int c, int d) {
    return norm(g.w[0] * at(a) + g.w[1] * at(b) + g.w[2] * at(c) + g.w[3] * at(d)) < 0.06;
  };
  int faces = 0, edges = 0;
  for (int v = 0; v < scene.bodies.balloon().count; ++v)
    for (const Triangle& t : scene.balloon.triangles)
      if (std::find(t.begin(), t.end(), v) == t.end())
        faces += near(point_triangle_gap(at(v), at(t[0]), at(t[1]), at(t[2])), v, t[0], t[1], t[2]);
  for (std::size_t i = 0; i < scene.balloon.edges.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Edge &a = scene.balloon.edges[i], &b = scene.balloon.edges[k];
      if (std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) == a.end())
        edges += near(segment_segment_gap(at(a[0]), at(a[1]), at(b[0]), at(b[1])), a[0], a[1], b[0],
                      b[1]);
    }
  std::vector<Candidate> found;
  add_balloon_self_candidates(scene, x, 0.06, found);
  const auto found_edges =
      std::count_if(found.begin(), found.end(), [](const Candidate& c) { return c.edges; });
  EXPECT_GT(faces, 100);
  EXPECT_EQ(found_edges, edges);
  EXPECT_EQ(std::ptrdiff_t(found.size()) - found_edges, faces);
}

TEST(SelfContact, PushesNothingInTheStartShape) {
  Folds folds(testing::folded_model({}));
  ASSERT_TRUE(folds.search());
  EXPECT_GT(folds.status.report.pair_count, 100);
  EXPECT_FALSE(folds.forces().touching);
}

TEST(SelfContact, IsNotLookedForWhereNoLayersLieOnEachOther) {
  testing::StenosedTube p;
  p.wall_rings = 3;
  for (const int around : {12, 96}) {
    p.balloon_around = around;
    SimulationModel model = testing::make_model(p);
    model.wall = {};
    model.wall_fixed.clear();
    model.wall_abscissa.clear();
    model.wall_group.clear();
    EXPECT_EQ(make_scene(model, with_self_contact()).self_distance, 0.0) << around;
  }
}

TEST(SelfContact, NeighboursOnASmoothBalloonDoNotMeet) {
  testing::StenosedTube p;
  p.balloon_around = 64;  // edges of 0.04 mm: nearer than contact acts elsewhere
  p.balloon_length = 1.0;
  p.balloon_rings = 20;
  SimulationModel model = testing::make_model(p);
  model.wall = {};
  model.wall_fixed.clear();
  model.wall_abscissa.clear();
  model.wall_group.clear();
  Folds folds(model, 0.05);
  for (const double grown : {1.0, 1.03, 0.97}) {
    for (int v = 0; v < folds.scene.bodies.balloon().count; ++v)
      folds.view.motion.x[v] = grown * (folds.scene.start[std::size_t(v)] - folds.scene.origin);
    ASSERT_TRUE(folds.search());
    EXPECT_GT(folds.status.report.pair_count, 1000);
    EXPECT_FALSE(folds.forces().touching) << grown;
  }
}

TEST(SelfContact, KeepsMomentum) {
  Folds folds(testing::folded_model({}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  ASSERT_TRUE(folds.search());
  for (int v = 0; v < folds.scene.bodies.balloon().count; ++v) {
    const Vec3 x = folds.view.motion.x[v];  // layers pressed on each other
    const Vec3 move =
        -0.04 * normalized(Vec3{x.x, x.y, 0.0}) + 0.02 * Vec3{u(random), u(random), u(random)};
    folds.view.motion.x[v] +=
        allowed_share(folds.view, v, move, folds.view.contact.near.max_move[0]) * move;
  }
  ASSERT_TRUE(folds.search());
  const VertexForces<double> sum = folds.forces();
  EXPECT_GT(sum.magnitude, 1.0);
  EXPECT_LT(norm(sum.force), 1e-12 * sum.magnitude);
}

TEST(Contact, PressesWithoutLimitBeforeTheGapThatMotionsLeave) {
  Folds folds(testing::folded_model({}));
  NearPair<double> pair;
  pair.vertex[0] = 0;
  for (int i = 1; i < 4; ++i) pair.vertex[i] = 1;
  pair.weights.w[0] = 1.0;
  pair.weights.w[1] = -1.0;
  pair.direction = {0.0, 0.0, 1.0};
  pair.weight = 1.0;
  const auto force_at = [&](double gap) {
    folds.view.motion.x[1] = folds.view.motion.x[0] - Vec3{0.0, 0.0, gap};
    return pair_forces(folds.view, pair).normal;
  };
  for (const bool self : {true, false}) {
    pair.self = self;
    pair.distance = self ? folds.scene.self_distance : folds.view.contact.law.distance;
    const double least = (self ? kSelfLeastGap : kLeastGap) * pair.distance;
    EXPECT_EQ(force_at(pair.distance), 0.0);
    EXPECT_GT(force_at(0.99 * pair.distance), 0.0);
    for (double over = 0.01 * pair.distance; over > 2e-4 * pair.distance; over *= 0.5)
      EXPECT_NEAR(force_at(least + 0.5 * over) / force_at(least + over), 2.0, 0.2)
          << self << " " << over;
  }
}

TEST(SelfContact, NoMotionWithinItsBoundsTakesTheSkinThroughItself) {
  Folds folds(testing::folded_model({}));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const double room =
      Folds::kReach - folds.scene.self_distance - 2.0 * folds.view.contact.near.max_move[0];
  const auto is_spent = [&] {
    double gone = 0.0;
    for (int v = 0; v < folds.scene.bodies.balloon().count; ++v)
      gone = std::max(gone, distance(folds.view.motion.x[v], folds.view.contact.candidates.x[v]));
    return 2.0 * gone > 0.99 * room;
  };
  int rounds = 0;
  while (folds.search()) {
    ASSERT_LT(++rounds, 200);
    for (int v = 0; v < folds.scene.bodies.balloon().count; ++v) {
      const Vec3 move = 0.02 * Vec3{u(random), u(random), u(random)};
      folds.view.motion.x[v] +=
          allowed_share(folds.view, v, move, folds.view.contact.near.max_move[0]) * move;
    }
    ASSERT_EQ(self_crossing_count(folds.scene.balloon.triangles, folds.positions()), 0) << rounds;
  }
  EXPECT_TRUE(is_spent());  // both sides are of the balloon: twice its motion counts
}

// A narrow lumen around a slender balloon.
SimulationModel narrow_lumen(int around = 12) {
  testing::StenosedTube p;
  p.radius = 0.3;
  p.length = 3.0;
  p.lesion_length = 1.5;
  p.stenosis = 0.6;
  p.start_radius = 0.06;
  p.nominal_radius = 0.3;
  p.balloon_length = 2.0;
  p.balloon_rings = 9;
  p.balloon_around = 8;
  p.wall_rings = 31;
  p.wall_around = around;
  return testing::make_model(p);
}

TEST(SelfContact, NoMotionWithinItsBoundsTakesAWallThroughItself) {
  Folds lumen(narrow_lumen());
  ASSERT_GT(lumen.scene.self_distance, 0.0);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<Vec3> free = lumen.positions();
  const int first = lumen.scene.bodies.wall().first;
  for (int round = 0; round < 12; ++round) {
    ASSERT_TRUE(lumen.search());
    for (int v = first; v < lumen.scene.vertex_count(); ++v) {
      const Vec3 move = 0.02 * Vec3{u(random), u(random), u(random)};
      free[std::size_t(v)] += move;
      lumen.view.motion.x[v] +=
          allowed_share(lumen.view, v, move, lumen.view.contact.near.max_move[0]) * move;
    }
    ASSERT_EQ(self_crossing_count(lumen.scene.wall.triangles, lumen.positions()), 0) << round;
    lumen.renew();
  }
  EXPECT_GT(self_crossing_count(lumen.scene.wall.triangles, free), 0);
}

TEST(SelfContact, ASmoothWallDoesNotMeetItself) {
  Folds lumen(narrow_lumen(40));  // edges of 0.02 mm in the throat: contact would act below that
  for (const double grown : {1.0, 1.05, 0.97}) {
    for (int v = lumen.scene.bodies.wall().first; v < lumen.scene.vertex_count(); ++v)
      lumen.view.motion.x[v] = grown * (lumen.scene.start[std::size_t(v)] - lumen.scene.origin);
    lumen.renew();
    ASSERT_TRUE(lumen.search());
    EXPECT_GT(lumen.status.report.pair_count, 1000);
    EXPECT_FALSE(lumen.forces().touching) << grown;
  }
}

TEST(SelfContact, IsLookedForAroundASlackBalloonOnly) {
  SimulationOptions options = with_self_contact();
  options.membrane = MembraneModel::plain;
  EXPECT_EQ(make_scene(narrow_lumen(), options).self_distance, 0.0);
  options.membrane = MembraneModel::relaxed;
  EXPECT_GT(make_scene(narrow_lumen(), options).self_distance, 0.0);
  EXPECT_FALSE(make_scene(narrow_lumen(), options).balloon.has_folds);
}

struct Unfolding {
  int crossings = 0;                             ///< of triangles with each other, in all frames
  double diameter_mm = 0.0, pressure_atm = 0.0;  ///< at the peak
};

SimulationModel small_folded_model() {
  testing::FoldedBalloon balloon;
  balloon.outer_edges = 8;
  balloon.inner_edges = 4;
  balloon.rings = 9;
  balloon.length = 2.6;
  return testing::folded_model(balloon);
}

Unfolding unfold(const SimulationModel& model, bool self_contact) {
  SimulationOptions options = with_self_contact();
  options.contact.self_contact = self_contact;
  options.inflation.inflate_s = 0.3;
  options.inflation.hold_s = 0.05;
  options.inflation.deflate_s = options.frame_s;
  options.inflation.rest_s = 0.0;
  Unfolding result;
  const SimulationSummary summary = simulate(model, options, [&](const SimulationFrame& frame) {
    result.crossings += self_crossing_count(model.balloon.triangles, frame.balloon);
  });
  result.diameter_mm = summary.peak_diameter_mm;
  result.pressure_atm = summary.peak_pressure_atm;
  return result;
}

TEST(SelfContact, LetsABalloonUnfoldWithoutACrossing) {
  const SimulationModel folded = small_folded_model();
  SimulationModel never_folded = folded;
  never_folded.balloon.vertices = never_folded.balloon_rest;
  const Unfolding with = unfold(folded, true), free = unfold(never_folded, false);
  EXPECT_GT(unfold(folded, false).crossings, 100);
  EXPECT_EQ(with.crossings, 0);
  EXPECT_NEAR(with.pressure_atm, free.pressure_atm, 0.01 * free.pressure_atm);
  EXPECT_NEAR(with.diameter_mm, free.diameter_mm, 0.005 * free.diameter_mm);
}

TEST(SelfContact, IsNotLookedForBesideThePapersProjections) {
  SimulationOptions contact = with_self_contact(), gas = with_self_contact();
  contact.contact.model = ContactModel::paper;
  gas.gas_model = GasModel::per_tet;
  gas.inflation.control = InflationControl::volume;
  const SimulationModel model = testing::folded_model({});
  EXPECT_GT(make_scene(model, with_self_contact()).self_distance, 0.0);
  for (const SimulationOptions& options : {contact, gas}) {
    EXPECT_NO_THROW(options.validate());
    EXPECT_EQ(make_scene(model, options).self_distance, 0.0);
  }
}

TEST(SelfContact, RefusesAStartShapeThatCrossesOrTouchesItself) {
  SimulationModel model = testing::folded_model({});
  const std::vector<Vec3> start = model.balloon.vertices;
  // A vertex of an outer layer goes through the inner layer outside of it, or onto it.
  const Scene scene = make_scene(model, with_self_contact());
  std::vector<Candidate> near;
  add_balloon_self_candidates(scene, scene.start, 0.07, near);
  const auto face = std::find_if(near.begin(), near.end(), [&](const Candidate& c) {
    return !c.edges && std::abs(scene.start[std::size_t(c.vertex[0])].z) < 0.5 &&
           gap_of(scene.start, c) > 0.04;
  });
  ASSERT_NE(face, near.end());
  Vec3 middle;
  for (int i = 1; i < 4; ++i) middle += scene.start[std::size_t(face->vertex[i])] / 3.0;
  const auto v = std::size_t(scene.caller_vertex[std::size_t(face->vertex[0])]);
  for (const double way : {1.0, 1.2}) {
    model.balloon.vertices[v] = start[v] + way * (middle - start[v]);
    EXPECT_THROW(make_scene(model, with_self_contact()), InputError) << way;
    SimulationOptions without = with_self_contact();
    without.contact.self_contact = false;
    EXPECT_NO_THROW(make_scene(model, without));
  }
}

}  // namespace
}  // namespace angio::simulation::detail
