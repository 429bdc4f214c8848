#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "air_mesh/adaptive_air.hpp"
#include "air_mesh/air_points.hpp"
#include "tests/air_mesh/gap_measures.hpp"

namespace angio::air_mesh {
namespace {
using namespace simulation;  // the last of these run a whole model

using simulation::testing::Gap;
using simulation::testing::make_gap;
using test::kDegree;
using test::outer_faces;
using test::quality_of;
using test::straight_gap;
using test::turned;
using test::volume_of;

// The gap is covered once by right-handed tets, and its outside is what it was.
void expect_whole(const AdaptiveAir& air, const Gap& gap, const std::vector<Vec3>& x) {
  EXPECT_TRUE(air.is_whole());
  const std::vector<Tet> tets = air.topology().tets();
  for (const Tet& t : tets) EXPECT_GT(quality_of(t, air.positions()), 0.0);
  EXPECT_NEAR(volume_of(tets, air.positions()) / gap.volume(x), 1.0, 1e-9);
  EXPECT_EQ(outer_faces(air.topology()), outer_faces(TetTopology(gap.tets)));
}

// What a frame of a motion does to the mesh, summed up.
struct Course {
  int flips = 0, inverted_frames = 0, rebuilds = 0;
};
template <class Motion>
Course run(AdaptiveAir& air, const Gap& gap, int frames, const Motion& motion) {
  Course course;
  for (int f = 1; f <= frames; ++f) {
    std::vector<Vec3> x = gap.x;
    for (std::size_t v = 0; v < x.size(); ++v)
      x[v] = motion(gap.x[v], int(v) < gap.inner_count(), f);
    air.follow(x);
    const AirReport report = air.take_report();
    course.flips += report.flip_count;
    course.rebuilds += report.rebuild_count;
    course.inverted_frames += report.inverted_count > 0 ? 1 : 0;
    EXPECT_NEAR(volume_of(air.topology().tets(), air.positions()) / gap.volume(x), 1.0, 1e-9);
  }
  return course;
}

TEST(AdaptiveAir, StaysWholeWhileTheBalloonTurnsTwoDegreesAFrame) {
  const Gap gap = straight_gap();
  AdaptiveAir air(gap.tets, gap.x, gap.surfaces);
  const Course course = run(air, gap, 90, [](const Vec3& p, bool inner, int f) {
    return inner ? turned(p, 2.0 * kDegree * f) : p;
  });
  EXPECT_EQ(course.inverted_frames, 0);
  EXPECT_GT(course.flips, 1000);
  std::vector<Vec3> end = gap.x;
  for (int v = 0; v < gap.inner_count(); ++v)
    end[std::size_t(v)] = turned(end[std::size_t(v)], 180.0 * kDegree);
  expect_whole(air, gap, end);
}

TEST(AdaptiveAir, StaysWholeWhileTheBalloonIsPulledAlong) {
  const Gap gap = make_gap(
      6.0, 0.5, [](double z) { return 1.2 - 0.5 * std::exp(-z * z); }, 2.5, 15, 12);
  AdaptiveAir air(gap.tets, gap.x, gap.surfaces);
  const Course course = run(air, gap, 60, [](const Vec3& p, bool inner, int f) {
    return inner ? p + Vec3{0.0, 0.0, 0.025 * f} : p;
  });
  EXPECT_EQ(course.inverted_frames, 0);
}

TEST(AdaptiveAir, StaysWholeWhileTheBalloonGrowsToFiveTimesItsVolume) {
  const Gap gap = straight_gap();
  AdaptiveAir air(gap.tets, gap.x, gap.surfaces);
  const Course course = run(air, gap, 100, [](const Vec3& p, bool inner, int f) {
    const double growth = std::sqrt(1.0 + 0.04 * f);
    return inner ? turned({growth * p.x, growth * p.y, p.z}, 0.5 * kDegree * f) : p;
  });
  EXPECT_EQ(course.inverted_frames, 0);
  EXPECT_TRUE(air.is_whole());
}

TEST(AdaptiveAir, StaysWholeInAGapOfAHundredthOfAMillimetre) {
  const Gap gap = straight_gap();
  AdaptiveAir air(gap.tets, gap.x, gap.surfaces);
  // Both sides have flat facets: turned against each other, corners face facets.
  const Course course = run(air, gap, 160, [](const Vec3& p, bool inner, int f) {
    if (!inner) return p;
    const double widest = 1.3 * std::cos(15.0 * kDegree) - 0.01;
    const double growth = 1.0 + (widest / 0.5 / 1.0235 - 1.0) * std::min(1.0, f / 100.0);
    return turned({growth * p.x, growth * p.y, p.z}, 0.25 * kDegree * std::max(0, f - 100));
  });
  EXPECT_EQ(course.inverted_frames, 0);
}

TEST(AdaptiveAir, MakesTheSameFlipsTwice) {
  const Gap gap = straight_gap();
  std::vector<Tet> first;
  for (int round = 0; round < 2; ++round) {
    AdaptiveAir air(gap.tets, gap.x, gap.surfaces);
    run(air, gap, 20,
        [](const Vec3& p, bool inner, int f) { return inner ? turned(p, 4.0 * kDegree * f) : p; });
    if (round == 0) first = air.topology().tets();
    EXPECT_EQ(air.topology().tets(), first);
  }
}

TEST(AdaptiveAir, IsBuiltAnewWhereNothingElseHelps) {
  const Gap gap = straight_gap();
  int asked = 0;
  const auto whole = [&](const std::vector<Vec3>& x) {
    ++asked;
    return TetMesh{x, gap.tets};
  };
  AdaptiveAir air(gap.tets, gap.x, gap.surfaces, {whole, {}});
  // Through the wall and back: no mesh on the way is whole.
  std::vector<Vec3> away = gap.x;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jump(-1.0, 1.0);
  for (Vec3& p : away) p += Vec3{jump(random), jump(random), jump(random)};
  air.follow(away);
  EXPECT_FALSE(air.is_whole());
  for (int f = 0; f < 40 && !air.is_whole(); ++f) air.follow(gap.x);
  EXPECT_TRUE(air.is_whole());
  EXPECT_GT(asked, 0);
  expect_whole(air, gap, gap.x);
}

TEST(AdaptiveAir, IsNotWholeWithAHoleInIt) {
  Gap gap = straight_gap();
  gap.tets.pop_back();
  EXPECT_FALSE(AdaptiveAir(gap.tets, gap.x, gap.surfaces).is_whole());
}

// Prisms in a column, whose sides are the surface and whose ends are caps.
struct Column {
  std::vector<Vec3> x;
  std::vector<std::vector<Tet>> layers;
  std::vector<Tet> all;
  std::vector<Triangle> sides;

  explicit Column(int prisms) {
    const int last = 3 * prisms;
    for (int level = 0; level <= prisms; ++level)
      for (const Vec3& p : {Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})
        x.push_back(p + Vec3{0, 0, 1.0 * level});
    for (int v = 0; v < last; v += 3) {
      layers.push_back(simulation::testing::prisms_behind({{v, v + 1, v + 2}}, 3, x));
      all.insert(all.end(), layers.back().begin(), layers.back().end());
    }
    sides = outer_faces(TetTopology(all));
    std::erase_if(sides, [&](const Triangle& t) { return t[2] == 2 || t[0] == last; });
  }
};

TEST(AdaptiveAir, MayEndBeforeARimButNotInTheMiddle) {
  const Column column(3);
  ASSERT_EQ(column.sides.size(), 18U);
  EXPECT_TRUE(AdaptiveAir(column.all, column.x, column.sides).is_whole());
  const auto together = [&](int i, int j) {
    std::vector<Tet> tets = column.layers[std::size_t(i)];
    tets.insert(tets.end(), column.layers[std::size_t(j)].begin(),
                column.layers[std::size_t(j)].end());
    return AdaptiveAir(tets, column.x, column.sides).is_whole();
  };
  EXPECT_TRUE(together(0, 1));
  EXPECT_TRUE(together(1, 2));
  EXPECT_FALSE(together(0, 2));
}

TEST(AdaptiveAir, EndsBeforeACapThatTheWallBulgesThrough) {
  const Column column(20);
  AdaptiveAir air(column.all, column.x, column.sides);
  std::vector<Vec3> x = column.x;
  x[57] = {0.3, 0.3, 20.2};  // a vertex below the upper cap, to above it
  air.follow(x);
  EXPECT_TRUE(air.is_whole());
  EXPECT_LT(air.topology().tet_count(), 60);
  EXPECT_GE(air.topology().tet_count(), 54);
  for (const Tet& t : air.topology().tets()) EXPECT_GT(quality_of(t, air.positions()), 0.0);
}

// Makes a quadrilateral of the outer surface flat and takes a tet out over it, as TetGen may leave
// one there: (a, b, c, e) and (a, c, d, e) become (a, b, d, e), (b, c, d, e) and the flat
// (a, b, c, d), which is left out.
bool leave_out_a_flat_tet(Gap& gap) {
  const TetTopology air(gap.tets);
  const auto at = [&](int v) { return gap.x[std::size_t(v)]; };
  for (const TetFace& face : air.boundary()) {
    const Triangle f = air.face(face.tet, face.corner);
    const int e = air.tet(face.tet)[std::size_t(face.corner)];
    for (const TetFace& other : air.boundary())
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = f[k], b = f[(k + 1) % 3], c = f[(k + 2) % 3];  // the edge c - a is shared
        const Triangle g = air.face(other.tet, other.corner);
        const auto at_a = std::find(g.begin(), g.end(), a);
        if (other.tet == face.tet || e != air.tet(other.tet)[std::size_t(other.corner)] ||
            at_a == g.end() || g[std::size_t(at_a - g.begin() + 1) % 3] != c)
          continue;
        const int d = g[std::size_t(at_a - g.begin() + 2) % 3];
        if (d < gap.inner_count()) continue;
        const Vec3 normal = normalized(cross(at(b) - at(a), at(c) - at(a)));
        gap.x[std::size_t(d)] -= dot(normal, at(d) - at(a)) * normal;
        gap.tets[std::size_t(face.tet)] = {a, b, d, e};
        gap.tets[std::size_t(other.tet)] = {b, c, d, e};
        return true;
      }
  }
  return false;
}

TEST(AdaptiveAir, MendsWhereAFlatTetWasLeftOut) {
  const auto straight = [](double) { return 1.15; };
  Gap gap = make_gap(8.0, 0.5, straight, 0.8, 15, 12);
  const Gap whole = gap;
  ASSERT_TRUE(leave_out_a_flat_tet(gap));
  AdaptiveAir air(gap.tets, gap.x, gap.surfaces);
  EXPECT_EQ(air.topology().tet_count(), int(gap.tets.size()) + 1);
  air.follow(gap.x);
  expect_whole(air, whole, gap.x);
  EXPECT_EQ(air.take_report().rebuild_count, 0);
}

// A balloon that unfolds to the lumen's radius and beyond, in a lumen closed at its ends.
SimulationModel model_of(const Gap& gap) {
  SimulationModel model;
  model.balloon = gap.inner;
  model.balloon_rest = gap.inner.vertices;
  for (Vec3& p : model.balloon_rest) p = {2.4 * p.x, 2.4 * p.y, p.z};
  model.balloon_fixed.assign(gap.inner.vertices.size(), 0);
  *(model.balloon_fixed.end() - 1) = *(model.balloon_fixed.end() - 2) = 1;
  model.wall = gap.outer;
  for (const Vec3& p : gap.outer.vertices) {
    model.wall_fixed.push_back(std::abs(p.z) > 4.3);
    model.wall_abscissa.push_back(p.z + 10.0);
    model.wall_group.push_back(0);
  }
  model.air = gap.tets;
  model.reference_radius_mm = 1.2;
  model.measure_tangent = {0, 0, 1};
  return model;
}

TEST(Simulate, ContactFoundInTheAirIsThatOfTheGridAndTheAirStaysWhole) {
  const Gap gap = make_gap(
      8.0, 0.5, [](double) { return 1.15; }, 0.8, 15, 12);
  SimulationModel model = model_of(gap);
  SimulationOptions options;
  options.backend = Backend::cpu;
  options.frame_s = 0.05;
  options.inflation.inflate_s = 1.0;
  options.inflation.hold_s = 0.2;
  options.inflation.deflate_s = 0.5;
  options.inflation.rest_s = 0.0;
  std::vector<std::vector<Vec3>> balloons;
  int touching = 0;
  const SimulationSummary with_air = simulate(model, options, [&](const SimulationFrame& frame) {
    balloons.push_back(frame.balloon);
    touching = std::max(touching, frame.contact.count);
    EXPECT_EQ(frame.air.inverted_count, 0);
    EXPECT_GT(frame.air.min_volume, 0.0);
  });
  EXPECT_GT(touching, 30);
  EXPECT_GT(with_air.flip_count, 20);
  EXPECT_EQ(with_air.frames_without_air, 0);
  model.air.clear();
  simulate(model, options, [&](const SimulationFrame& frame) {
    for (std::size_t v = 0; v < frame.balloon.size(); ++v)
      ASSERT_LT(distance(frame.balloon[v], balloons[std::size_t(frame.frame)][v]), 1e-9);
  });
}

}  // namespace
}  // namespace angio::air_mesh
