#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <tuple>

#include "meshing/detail/isosurface.hpp"
#include "meshing/detail/level_band.hpp"

namespace angio::meshing {
namespace {

using detail::GridRows;
using detail::LevelBand;
using Place = std::tuple<int, int, int>;  // i, j, k

Volume<float> random_signs(const std::array<int, 3>& size, double share, unsigned seed) {
  VolumeGeometry grid;
  grid.size = size;
  Volume<float> signs(grid, 1.0F);
  std::mt19937 random(seed);
  for (float& value : signs.values) value = double(random()) < share * 4294967296.0 ? -1.0F : 1.0F;
  return signs;
}

/// What lies in the runs of rows.
std::set<Place> places_in(const GridRows& runs, int size_j) {
  std::set<Place> places;
  for (std::size_t row = 0; row < runs.count(); ++row) {
    const auto ends = runs.entries(row);
    for (std::size_t e = 0; e + 1 < ends.size(); e += 2)
      for (int i = ends[e]; i < ends[e + 1]; ++i)
        places.emplace(i, int(runs.row[row] % size_j), int(runs.row[row] / size_j));
  }
  return places;
}

TEST(LevelBand, HoldsTheCrossedCellsAndTheirCornersOnly) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Volume<float> signs = random_signs({7, 5, 6}, 0.05 * seed, seed);
    const VolumeGeometry& grid = signs.geometry;
    std::set<Place> inside, cells, corners;
    for (int k = 0; k < 6; ++k)
      for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 7; ++i) {
          if (signs.at(i, j, k) < 0.0F) inside.emplace(i, j, k);
          if (i == 6 || j == 4 || k == 5) continue;
          int count = 0;
          for (int c = 0; c < 8; ++c)
            count += signs.at(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2)) < 0.0F ? 1 : 0;
          if (count == 0 || count == 8) continue;
          cells.emplace(i, j, k);
          for (int c = 0; c < 8; ++c)
            corners.emplace(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2));
        }
    const GridRows runs = detail::runs_inside(signs);
    EXPECT_EQ(places_in(runs, 5), inside);
    const LevelBand band = detail::band_around(grid, runs);
    EXPECT_EQ(places_in(band.cells, 5), cells);
    std::set<Place> nodes;
    for (std::size_t row = 0; row < band.nodes.count(); ++row)
      for (std::size_t n = band.nodes.first[row]; n < band.nodes.first[row + 1]; ++n) {
        const Place at{band.nodes.at[n], int(band.nodes.row[row] % 5),
                       int(band.nodes.row[row] / 5)};
        nodes.insert(at);
        EXPECT_EQ(band.level[n], signs.at(std::get<0>(at), std::get<1>(at), std::get<2>(at)));
      }
    EXPECT_EQ(nodes, corners);
    EXPECT_EQ(band.level.size(), corners.size());
  }
}

TEST(LevelBand, TheSurfaceOfAnySignsIsClosed) {
  Volume<float> signs = random_signs({12, 9, 10}, 0.4, 3);
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 9; ++j)
      for (int i = 0; i < 12; ++i)
        if (i % 11 == 0 || j % 8 == 0 || k % 9 == 0) signs.at(i, j, k) = 1.0F;
  EXPECT_TRUE(surface_topology(detail::extract_isosurface(signs)).is_closed());
}

TEST(LevelBand, GrowsWithTheSurfaceAndNotWithTheGrid) {
  VolumeGeometry grid;  // of 8e15 nodes, of which a rod along the diagonal is inside
  grid.size = {200000, 200000, 200000};
  GridRows runs;
  for (int n = 1; n < 1000; ++n)
    for (int side = 0; side < 2; ++side) {
      runs.at.insert(runs.at.end(), {200 * n, 200 * n + 3});
      runs.end_row(std::int64_t(200 * n) * grid.size[1] + 200 * n + side);
    }
  const LevelBand band = detail::band_around(grid, runs);
  EXPECT_EQ(band.nodes.at.size(), 999U * 5U * 4U * 3U);
  const TriangleMesh rods = detail::extract_isosurface(band);
  EXPECT_TRUE(surface_topology(rods).is_closed());
  EXPECT_EQ(surface_topology(rods).component_count, 999);
}

}  // namespace
}  // namespace angio::meshing
