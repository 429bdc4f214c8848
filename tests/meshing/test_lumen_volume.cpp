#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "air_mesh/build/tet_shape.hpp"
#include "core/error.hpp"
#include "meshing/detail/improve_tets.hpp"
#include "meshing/lumen_volume.hpp"
#include "testing/meshing/analytic_vessels.hpp"

namespace angio::meshing {
namespace {

using std::numbers::pi;

struct FilledCase {
  const char* name;
  test::Vessel vessel;
};
void PrintTo(const FilledCase& c, std::ostream* stream) { *stream << c.name; }

std::vector<FilledCase> filled_cases() {
  return {{"Tube", test::make_tube(20.0, 0.3, [](double) { return 1.5; })},
          {"StenosedTube", test::make_tube(24.0, 0.3, test::stenosis(1.5, 12.0, 5.0, 0.6))},
          {"Arc", test::make_arc(1.5, 8.0, 2.5, 0.3)},
          {"Fork", test::make_fork(1.5, 1.1, 12.0, 12.0, 0.6, 0.3)},
          {"Trifurcation", test::make_branching(3, 1.5, 1.0, 8.0, 9.0, 0.9, 0.3)}};
}

class FilledLumen : public testing::TestWithParam<FilledCase> {
 protected:
  struct Made {
    LumenMesh lumen;
    LumenVolume volume;
  };
  /// Made once for all tests of a vessel.
  static const Made& made() {
    static std::map<std::string, Made> all;
    const auto [at, is_new] = all.try_emplace(GetParam().name);
    if (is_new) {
      at->second.lumen = mesh_lumen(GetParam().vessel.level_set, GetParam().vessel.tree, {});
      at->second.volume = mesh_lumen_volume(at->second.lumen, {});
    }
    return at->second;
  }
  const LumenMesh& lumen_ = made().lumen;
  const LumenVolume& volume_ = made().volume;
};

TEST_P(FilledLumen, FillsTheCappedSurface) {
  double sum = 0.0;
  const TetMesh& mesh = volume_.mesh;
  for (const Tet& t : mesh.tets) {
    const double own =
        tet_volume(mesh.vertices[std::size_t(t[0])], mesh.vertices[std::size_t(t[1])],
                   mesh.vertices[std::size_t(t[2])], mesh.vertices[std::size_t(t[3])]);
    EXPECT_GT(own, 0.0);
    sum += own;
  }
  EXPECT_NEAR(sum / enclosed_volume(lumen_.capped), 1.0, 1e-9);
  EXPECT_DOUBLE_EQ(volume_.volume_mm3, sum);
}

TEST_P(FilledLumen, KeepsTheWallsTrianglesAsFaces) {
  const std::size_t wall_count = lumen_.open.triangles.size();
  ASSERT_GE(volume_.boundary.size(), wall_count);
  for (std::size_t v = 0; v < lumen_.open.vertices.size(); ++v)
    EXPECT_EQ(volume_.mesh.vertices[v], lumen_.open.vertices[v]);
  for (std::size_t t = 0; t < wall_count; ++t) {
    EXPECT_EQ(volume_.boundary[t], lumen_.open.triangles[t]);
    EXPECT_EQ(volume_.boundary_entity_id[t], kWallEntityId);
  }
  const SurfaceTopology topology = surface_topology({volume_.mesh.vertices, volume_.boundary});
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.euler_number, 2);
}

TEST_P(FilledLumen, HasTheBoundaryFacesOnceAndTheInnerOnesTwice) {
  std::map<Triangle, int> uses;
  for (const Tet& t : volume_.mesh.tets)
    for (std::size_t lacks = 0; lacks < 4; ++lacks) {
      Triangle face{t[(lacks + 1) % 4], t[(lacks + 2) % 4], t[(lacks + 3) % 4]};
      std::sort(face.begin(), face.end());
      ++uses[face];
    }
  std::size_t once = 0;
  for (const auto& [face, count] : uses) {
    EXPECT_LE(count, 2);
    once += count == 1 ? 1 : 0;
  }
  EXPECT_EQ(once, volume_.boundary.size());
  for (Triangle face : volume_.boundary) {
    std::sort(face.begin(), face.end());
    EXPECT_EQ(uses[face], 1);
  }
}

TEST_P(FilledLumen, NamesInletAndOutletsInPathOrder) {
  std::map<int, Vec3> sum;
  std::map<int, double> area;
  for (std::size_t t = 0; t < volume_.boundary.size(); ++t) {
    const Triangle& c = volume_.boundary[t];
    const auto at = [&](std::size_t i) { return volume_.mesh.vertices[std::size_t(c[i])]; };
    const double own = 0.5 * norm(cross(at(1) - at(0), at(2) - at(0)));
    sum[volume_.boundary_entity_id[t]] += own / 3.0 * (at(0) + at(1) + at(2));
    area[volume_.boundary_entity_id[t]] += own;
  }
  const auto& paths = GetParam().vessel.tree.paths;
  ASSERT_EQ(area.size(), paths.size() + 2);
  const double inlet_radius = paths[0].inscribed_radius.front();
  EXPECT_NEAR(area[kInletEntityId] / (pi * inlet_radius * inlet_radius), 1.0, 0.03);
  EXPECT_LT(distance(sum[kInletEntityId] / area[kInletEntityId], paths[0].points.front()),
            2.0 * inlet_radius);
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const int id = kInletEntityId + 1 + int(p);
    EXPECT_LT(distance(sum[id] / area[id], paths[p].points.back()), 2.0 * inlet_radius);
  }
}

TEST_P(FilledLumen, HasNoSharpTetrahedra) {
  double least = 180.0;
  for (const Tet& t : volume_.mesh.tets)
    least = std::min(least, air_mesh::dihedral_range(volume_.mesh.vertices[std::size_t(t[0])],
                                                     volume_.mesh.vertices[std::size_t(t[1])],
                                                     volume_.mesh.vertices[std::size_t(t[2])],
                                                     volume_.mesh.vertices[std::size_t(t[3])])
                                .least);
  EXPECT_GE(least, 12.0);
  EXPECT_EQ(volume_.sharp_tet_count, 0);
  EXPECT_THAT(volume_.warnings, testing::IsEmpty());
  EXPECT_DOUBLE_EQ(volume_.min_dihedral_degrees, least);
  EXPECT_LE(volume_.max_dihedral_degrees, 168.0);
}

TEST_P(FilledLumen, GivesTheSameBytesTwice) {
  const LumenVolume again = mesh_lumen_volume(lumen_, {});
  EXPECT_EQ(volume_.mesh.vertices, again.mesh.vertices);
  EXPECT_EQ(volume_.mesh.tets, again.mesh.tets);
  EXPECT_EQ(volume_.boundary, again.boundary);
}

INSTANTIATE_TEST_SUITE_P(Vessels, FilledLumen, testing::ValuesIn(filled_cases()),
                         [](const auto& test_case) { return std::string(test_case.param.name); });

LumenMesh tube_lumen() {
  const auto vessel = test::make_tube(12.0, 0.4, [](double) { return 2.0; });
  return mesh_lumen(vessel.level_set, vessel.tree, {});
}

TEST(LumenVolumes, GrowCoarserInsideWithTheEdgeRatio) {
  const LumenMesh lumen = tube_lumen();
  LumenVolumeOptions options;
  const std::size_t fine = mesh_lumen_volume(lumen, options).mesh.tets.size();
  options.edge_ratio = 2.0;
  const std::size_t coarse = mesh_lumen_volume(lumen, options).mesh.tets.size();
  EXPECT_LT(double(coarse), 0.8 * double(fine));
}

TEST(LumenVolumes, KeepTheBudgetAndSaySo) {
  const LumenMesh lumen = tube_lumen();
  LumenVolumeOptions options;
  options.edge_ratio = 0.5;
  const std::size_t full = mesh_lumen_volume(lumen, options).mesh.tets.size();
  options.tet_budget = int(full / 2);
  const LumenVolume volume = mesh_lumen_volume(lumen, options);
  // Improving adds a few points after the budget has been kept.
  EXPECT_LT(double(volume.mesh.tets.size()), 1.05 * options.tet_budget);
  EXPECT_THAT(volume.warnings, testing::Contains(testing::HasSubstr("budget")));
}

/// With a fixed count of triangles the open lumen has its outlets' caps and a part of the inlet's.
TEST(LumenVolumes, OfAFixedCountOfTrianglesHaveWallInletAndOutletsToo) {
  const auto vessel = test::make_fork(1.5, 1.1, 12.0, 12.0, 0.6, 0.3);
  LumenMeshOptions options;
  options.triangle_count = 4000;
  const LumenMesh lumen = mesh_lumen(vessel.level_set, vessel.tree, options);
  ASSERT_EQ(lumen.open.triangles.size(), 4000U);
  const LumenVolume volume = mesh_lumen_volume(lumen, {});
  EXPECT_NEAR(volume.volume_mm3 / enclosed_volume(lumen.capped), 1.0, 1e-9);
  const SurfaceTopology topology = surface_topology({volume.mesh.vertices, volume.boundary});
  EXPECT_TRUE(topology.is_closed());
  EXPECT_EQ(topology.euler_number, 2);
  const auto areas = [](const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                        const auto& id_of) {
    std::map<int, double> area;
    for (std::size_t t = 0; t < triangles.size(); ++t)
      area[id_of(t)] += 0.5 * norm(area_vector_doubled({vertices, {}}, triangles[t]));
    return area;
  };
  const std::map<int, double> of_surface =
      areas(lumen.capped.vertices, lumen.capped.triangles, [&](std::size_t t) {
        const Triangle& c = lumen.capped.triangles[t];
        const auto id = [&](std::size_t i) { return lumen.inlet_outlet_id[std::size_t(c[i])]; };
        return kWallEntityId + (id(0) == id(1) && id(0) == id(2) ? id(0) : 0);
      });
  const std::map<int, double> of_volume =
      areas(volume.mesh.vertices, volume.boundary,
            [&](std::size_t t) { return volume.boundary_entity_id[t]; });
  ASSERT_EQ(of_surface.size(), vessel.tree.paths.size() + 2);
  ASSERT_EQ(of_volume.size(), of_surface.size());
  for (const auto& [id, area] : of_surface) EXPECT_NEAR(of_volume.at(id) / area, 1.0, 1e-9) << id;
}

TEST(LumenVolumes, OfASurfaceThatIsNotWatertightAreRefused) {
  LumenMesh lumen = tube_lumen();
  lumen.watertight = false;
  EXPECT_THROW(mesh_lumen_volume(lumen, {}), InputError);
}

TEST(LumenVolumeOptions, DefaultsAreValid) { EXPECT_NO_THROW(LumenVolumeOptions{}.validate()); }

TEST(LumenVolumeOptions, NamesWhatIsOutOfRange) {
  LumenVolumeOptions options;
  options.edge_ratio = 9.0;
  try {
    options.validate();
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("edge_ratio"));
  }
}

TEST(TetShape, OfARegularTetrahedronIsKnown) {
  const Vec3 a{1, 1, 1}, b{1, -1, -1}, c{-1, 1, -1}, d{-1, -1, 1};
  const double angle = std::acos(1.0 / 3.0);
  const auto range = air_mesh::dihedral_range(a, b, c, d);
  EXPECT_NEAR(range.least, angle * 180.0 / pi, 1e-9);
  EXPECT_NEAR(range.greatest, angle * 180.0 / pi, 1e-9);
  const double sine = air_mesh::least_dihedral_sine(a, b, c, d);
  EXPECT_NEAR(std::abs(sine), std::sin(angle), 1e-12);
  EXPECT_NEAR(air_mesh::least_dihedral_sine(b, a, c, d), -sine, 1e-12);
}

TEST(TetShape, LeastSineIsThatOfTheAngles) {
  // Corners of no symmetry: the least sine is the least over the six angles.
  const Vec3 a{0, 0, 0}, b{2, 0.1, 0}, c{0.3, 1.4, 0.2}, d{0.5, 0.4, 0.9};
  const auto range = air_mesh::dihedral_range(a, b, c, d);
  const double expected =
      std::min(std::sin(range.least * pi / 180.0), std::sin(range.greatest * pi / 180.0));
  EXPECT_NEAR(air_mesh::least_dihedral_sine(a, b, c, d), expected, 1e-12);
}

TEST(ImproveTets, MovesAnInnerVertexToTheMiddle) {
  // An octahedron around a vertex that lies all but on one of its faces.
  TetMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},         {0, -1, 0},
                   {0, 0, 1}, {0, 0, -1}, {0.31, 0.32, 0.33}};
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        Tet t{x, y, z, 6};
        if (tet_volume(mesh.vertices[std::size_t(x)], mesh.vertices[std::size_t(y)],
                       mesh.vertices[std::size_t(z)], mesh.vertices[6]) < 0.0)
          std::swap(t[0], t[1]);
        mesh.tets.push_back(t);
      }
  detail::improve_tets(mesh, 6, 40.0);
  double volume = 0.0;
  for (const Tet& t : mesh.tets) {
    const auto at = [&](std::size_t i) { return mesh.vertices[std::size_t(t[i])]; };
    EXPECT_GT(air_mesh::dihedral_range(at(0), at(1), at(2), at(3)).least, 35.0);
    volume += tet_volume(at(0), at(1), at(2), at(3));
  }
  EXPECT_NEAR(volume, 4.0 / 3.0, 1e-12);
}

}  // namespace
}  // namespace angio::meshing
