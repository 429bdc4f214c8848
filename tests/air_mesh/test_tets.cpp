#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "air_mesh/adaptive_air.hpp"
#include "air_mesh/air_points.hpp"
#include "air_mesh/folds.hpp"
#include "air_mesh/tet_flips.hpp"
#include "air_mesh/tet_refill.hpp"
#include "tests/air_mesh/gap_measures.hpp"

namespace angio::air_mesh {
namespace {

using simulation::testing::Gap;
using test::kDegree;
using test::outer_faces;
using test::quality_of;
using test::straight_gap;
using test::turned;
using test::volume_of;

TEST(TetQuality, IsOneForTheRegularTetAndHasTheSignOfTheVolume) {
  const Vec3 a{1, 1, 1}, b{1, -1, -1}, c{-1, 1, -1}, d{-1, -1, 1};
  EXPECT_NEAR(std::abs(tet_quality(a, b, c, d)), 1.0, 1e-12);
  EXPECT_EQ(tet_quality(a, b, c, d), -tet_quality(b, a, c, d));
  EXPECT_EQ(tet_quality({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}), 0.0);
  EXPECT_NEAR(tet_quality(a, b, c, d), tet_quality(3.0 * a, 3.0 * b, 3.0 * c, 3.0 * d), 1e-12);
}

TEST(TetTopology, EveryFaceLeadsBackToItself) {
  const Gap gap = straight_gap();
  const TetTopology air(gap.tets);
  EXPECT_EQ(air.boundary().size(), gap.surfaces.size());
  for (int t = 0; t < air.slot_count(); ++t)
    for (int c = 0; c < 4; ++c) {
      const TetFace other = air.across(t, c);
      if (other.tet < 0) continue;
      EXPECT_EQ(air.across(other).tet, t);
      EXPECT_EQ(air.across(other).corner, c);
    }
}

TEST(TetTopology, RefusesAReplacementWithAnotherOutside) {
  const Gap gap = straight_gap();
  TetTopology air(gap.tets);
  Tet other = gap.tets[0];
  other[3] = other[3] == gap.tets[5][3] ? gap.tets[6][3] : gap.tets[5][3];
  const int old = 0;
  int slot = -1;
  EXPECT_FALSE(air.replace(&old, 1, &other, 1, &slot));
  EXPECT_EQ(air.tets(), gap.tets);
}

TEST(TetTopology, GoesAroundWhatIsTakenOut) {
  const Gap gap = straight_gap();
  TetTopology air(gap.tets);
  const std::vector<int> gone{3, 40, 41, 200};
  air.remove(gone);
  std::vector<Tet> rest = gap.tets;
  std::size_t index = 0;
  std::erase_if(rest, [&](const Tet&) {
    return std::find(gone.begin(), gone.end(), int(index++)) != gone.end();
  });
  EXPECT_EQ(air.tets(), rest);
  EXPECT_EQ(outer_faces(air), outer_faces(TetTopology(rest)));
}

// Twisted at one end, the balloon drags its tets there through each other; the surfaces do not
// cross.
struct TwistedGap {
  Gap gap = straight_gap();
  std::vector<Vec3> x = gap.x;
  std::vector<double> quality;

  TwistedGap() {
    for (int v = 0; v < gap.inner_count(); ++v) {
      Vec3& p = x[std::size_t(v)];
      p = turned(p, 40.0 * kDegree * std::max(0.0, p.z));
    }
    for (const Tet& t : gap.tets) quality.push_back(quality_of(t, x));
  }
};

bool holds(const Tet& t, const std::vector<Vec3>& x, const Vec3& p) {
  return std::all_of(kTetFace.begin(), kTetFace.end(), [&](const Triangle& f) {
    const auto at = [&](int i) { return x[std::size_t(t[std::size_t(f[std::size_t(i)])])]; };
    return tet_volume(at(0), at(1), at(2), p) > 0.0;
  });
}

TEST(Folds, WithoutThemNoPointIsCoveredTwiceAndNoneIsMissedThatIsNotInThem) {
  const TwistedGap twisted;
  const auto& [gap, x, quality] = twisted;
  const TetTopology air(gap.tets);
  const Folds folds = find_folds(air, x, quality);
  ASSERT_GT(folds.inverted.size(), 20U);
  ASSERT_LT(folds.inverted.size() + folds.overlapping.size(), gap.tets.size());
  std::vector<char> is_out(gap.tets.size(), 0);
  for (const auto* part : {&folds.inverted, &folds.overlapping})
    for (const int t : *part) is_out[std::size_t(t)] = 1;
  // Points in all tets: each is in one kept tet, or in none and in a fold.
  std::mt19937 random(3);
  std::exponential_distribution<double> weight;
  int in_folds = 0;
  for (std::size_t t = 0; t < gap.tets.size(); ++t)
    for (int k = 0; k < 4; ++k) {
      Vec3 p;
      double sum = 0.0;
      for (const int v : gap.tets[t]) {
        const double w = weight(random);
        p += w * x[std::size_t(v)];
        sum += w;
      }
      p = p / sum;
      int kept = 0, right = 0, left = 0;
      for (std::size_t u = 0; u < gap.tets.size(); ++u) {
        Tet tet = gap.tets[u];
        if (quality[u] <= 0.0) std::swap(tet[2], tet[3]);
        if (!holds(tet, x, p)) continue;
        (quality[u] > 0.0 ? right : left) += 1;
        kept += is_out[u] != 0 ? 0 : 1;
      }
      EXPECT_GE(right - left, 0);  // 0: tets that reach out of the gap
      EXPECT_LE(right - left, 1);
      EXPECT_LE(kept, right - left);
      if (left > 0) {
        EXPECT_EQ(kept, 0);
      }
      in_folds += kept == 0 ? 1 : 0;
    }
  EXPECT_GT(in_folds, 0);
}

TEST(Folds, AreWholeWithWhatOverlapsThem) {
  const TwistedGap twisted;
  const TetTopology air(twisted.gap.tets);
  const Folds folds = find_folds(air, twisted.x, twisted.quality);
  for (const int t : folds.inverted) {
    const std::vector<int> fold = with_whole_folds(air, folds, {t});
    for (const auto& [a, b] : folds.pairs)
      EXPECT_EQ(std::binary_search(fold.begin(), fold.end(), a),
                std::binary_search(fold.begin(), fold.end(), b));
  }
}

TEST(Flips, RaiseTheLeastQualityAndKeepVolumeAndOutside) {
  const Gap gap = straight_gap();
  std::vector<Vec3> x = gap.x;
  for (int v = 0; v < gap.inner_count(); ++v) x[std::size_t(v)] = turned(x[std::size_t(v)], 0.15);
  TetTopology air(gap.tets);
  int edges = 0, faces = 0;
  for (int t = 0; t < air.slot_count(); ++t) {
    if (!air.alive(t) || quality_of(air.tet(t), x) > 0.4) continue;
    const TetFlip flip = best_flip(air, x, t);
    if (flip.old_count == 0) continue;
    std::vector<Tet> before, after(flip.fresh.begin(), flip.fresh.begin() + flip.fresh_count);
    for (int i = 0; i < flip.old_count; ++i) before.push_back(air.tet(flip.old[std::size_t(i)]));
    const auto least = [&](const std::vector<Tet>& tets) {
      double q = 1.0;
      for (const Tet& tet : tets) q = std::min(q, quality_of(tet, x));
      return q;
    };
    EXPECT_DOUBLE_EQ(least(before), flip.before);
    EXPECT_DOUBLE_EQ(least(after), flip.after);
    EXPECT_GT(flip.after, flip.before);
    EXPECT_NEAR(volume_of(before, x), volume_of(after, x), 1e-12);
    std::vector<int> slots(after.size());
    ASSERT_TRUE(
        air.replace(flip.old.data(), flip.old_count, after.data(), flip.fresh_count, slots.data()));
    (flip.fresh_count > flip.old_count ? faces : edges) += 1;
  }
  EXPECT_GT(edges, 20);
  EXPECT_GT(faces, 0);
  EXPECT_NEAR(volume_of(air.tets(), x) / gap.volume(x), 1.0, 1e-9);
  EXPECT_EQ(outer_faces(air), outer_faces(TetTopology(gap.tets)));
}

// A convex prism whose square sides' diagonals turn about it; `twist` turns its top. Between 0 and
// 60 degrees it is Schoenhardt's polyhedron, which no tets over its six corners fill. It is given
// as tets around a middle point, the last vertex.
struct Prism {
  std::vector<Vec3> x;
  std::vector<Tet> tets;
};
Prism make_prism(double twist) {
  Prism prism;
  for (int level = 0; level < 2; ++level)
    for (int k = 0; k < 3; ++k) {
      const double angle = 120.0 * kDegree * k + (level == 1 ? twist : 0.0);
      prism.x.push_back({std::cos(angle), std::sin(angle), double(level)});
    }
  prism.x.push_back({0.0, 0.0, 0.5});
  std::vector<Triangle> outside{{0, 1, 2}, {3, 5, 4}};
  for (int k = 0; k < 3; ++k) {
    const int a = k, b = (k + 1) % 3, c = a + 3, d = b + 3;
    outside.push_back({a, c, b});
    outside.push_back({b, c, d});
  }
  for (const Triangle& f : outside) prism.tets.push_back({f[0], f[1], f[2], 6});
  return prism;
}

std::vector<int> all_of(const TetTopology& air) {
  std::vector<int> tets(std::size_t(air.slot_count()));
  for (int t = 0; t < air.slot_count(); ++t) tets[std::size_t(t)] = t;
  return tets;
}

TEST(Refill, FillsAPrismThatIsTwistedOutward) {
  const Prism prism = make_prism(20.0 * kDegree);
  const TetTopology air(prism.tets);
  for (const Tet& t : prism.tets) ASSERT_GT(quality_of(t, prism.x), 0.0);
  const std::vector<Tet> filling = refill(air, prism.x, all_of(air), 1000, 6);
  ASSERT_FALSE(filling.empty());
  EXPECT_NEAR(volume_of(filling, prism.x), volume_of(prism.tets, prism.x), 1e-12);
  for (const Tet& t : filling) EXPECT_GT(quality_of(t, prism.x), 0.0);
}

TEST(Refill, FindsThatSchoenhardtsPolyhedronHasNoFilling) {
  const Prism prism = make_prism(-20.0 * kDegree);
  const TetTopology air(prism.tets);
  for (const Tet& t : prism.tets) ASSERT_GT(quality_of(t, prism.x), 0.0);
  EXPECT_TRUE(refill(air, prism.x, all_of(air), 1000, 6).empty());
  EXPECT_EQ(volume_of(refill(air, prism.x, all_of(air), 1000), prism.x),
            volume_of(prism.tets, prism.x));
}

TEST(Refill, TakesNoPointAwayThatABorderRunsThrough) {
  const Prism prism = make_prism(20.0 * kDegree);
  for (const std::size_t gone : {std::size_t(0), std::size_t(3), prism.tets.size() - 1}) {
    std::vector<Tet> tets = prism.tets;
    tets.erase(tets.begin() + std::ptrdiff_t(gone));
    const TetTopology air(tets);
    EXPECT_TRUE(refill(air, prism.x, all_of(air), 1000, 6).empty()) << gone;
  }
}

TEST(InnerPoint, LiesFarthestFromTheNearestFaceOfACube) {
  std::vector<Vec3> x;
  for (int i = 0; i < 8; ++i) x.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)});
  const std::vector<Triangle> faces{{0, 1, 2}, {4, 6, 5}, {0, 4, 1},
                                    {2, 3, 6}, {0, 2, 4}, {1, 5, 3}};
  const InnerPoint inner = find_inner_point(faces, x, {0.2, 0.9, 0.3});
  EXPECT_NEAR(inner.height, 0.5, 0.02);
  EXPECT_LT(distance(inner.point, {0.5, 0.5, 0.5}), 0.05);
}

TEST(HollowSearch, GivesAHollowThatThePointSees) {
  const Gap gap = straight_gap();
  const TetTopology air(gap.tets);
  HollowSearch search(air, gap.x, {100});
  const Vec3 place = gap.x[std::size_t(gap.tets[100][0])] + Vec3{0.1, 0.1, 0.2};
  const SeenHollow hollow = search.find(place, 80);
  ASSERT_FALSE(hollow.tets.empty());
  double volume = 0.0;
  for (const Triangle& f : outside_of(air, hollow.tets)) {
    const double v = tet_volume(gap.x[std::size_t(f[0])], gap.x[std::size_t(f[1])],
                                gap.x[std::size_t(f[2])], hollow.point);
    EXPECT_GT(v, 0.0);
    volume += v;
  }
  std::vector<Tet> old;
  for (const int t : hollow.tets) old.push_back(air.tet(t));
  EXPECT_NEAR(volume, volume_of(old, gap.x), 1e-12);
}

}  // namespace
}  // namespace angio::air_mesh
