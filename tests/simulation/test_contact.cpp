#include <gtest/gtest.h>

#include <random>

#include "simulation/backends/host_memory.hpp"
#include "simulation/contact/candidate_set.hpp"
#include "simulation/contact/candidates.hpp"
#include "simulation/contact/contact_force.hpp"
#include "simulation/contact/distance.hpp"
#include "simulation/step/bounded_motion.hpp"
#include "simulation/step/make_views.hpp"
#include "simulation/step/program.hpp"
#include "simulation/step/team.hpp"
#include "testing/simulation/models.hpp"
#include "tests/simulation/candidate_order.hpp"

namespace angio::simulation::detail {
namespace {

TEST(Barrier, SlopeAndCurvatureAreThoseOfTheValue) {
  const double r = 0.03, h = 1e-7;
  for (const double d : {0.001, 0.01, 0.02, 0.029}) {
    const auto at = barrier(d, r), up = barrier(d + h, r), down = barrier(d - h, r);
    EXPECT_NEAR(at.slope, (up.value - down.value) / (2 * h), 1e-6 * std::abs(at.slope) + 1e-9);
    EXPECT_NEAR(at.curvature, (up.slope - down.slope) / (2 * h), 1e-5 * at.curvature);
    EXPECT_LT(at.slope, 0.0);
    EXPECT_GT(at.curvature, 0.0);
  }
  EXPECT_EQ(barrier(0.03, r).value, 0.0);
  EXPECT_NEAR(barrier(0.03 - 1e-9, r).slope, 0.0, 1e-7);
}

TEST(Barrier, CarriesThePressureAtHalfTheDistance) {
  const double pressure = 8e5, r = 0.03;
  EXPECT_NEAR(-barrier_stiffness(pressure, r) * barrier(0.5 * r, r).slope, pressure,
              1e-6 * pressure);
}

TEST(Friction, NeverExceedsTheLimitAndFallsToTheKineticOne) {
  const Friction<double> f{0.3, 0.1, 1e-3};
  double before = 0.0;
  for (double y = 1e-6; y < 1e-2; y += 1e-6) {
    const double mu = y * friction_per_slip(f, y);
    EXPECT_LE(mu, 0.3 * (1 + 1e-12));
    EXPECT_LT(std::abs(mu - before), 0.3 * 3e-3);  // no step
    before = mu;
  }
  EXPECT_NEAR(f.stick_slip * friction_per_slip(f, f.stick_slip), 0.3, 1e-12);
  EXPECT_NEAR(before, 0.1, 1e-12);
}

Vec3 random_point(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  return {u(random), u(random), u(random)};
}

double gap_of(const GapWeights<double>& g, const Vec3 (&p)[4]) {
  Vec3 gap;
  for (int i = 0; i < 4; ++i) gap += g.w[i] * p[i];
  return norm(gap);
}

// Long edges that nearly lie along each other, and triangles, a tiny gap apart, as positions in
// single precision are.
TEST(PartingPlane, ProvesNearlyTheWholeGapInSinglePrecision) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (int round = 0; round < 4000; ++round) {
    const bool edges = round % 2 == 0;
    const double size = std::pow(10.0, -1.0 + 2.0 * u(random)),
                 gap = size * std::pow(10.0, -4.0 * u(random) - 0.5), skew = u(random) * u(random);
    const Candidate pair{{0, 1, 2, 3}, edges};
    // Side b in the plane z = 0, side a above it.
    const auto flat = [&](double z) {
      return size * Vec3{2.0 * u(random) - 1.0, skew * (2.0 * u(random) - 1.0), z};
    };
    Vec3 p[4] = {flat(gap / size), flat(edges ? gap / size : 0.0), flat(0.0), flat(0.0)};
    const Vec3 n = normalized(random_point(random)), e = any_perpendicular(n), f = cross(n, e);
    Vec3T<float> q[4];
    Vec3 exact[4];
    for (int i = 1; i < 4; ++i) {
      const Vec3 from = p[i] - p[0], d = from.x * e + from.y * f + from.z * n;
      q[i] = {float(d.x), float(d.y), float(d.z)};
      exact[i] = in_double(q[i]);
    }
    const double distance = norm(gap_between(pair, exact));
    const auto plane = parting_plane(pair, q);
    EXPECT_LE(double(plane.gap), distance) << round;
    EXPECT_GT(double(plane.gap), 0.9 * distance - 4e-6 * size) << round;
  }
}

TEST(Distance, IsTheLeastOverSampledPoints) {
  std::mt19937 random(3);
  const int n = 60;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 p[4] = {random_point(random), random_point(random), random_point(random),
                       random_point(random)};
    const GapWeights<double> face = point_triangle_gap(p[0], p[1], p[2], p[3]);
    const GapWeights<double> edge = segment_segment_gap(p[0], p[1], p[2], p[3]);
    double least_face = 1e9, least_edge = 1e9;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const double s = double(i) / n, t = double(j) / n;
        if (i + j <= n)
          least_face =
              std::min(least_face, distance(p[0], (1 - s - t) * p[1] + s * p[2] + t * p[3]));
        least_edge =
            std::min(least_edge, distance((1 - s) * p[0] + s * p[1], (1 - t) * p[2] + t * p[3]));
      }
    EXPECT_LE(gap_of(face, p), least_face + 1e-12);
    EXPECT_LE(gap_of(edge, p), least_edge + 1e-12);
    EXPECT_GT(gap_of(face, p), least_face - 0.06);
    EXPECT_GT(gap_of(edge, p), least_edge - 0.06);
    EXPECT_NEAR(face.w[0] + face.w[1] + face.w[2] + face.w[3], 0.0, 1e-12);
    EXPECT_NEAR(edge.w[0] + edge.w[1] + edge.w[2] + edge.w[3], 0.0, 1e-12);
  }
}

struct TubeInTube {
  SimulationModel model;
  Scene scene;

  TubeInTube() {
    testing::StenosedTube p;
    p.start_radius = 0.7;
    p.balloon_rings = 13;
    p.balloon_around = 12;
    p.wall_rings = 31;
    p.wall_around = 12;
    model = testing::make_model(p);
    SimulationOptions options;
    options.contact.self_contact = false;  // candidates here are those of balloon and wall
    scene = make_scene(model, options);
  }
};

TEST(Candidates, AreAllThatBruteForceFinds) {
  const TubeInTube t;
  const double reach = 0.3;
  const std::vector<Candidate> found = find_candidates(t.scene, t.scene.start, reach);
  int faces = 0, edges = 0;
  const auto& x = t.scene.start;
  const auto at = [&](int v) { return x[std::size_t(v)]; };
  const auto near = [&](const GapWeights<double>& g, int a, int b, int c, int d) {
    const Vec3 p[4] = {at(a), at(b), at(c), at(d)};
    return gap_of(g, p) < reach;
  };
  const auto count_faces = [&](int v, const Triangle& f) {
    faces += near(point_triangle_gap(at(v), at(f[0]), at(f[1]), at(f[2])), v, f[0], f[1], f[2]);
  };
  for (int v = 0; v < t.scene.bodies.balloon().count; ++v)
    for (const Triangle& f : t.scene.wall.triangles) count_faces(v, f);
  for (int v = t.scene.bodies.wall().first; v < t.scene.vertex_count(); ++v)
    for (const Triangle& f : t.scene.balloon.triangles) count_faces(v, f);
  for (const Edge& a : t.scene.balloon.edges)
    for (const Edge& b : t.scene.wall.edges)
      edges +=
          near(segment_segment_gap(at(a[0]), at(a[1]), at(b[0]), at(b[1])), a[0], a[1], b[0], b[1]);
  int found_faces = 0, found_edges = 0;
  for (const Candidate& pair : found) (pair.edges ? found_edges : found_faces) += 1;
  EXPECT_GT(faces, 100);
  EXPECT_EQ(found_faces, faces);
  EXPECT_EQ(found_edges, edges);
}

// A step's view of the tubes, with candidates found at the start positions.
struct PairSearch {
  TubeInTube t;
  HostMemory memory;
  StepView<double> view = make_view<double>(t.scene, {}, memory);
  StepStatus status;

  explicit PairSearch(double reach, double travel) {
    const CandidateSet set =
        index_candidates(start().size(), find_candidates(t.scene, start(), reach), reach);
    const std::size_t count = set.candidates.size();
    view.contact.near.listed_begin = memory.allocate<int>(t.scene.start.size());
    view.contact.candidates = {int(count),
                               memory.store(set.candidates),
                               memory.store(set.owned_begin),
                               view.contact.near.listed_begin,
                               nullptr,
                               memory.store(start()),
                               memory.store(std::vector<SearchRadii<double>>{{reach, 0.0}})};
    view.contact.near.pairs = memory.allocate<NearPair<double>>(count);
    view.contact.near.refs = memory.allocate<ContactRef>(4 * count);
    view.contact.near.bounds = memory.allocate<MotionBound<double>>(4 * count);
    std::fill_n(view.contact.near.max_move, t.scene.vertex_count(), travel);
  }

  std::vector<Vec3> start() const { return local<double>(t.scene, t.scene.start); }

  bool run() {
    CpuTeam::Shared shared;
    CpuTeam team(0, 1, shared);
    return search_pairs(team, view, status);
  }

  std::vector<NearPair<double>> pairs() const {
    std::vector<NearPair<double>> result;
    for (int v = 0; v < t.scene.vertex_count(); ++v)
      result.insert(result.end(), view.contact.near.pairs + view.contact.candidates.owned_begin[v],
                    view.contact.near.pairs + view.contact.near.owned_end[v]);
    return result;
  }
};

TEST(SearchPairs, NamesTheCandidatesThatAreNearAfterAMotion) {
  PairSearch search(0.9, 0.1);
  std::mt19937 random(7);
  for (int v = 0; v < search.t.scene.vertex_count(); ++v)
    search.view.motion.x[v] += 0.07 * random_point(random);
  ASSERT_TRUE(search.run());
  const std::vector<Vec3> x(search.view.motion.x,
                            search.view.motion.x + search.t.scene.vertex_count());
  const double reach = search.view.contact.law.distance + 2.0 * 0.1;  // all is dry
  const auto expected = testing::by_vertices(find_candidates(search.t.scene, x, reach));
  std::vector<Candidate> found;
  for (const NearPair<double>& pair : search.pairs()) {
    found.push_back({{}, pair.edges});
    std::copy(pair.vertex, pair.vertex + 4, found.back().vertex);
  }
  found = testing::by_vertices(found);
  ASSERT_GT(expected.size(), 20U);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_TRUE(std::equal(found[i].vertex, found[i].vertex + 4, expected[i].vertex)) << i;
}

TEST(SearchPairs, AsksForNewCandidatesWhenBalloonAndWallHaveGoneTooFarTogether) {
  const double reach = 0.9, travel = 0.1;
  PairSearch search(reach, travel);
  const double room = reach - search.view.contact.law.range - 2.0 * travel;
  search.view.motion.x[3].z += 0.3 * room;
  search.view.motion.x[search.t.scene.bodies.wall().first].z += 0.69 * room;
  EXPECT_TRUE(search.run());
  search.view.motion.x[3].z += 0.02 * room;
  EXPECT_FALSE(search.run());
}

// Presses balloon and wall together as far as they let themselves be.
void press_together(PairSearch& search) {
  Vec3* x = search.view.motion.x;
  for (int round = 0; round < 200; ++round) {
    ASSERT_TRUE(search.run());
    for (int v = 0; v < search.t.scene.vertex_count(); ++v) {
      if (search.view.contact.near.ref_end[v] == search.view.contact.candidates.ref_begin[v])
        continue;  // nothing stops it
      const Vec3 radial = normalized(Vec3{x[v].x, x[v].y, 0.0});
      const Vec3 move = (search.t.scene.bodies.of(v) == Body::balloon ? 0.01 : -0.01) * radial;
      x[v] += allowed_share(search.view, v, move, search.view.contact.near.max_move[v]) * move;
    }
  }
  ASSERT_TRUE(search.run());
}

TEST(SearchPairs, NoNumberOfMotionsUsesUpAGap) {
  PairSearch search(0.9, 0.05);
  press_together(search);
  double least = 1e9;
  for (const NearPair<double>& pair : search.pairs()) least = std::min(least, pair.gap_searched);
  const double floor = kLeastGap * search.view.contact.law.distance;
  EXPECT_GT(least, 0.999 * floor);
  EXPECT_LT(least, 2.0 * floor);  // the motions went as far as they may
}

TEST(SearchPairs, NoMotionWithinItsBoundsMakesAPairCross) {
  const double travel = 0.2;
  PairSearch search(0.9, travel);
  ASSERT_TRUE(search.run());
  const std::vector<Vec3> start = search.start();
  Vec3* x = search.view.motion.x;
  std::mt19937 random(5);
  for (int round = 0; round < 4; ++round)  // several moves between two searches
    for (int v = 0; v < search.t.scene.vertex_count(); ++v) {
      const Vec3 radial = normalized(Vec3{x[v].x, x[v].y, 0.0});
      const Vec3 towards = search.t.scene.bodies.of(v) == Body::balloon ? radial : -radial;
      const Vec3 move = 0.5 * towards + 0.2 * random_point(random);
      const double share = allowed_share(search.view, v, move, travel);
      EXPECT_GE(share, 0.0);
      EXPECT_LE(share, 1.0);
      x[v] += share * move;
      EXPECT_LE(distance(x[v], start[std::size_t(v)]), travel * (1 + 1e-9));
    }
  for (const NearPair<double>& pair : search.pairs()) {
    const int side_a = pair.edges ? 2 : 1;
    double least_a = 1e9, most_b = -1e9;
    for (int i = 0; i < 4; ++i) {
      const double height = dot(pair.normal, x[pair.vertex[i]]);
      if (i < side_a)
        least_a = std::min(least_a, height);
      else
        most_b = std::max(most_b, height);
    }
    EXPECT_GT(least_a, most_b);  // a plane lies between the two
  }
}

// Where a gap is a thousandth of the edges, corners that slide by as much part by their old
// weights, while the surfaces do not.
TEST(PairForces, OfADeepPairAreThoseOfItsDistanceNow) {
  PairSearch search(0.9, 0.05);
  press_together(search);
  CpuTeam::Shared shared;
  CpuTeam team(0, 1, shared);
  const StepView<double>& view = search.view;
  refresh(team, view);
  Vec3* x = view.motion.x;
  std::mt19937 random(13);
  const double floor = kLeastGap * view.contact.law.distance;
  for (int v = 0; v < search.t.scene.vertex_count(); ++v) {
    const Vec3 radial = normalized(Vec3{x[v].x, x[v].y, 0.0}), along = random_point(random);
    x[v] += 2.0 * floor * (along - dot(along, radial) * radial);
  }
  int deep = 0;
  for (const NearPair<double>& pair : search.pairs()) {
    const PairForces<double> forces = pair_forces(view, pair);
    if (!forces.touching) continue;
    Vec3 p[4];
    for (int i = 0; i < 4; ++i) p[i] = x[pair.vertex[i]] - x[pair.vertex[0]];
    const double range = pair.distance - floor, distance = norm(gap_between(pair, p)) - floor;
    if (distance > 0.5 * kDeepShare * range || distance < kLeastDepth * kDeepShare * range)
      continue;
    ++deep;
    const double force = -view.contact.law.stiffness * pair.weight * barrier(distance, range).slope;
    EXPECT_NEAR(forces.normal, force, 1e-9 * force);
  }
  EXPECT_GT(deep, 20);
}

// Takes down what the balloon's vertices carry, as a sweep does. @return root of the sum of squares
double take_down_contact(const StepView<double>& view, CpuTeam& team) {
  refresh(team, view);
  double sum = 0.0;
  for (int v = 0; v < last_of_balloon(view); ++v) {
    VertexForces<double> forces;
    add_contact(view, v, OneLane{}, forces);
    view.balloon.moves[v].contact = forces.contact;
    sum += forces.contact * forces.contact;
  }
  return std::sqrt(sum);
}

TEST(ContactJump, IsAllThatWasCarriedWhereSurfacesPart) {
  PairSearch search(0.9, 0.05);
  press_together(search);
  CpuTeam::Shared shared;
  CpuTeam team(0, 1, shared);
  const double carried = take_down_contact(search.view, team);
  EXPECT_GT(carried, 0.0);
  EXPECT_EQ(contact_jump(team, search.view), 0.0);
  Vec3* x = search.view.motion.x;
  for (int v = 0; v < search.t.scene.bodies.balloon().count; ++v)
    x[v] -= 0.05 * normalized(Vec3{x[v].x, x[v].y, 0.0});
  EXPECT_NEAR(contact_jump(team, search.view), carried, 1e-12 * carried);
  EXPECT_EQ(take_down_contact(search.view, team), 0.0);
}

TEST(RunSweeps, DoNotEndWhereContactIsNotWhatTheyHaveSeen) {
  PairSearch search(0.9, 0.05);
  press_together(search);
  CpuTeam::Shared shared;
  CpuTeam team(0, 1, shared);
  StepRules rules;
  rules.tolerance = rules.residual = 1e9;  // any state will do
  rules.most_sweeps = 400;
  StepStatus& status = search.status;
  status.law.lower = status.law.limit = 5e5 * enclosed_volume(team, search.view);
  status.law.top = 5e5;
  begin_step(team, search.view, rules, status);
  measure_gas(team, search.view, status);
  status.stage = StepStage::sweeps;
  ASSERT_TRUE(run_sweeps(team, search.view, rules, status));
  EXPECT_LT(status.report.sweeps, rules.most_sweeps);
  double load = 0.0;  // of the gas alone
  for (int v = 0; v < last_of_balloon(search.view); ++v)
    load += norm_squared((status.pressure - search.view.balloon.outside_pressure) *
                         search.view.balloon.moves[v].by_volume);
  EXPECT_LT(contact_jump(team, search.view), 0.1 * std::sqrt(load));
}

}  // namespace
}  // namespace angio::simulation::detail
