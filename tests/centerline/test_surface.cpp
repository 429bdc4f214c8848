#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "centerline/centerline.hpp"
#include "centerline/detail/contour.hpp"
#include "centerline/detail/smooth_surface.hpp"
#include "core/error.hpp"
#include "meshing/detail/isosurface.hpp"
#include "testing/centerline/shapes.hpp"
#include "tests/centerline/tree_checks.hpp"

namespace angio::centerline {
namespace {

using test::constant;

/// The surface x = (a(z) cos, b(z) sin, z), z in [0, length]; triangles counter-clockwise seen from
/// outside.
TriangleMesh make_elliptic_tube(double length, int rings, int around,
                                const std::function<double(double)>& a,
                                const std::function<double(double)>& b, bool closed) {
  TriangleMesh mesh;
  for (int r = 0; r < rings; ++r) {
    const double z = length * r / (rings - 1);
    for (int i = 0; i < around; ++i) {
      const double theta = 2.0 * units::kPi * i / around;
      mesh.vertices.push_back({a(z) * std::cos(theta), b(z) * std::sin(theta), z});
    }
  }
  const auto at = [&](int r, int i) { return r * around + i % around; };
  for (int r = 0; r + 1 < rings; ++r)
    for (int i = 0; i < around; ++i) {
      mesh.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i + 1)});
      mesh.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r + 1, i)});
    }
  if (!closed) return mesh;
  const int bottom = int(mesh.vertices.size());
  mesh.vertices.push_back({0, 0, 0});
  mesh.vertices.push_back({0, 0, length});
  for (int i = 0; i < around; ++i) {
    mesh.triangles.push_back({at(0, i + 1), at(0, i), bottom});
    mesh.triangles.push_back({at(rings - 1, i), at(rings - 1, i + 1), bottom + 1});
  }
  return mesh;
}

/// 3 mm at the ends, 1.2 mm in the middle of 30 mm.
double stenosed(double z) {
  const double x = (z - 15.0) / 6.0;
  return std::abs(x) >= 1.0 ? 1.5 : 1.5 * (1.0 - 0.3 * (1.0 + std::cos(units::kPi * x)));
}

TEST(PolarBias, IsNothingOnACircleAndTheVarianceOverTheDistanceOnAFlatWall) {
  Contour circle, slit;  // the slit: 1.2 by 4, its sides flat
  for (int i = 0; i < 360; ++i) {
    const double c = std::cos(units::kPi * i / 180.0), d = std::sin(units::kPi * i / 180.0);
    circle.push_back({1.5 * c, 1.5 * d});
    const double r = std::min(2.0 / std::max(std::abs(c), 1e-9), 0.6 / std::max(std::abs(d), 1e-9));
    slit.push_back({r * c, r * d});
  }
  for (const double bias : polar_bias(circle, 0.1)) EXPECT_NEAR(bias, 0.0, 1e-5);
  const std::vector<double> bias = polar_bias(slit, 0.05);
  for (const std::size_t degrees : {60U, 90U, 270U}) {
    const double sine = std::sin(units::kPi * double(degrees) / 180.0);
    EXPECT_NEAR(bias[degrees], 0.05 * 0.05 / 0.6 / std::abs(sine), 1e-6) << degrees;
  }
}

TEST(ExtractFromSurface, MeasuresAClosedTube) {
  const auto mesh = make_elliptic_tube(30, 101, 96, constant(1.5), constant(1.5), true);
  ASSERT_GT(enclosed_volume(mesh), 0.0);
  const auto result = extract_centerline(mesh, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const auto& path = result.tree.paths[0];
  EXPECT_NEAR(path.abscissa.back(), 30.0, 0.1);
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    EXPECT_LT(std::hypot(path.points[i].x, path.points[i].y), 0.01);
    EXPECT_NEAR(path.inscribed_radius[i], 1.5, 0.01);
    EXPECT_NEAR(path.section_area[i], units::kPi * 2.25, 0.03);
  }
}

TEST(ExtractFromSurface, ClosesOpenRims) {
  const auto open = make_elliptic_tube(30, 101, 48, stenosed, stenosed, false);
  const auto result = extract_centerline(open, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const auto lesions = find_lesions(result.tree, {});
  ASSERT_EQ(lesions.size(), 1U);
  EXPECT_NEAR(lesions[0].mld_mm, 1.2, 0.02);
  EXPECT_NEAR(lesions[0].diameter_stenosis_percent, 60.0, 1.0);
}

TEST(ExtractFromSurface, BeginsAtTheWiderRimThoughTheVesselIsNarrowedThere) {
  // From 3 to 2 mm; the half at the wide end is narrowed for most of its length.
  for (const bool is_turned : {false, true}) {
    const auto radius = [=](double z) {
      const double from_wide = is_turned ? 1.0 - z / 40.0 : z / 40.0;
      const double narrowed = std::abs(from_wide - 0.3) < 0.2
                                  ? 0.5 * (1.0 + std::cos(units::kPi * (from_wide - 0.3) / 0.2))
                                  : 0.0;
      return 1.5 * (1.0 - from_wide / 3.0) * (1.0 - 0.5 * std::sqrt(narrowed));
    };
    const auto tree =
        extract_centerline(make_elliptic_tube(40, 161, 48, radius, radius, false), {}).tree;
    ASSERT_EQ(tree.paths.size(), 1U);
    EXPECT_NEAR(tree.paths[0].points.front().z, is_turned ? 40.0 : 0.0, 0.5);
  }
}

TEST(ExtractFromSurface, DoesNotCareHowTheTrianglesAreTurnedOrShared) {
  TriangleMesh mesh = make_elliptic_tube(20, 61, 32, constant(1.5), constant(1.5), true);
  const auto reference = extract_centerline(mesh, {});
  TriangleMesh soup;  // as an STL file has it, inside out
  for (const Triangle& t : mesh.triangles) {
    const int first = int(soup.vertices.size());
    for (const int v : t) soup.vertices.push_back(mesh.vertices[std::size_t(v)]);
    soup.triangles.push_back({first, first + 2, first + 1});
  }
  const auto result = extract_centerline(soup, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_NEAR(result.tree.paths[0].abscissa.back(), reference.tree.paths[0].abscissa.back(), 0.05);
}

TEST(ExtractFromSurface, EndsAtTheCapsOfARoughWall) {
  TriangleMesh mesh = make_elliptic_tube(20, 81, 40, constant(1.5), constant(1.5), true);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> off(0.96, 1.04);
  for (Vec3& v : mesh.vertices) {  // within the caps' planes
    const double scale = off(random);
    v = {scale * v.x, scale * v.y, v.z};
  }
  const double rough = roughness(mesh);
  EXPECT_GT(rough, 0.1);
  EXPECT_LT(rough, 0.2);
  const auto result = extract_centerline(mesh, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  const Vec3 inlet = result.tree.paths[0].points.front();
  EXPECT_LT(std::min(distance(inlet, {0, 0, 0}), distance(inlet, {0, 0, 20})), 0.01);
}

TEST(ExtractFromSurface, RefusesAFlatOne) {
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_THROW(extract_centerline(flat, {}), InputError);
  EXPECT_THROW(extract_centerline(TriangleMesh{}, {}), InputError);
}

TEST(ExtractFromSurface, TurnsTrianglesAlikeAndJoinsWhatWasRoundedApart) {
  const TriangleMesh mesh = make_elliptic_tube(20, 61, 32, constant(1.5), constant(1.5), false);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> rounding(-1e-6, 1e-6);
  TriangleMesh soup;
  for (const Triangle& t : mesh.triangles) {
    const int first = int(soup.vertices.size());
    for (const int v : t)
      soup.vertices.push_back(mesh.vertices[std::size_t(v)] +
                              Vec3{rounding(random), rounding(random), rounding(random)});
    const bool turned = random() % 2 == 0;
    soup.triangles.push_back({first, first + (turned ? 2 : 1), first + (turned ? 1 : 2)});
  }
  const auto result = extract_centerline(soup, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  EXPECT_NEAR(result.tree.paths[0].abscissa.back(), 20.0, 0.2);
}

TEST(ExtractFromSurface, RefusesBrokenNumbers) {
  TriangleMesh mesh = make_elliptic_tube(20, 61, 32, constant(1.5), constant(1.5), false);
  mesh.triangles[5][1] = 1000000;
  EXPECT_THROW(extract_centerline(mesh, {}), InputError);
  mesh.triangles.erase(mesh.triangles.begin() + 5);
  mesh.vertices[7].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(extract_centerline(mesh, {}), InputError);
}

TEST(ExtractFromSurface, BloodComesInByAClosedTrunkThatIsWiderThanTheOpenEnds) {
  const auto tube = [](const Vec3& a, const Vec3& b, double radius) {
    return test::straight_tube(a, b, [=](double) { return radius; });
  };
  const Vec3 fork{0.0, 0.0, 30.0};
  const std::vector<test::Tube> tubes{tube({0.0, 0.0, 0.0}, fork, 4.0),
                                      tube(fork, {12.0, 0.0, 60.0}, 3.1),
                                      tube(fork, {-12.0, 0.0, 60.0}, 2.9)};
  const auto grid = test::grid_around(tubes, 0.5, 2.0);
  TriangleMesh mesh = meshing::detail::extract_isosurface(test::level_set_of(tubes, grid));
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(),
                       [&](int v) { return mesh.vertices[std::size_t(v)].z > 55.0; });
  });
  const auto result = extract_centerline(mesh, {});
  ASSERT_EQ(result.tree.paths.size(), 2U);
  EXPECT_LT(distance(result.tree.paths[0].points.front(), {0.0, 0.0, 0.0}), 5.0);
}

TEST(MeasureLumen, KnowsAnEllipse) {
  // Inscribed circle: the short half axis. Area: pi a b.
  const auto mesh = make_elliptic_tube(20, 61, 96, constant(1.8), constant(1.2), true);
  const auto path = extract_centerline(mesh, {}).tree.paths[0];
  const LumenProfile profile = measure_lumen(mesh, path, 5.0, 15.0);
  ASSERT_GT(profile.abscissa.size(), 10U);
  EXPECT_GE(profile.abscissa.front(), 5.0);
  EXPECT_LE(profile.abscissa.back(), 15.0);
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i) {
    EXPECT_NEAR(profile.inscribed_radius[i], 1.2, 0.02);
    EXPECT_NEAR(profile.section_area[i], units::kPi * 1.8 * 1.2, 0.05);
  }
}

TEST(MeasureLumen, SeesADilatedVesselOnTheOldLine) {
  // Edges of a third of the radius, as the lumen mesh has them.
  const auto before = make_elliptic_tube(30, 61, 19, stenosed, stenosed, false);
  const auto path = extract_centerline(before, {}).tree.paths[0];
  TriangleMesh after = make_elliptic_tube(30, 61, 19, constant(1.5), constant(1.5), false);
  for (Vec3& p : after.vertices) p.x += 0.3;  // and pushed aside
  const LumenProfile profile = measure_lumen(after, path, 3.0, 27.0);
  // The vertices are on the wall, so the lumen is the circle through them and not the polygon.
  ASSERT_GT(profile.abscissa.size(), 20U);
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i) {
    EXPECT_NEAR(profile.inscribed_radius[i], 1.5, 0.005);
    EXPECT_NEAR(profile.section_area[i], units::kPi * 2.25, 0.02);
  }
}

TEST(MeasureLumen, SeesAThroatThatWasOpenedTenfold) {
  CenterlinePath path;
  for (double z = 0.0; z < 30.0; z += 0.5 * path.inscribed_radius.back()) {
    path.points.push_back({0.0, 0.0, z});
    path.inscribed_radius.push_back(1.5 - 1.35 * std::exp(-0.25 * (z - 15.0) * (z - 15.0)));
  }
  path.abscissa = arc_length(path.points);
  path.equivalent_radius = path.inscribed_radius;
  const auto opened = make_elliptic_tube(30, 61, 19, constant(1.5), constant(1.5), false);
  const LumenProfile profile = measure_lumen(opened, path, 3.0, 27.0);
  const auto is_asked_for = [](double s) { return s >= 3.0 && s <= 27.0; };
  ASSERT_EQ(std::ptrdiff_t(profile.abscissa.size()),
            std::count_if(path.abscissa.begin(), path.abscissa.end(), is_asked_for));
  for (const double radius : profile.inscribed_radius) EXPECT_NEAR(radius, 1.5, 0.005);
}

// The line's points are dense in the throat: smoothing pulls them along the line, a little each
// time.
TEST(LumenFollower, SeesTheSameLumenHoweverOftenAndHoweverFarItIsMoved) {
  constexpr int kMoments = 100;
  const auto mesh = make_elliptic_tube(30, 181, 48, stenosed, stenosed, false);
  CenterlinePath path;
  for (double z = 0.0; z < 30.0; z += 0.4 * path.inscribed_radius.back()) {
    path.points.push_back({0.0, 0.0, z});
    path.inscribed_radius.push_back(stenosed(z));
  }
  path.abscissa = arc_length(path.points);
  path.equivalent_radius = path.inscribed_radius;
  const LumenProfile itself = measure_lumen(mesh.vertices, path, 8.0, 22.0);
  LumenProfile second;
  LumenFollower follower(8.0, 22.0);
  for (int moment = 0; moment <= kMoments; ++moment) {
    const Vec3 aside{moment % 2 == 0 ? 0.0 : 6.0, 0.0, 0.0};
    std::vector<Vec3> wall = mesh.vertices;
    CenterlinePath moved = path;
    for (Vec3& p : wall) p += aside;
    for (Vec3& p : moved.points) p += aside;
    const LumenProfile seen = follower.measure(std::move(wall), moved);
    ASSERT_EQ(seen.abscissa, itself.abscissa) << moment;
    for (std::size_t i = 0; i < seen.abscissa.size(); ++i) {
      EXPECT_NEAR(seen.inscribed_radius[i], itself.inscribed_radius[i], 0.015) << moment;
      if (moment > 1) {
        EXPECT_NEAR(seen.inscribed_radius[i], second.inscribed_radius[i], 1e-3);
      }
    }
    if (moment == 1) second = seen;
  }
}

TEST(MeasureLumen, LeavesOutSingleSectionsThatTheirNeighboursDisproveAndNoShortThroat) {
  const LumenProfile seen{{1.0, 1.3, 1.6, 1.9, 2.2, 2.5, 2.8, 3.1},
                          {1.5, 0.6, 1.5, 1.5, 0.9, 0.8, 1.4, 0.5},
                          {7.0, 7.1, 7.2, 7.3, 3.0, 2.5, 6.0, 6.1}};
  const LumenProfile left = without_disproved(seen);
  EXPECT_EQ(left.abscissa, (std::vector<double>{1.0, 1.6, 1.9, 2.2, 2.5, 2.8, 3.1}));
  EXPECT_EQ(left.inscribed_radius, (std::vector<double>{1.5, 1.5, 1.5, 0.9, 0.8, 1.4, 0.5}));
  EXPECT_EQ(left.section_area, (std::vector<double>{7.0, 7.2, 7.3, 3.0, 2.5, 6.0, 6.1}));
}

TEST(MeasureLumen, AgreesWithTheLineItself) {
  const auto mesh = make_elliptic_tube(30, 101, 48, stenosed, stenosed, false);
  const auto path = extract_centerline(mesh, {}).tree.paths[0];
  const LumenProfile profile = measure_lumen(mesh, path, 3.0, 27.0);
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i)
    EXPECT_NEAR(profile.inscribed_radius[i], sample(path, profile.abscissa[i]).inscribed_radius,
                0.02);
}

TEST(MeasureLumen, OfAFlatVesselDoesNotDependOnALineThatWandersAlongIt) {
  const auto mesh = make_elliptic_tube(30, 121, 64, constant(1.8), constant(0.6), false);
  CenterlinePath path;
  for (int i = 0; i <= 120; ++i) {
    const double z = 0.25 * i;
    path.points.push_back(
        {0.4 * std::sin(2.0 * units::kPi * z / 2.5), 0.0, z});  // up to 45 degrees
  }
  path.abscissa = arc_length(path.points);
  path.inscribed_radius.assign(path.points.size(), 0.6);
  path.equivalent_radius.assign(path.points.size(), std::sqrt(1.8 * 0.6));
  path.section_area.assign(path.points.size(), units::kPi * 1.8 * 0.6);
  const double length = path.abscissa.back();
  const LumenProfile profile = measure_lumen(mesh, path, 0.2 * length, 0.8 * length);
  ASSERT_GT(profile.abscissa.size(), 50U);
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i) {
    EXPECT_NEAR(profile.inscribed_radius[i], 0.6, 0.015);
    EXPECT_NEAR(profile.section_area[i], units::kPi * 1.8 * 0.6, 0.03 * units::kPi * 1.8 * 0.6);
  }
}

TEST(ExtractFromSurface, RunsThroughTheMiddleOfASlit) {
  // A throat five times as wide as high.
  const auto mesh = make_elliptic_tube(
      30, 151, 64, constant(1.5), [](double z) { return 0.3 + (stenosed(z) - 0.6) * 1.2 / 0.9; },
      false);
  const auto result = extract_centerline(mesh, {});
  ASSERT_EQ(result.tree.paths.size(), 1U);
  for (const Vec3& p : result.tree.paths[0].points)
    if (p.z > 3.0 && p.z < 27.0) {
      EXPECT_LT(std::hypot(p.x, p.y), 0.01);
    }
}

/// Text STL: only the corners matter.
TriangleMesh read_text_stl(const std::filesystem::path& path) {
  std::ifstream file(path);
  TriangleMesh mesh;
  for (std::string word; file >> word;) {
    if (word != "vertex") continue;
    Vec3 p;
    file >> p.x >> p.y >> p.z;
    mesh.vertices.push_back(p);
    const int n = int(mesh.vertices.size());
    if (n % 3 == 0) mesh.triangles.push_back({n - 3, n - 2, n - 1});
  }
  return mesh;
}

TEST(ExtractFromSurface, FindsOneInletAndSixOutletsOfARealCoronaryTree) {
  const char* data = std::getenv("ANGIO_DATA");
  if (data == nullptr) GTEST_SKIP() << "ANGIO_DATA is not set";
  const auto path = std::filesystem::path(data) / "coronary-lumen-xra" / "lumen.stl";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const auto result = extract_centerline(read_text_stl(path), {});
  EXPECT_EQ(result.tree.paths.size(), 6U);
  EXPECT_TRUE(result.warnings.empty());
}

}  // namespace
}  // namespace angio::centerline
