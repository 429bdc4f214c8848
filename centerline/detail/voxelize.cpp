#include <algorithm>
#include <cmath>
#include <utility>

#include "centerline/detail/surface_wall.hpp"

namespace angio::centerline {

// Ericson, Real-Time Collision Detection, 5.1.5.
double distance_squared(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return norm_squared(ap);
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return norm_squared(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return norm_squared(ap - (d1 / (d1 - d3)) * ab);
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return norm_squared(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return norm_squared(ap - (d2 / (d2 - d6)) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return norm_squared(bp - ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b));
  const double sum = va + vb + vc;
  return norm_squared(ap - (vb / sum) * ab - (vc / sum) * ac);
}

namespace {

VolumeGeometry grid_of(const TriangleMesh& mesh, double spacing) {
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& p : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  VolumeGeometry grid;
  grid.spacing = {spacing, spacing, spacing};
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[std::size_t(axis)] = int((high[axis] - low[axis]) / spacing) + 7;
    grid.origin[axis] = low[axis] - 3.0 * spacing;
  }
  return grid;
}

/// Crossings of the grid's rows along i with the surface: +1 going in, -1 going out.
using Crossing = std::pair<float, int>;
std::vector<std::vector<Crossing>> find_crossings(const TriangleMesh& mesh,
                                                  const VolumeGeometry& grid) {
  std::vector<std::vector<Crossing>> rows(std::size_t(grid.size[1]) * std::size_t(grid.size[2]));
  // Rows are moved off the grid by a little, so that none meets a vertex or an edge in common
  // meshes, whose coordinates lie on the grid by chance.
  constexpr double kOffY = 1.234567e-4, kOffZ = 2.718281e-4;
  for (const Triangle& t : mesh.triangles) {
    Vec3 p[3];
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = grid.index_from_lps(mesh.vertices[std::size_t(t[c])]);
      p[c].y -= kOffY;
      p[c].z -= kOffZ;
    }
    const double twice_area =
        (p[1].y - p[0].y) * (p[2].z - p[0].z) - (p[1].z - p[0].z) * (p[2].y - p[0].y);
    if (twice_area == 0.0) continue;
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    const auto [z0, z1] = std::minmax({p[0].z, p[1].z, p[2].z});
    for (int k = std::max(0, int(std::ceil(z0))); k <= std::min(int(z1), grid.size[2] - 1); ++k)
      for (int j = std::max(0, int(std::ceil(y0))); j <= std::min(int(y1), grid.size[1] - 1); ++j) {
        double w[3];
        for (int c = 0; c < 3; ++c) {
          const Vec3 &a = p[(c + 1) % 3], &b = p[(c + 2) % 3];
          w[c] = ((a.y - j) * (b.z - k) - (a.z - k) * (b.y - j)) / twice_area;
        }
        if (w[0] < 0.0 || w[1] < 0.0 || w[2] < 0.0) continue;
        const double x = w[0] * p[0].x + w[1] * p[1].x + w[2] * p[2].x;
        // The normal's x component has the sign of twice_area; inward is against it.
        rows[std::size_t(k) * std::size_t(grid.size[1]) + std::size_t(j)].emplace_back(
            float(x), twice_area > 0.0 ? -1 : +1);
      }
  }
  return rows;
}

void set_signs(Volume<float>& level_set, std::vector<std::vector<Crossing>> rows) {
  const VolumeGeometry& grid = level_set.geometry;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j) {
      auto& row = rows[std::size_t(k) * std::size_t(grid.size[1]) + std::size_t(j)];
      if (row.empty()) continue;
      std::sort(row.begin(), row.end());
      int winding = 0;
      std::size_t next = 0;
      for (int i = 0; i < grid.size[0]; ++i) {
        while (next < row.size() && row[next].first <= float(i)) winding += row[next++].second;
        if (winding > 0) level_set.at(i, j, k) = -level_set.at(i, j, k);
      }
    }
}

}  // namespace

Volume<float> voxelize(const TriangleMesh& closed, double spacing_mm) {
  const VolumeGeometry grid = grid_of(closed, spacing_mm);
  const double band = 2.0 * spacing_mm;
  Volume<float> level_set(grid, float(band));
  for (const Triangle& t : closed.triangles) {
    const Vec3 &a = closed.vertices[std::size_t(t[0])], &b = closed.vertices[std::size_t(t[1])],
               &c = closed.vertices[std::size_t(t[2])];
    int low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      const auto [least, most] = std::minmax({a[axis], b[axis], c[axis]});
      low[axis] = std::max(0, int(std::ceil((least - band - grid.origin[axis]) / spacing_mm)));
      high[axis] = std::min(grid.size[std::size_t(axis)] - 1,
                            int(std::floor((most + band - grid.origin[axis]) / spacing_mm)));
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const Vec3 p = grid.lps_from_index({double(i), double(j), double(k)});
          float& value = level_set.at(i, j, k);
          value = std::min(value, float(std::sqrt(distance_squared(p, a, b, c))));
        }
  }
  set_signs(level_set, find_crossings(closed, grid));
  return level_set;
}

}  // namespace angio::centerline
