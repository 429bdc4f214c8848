#include "centerline/resolution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "centerline/detail/lattice.hpp"

namespace angio::centerline {

Resolution resolution_of_voxels(const Vec3& spacing) {
  Resolution resolution;
  resolution.longest_mm = std::max({spacing.x, spacing.y, spacing.z});
  resolution.mean_mm = std::cbrt(spacing.x * spacing.y * spacing.z);
  return resolution;
}

Resolution resolution_of_labels(const Vec3& spacing) { return resolution_of_voxels(2.0 * spacing); }

Resolution resolution_of_surface(TriangleMesh surface) {
  Resolution resolution;
  if (const std::optional<detail::Lattice> voxels = detail::find_lattice(surface))
    resolution = voxels->is_of_blocks ? resolution_of_labels(voxels->spacing)
                                      : resolution_of_voxels(voxels->spacing);
  resolution.surface = std::make_shared<const TriangleMesh>(std::move(surface));
  return resolution;
}

bool is_unmeasured(const Lesion& lesion, const CenterlinePath& path, const Resolution& resolution) {
  if (lesion.mld_mm < resolution.longest_mm) return true;
  const double reach = 0.5 * lesion.reference_diameter_mm;
  return std::any_of(resolution.narrow_lps_mm.begin(), resolution.narrow_lps_mm.end(),
                     [&](const Vec3& place) {
                       const double at = project(path, place);
                       return at >= lesion.proximal_mm - reach && at <= lesion.distal_mm + reach &&
                              distance(sample(path, at).point, place) <= reach;
                     });
}

LesionOptions lesion_options(LesionOptions options, const Resolution& resolution) {
  options.voxel_mm = resolution.mean_mm;
  if (resolution.surface)
    options.edge_mm = [surface = resolution.surface](const Vec3& place, double reach) {
      return edge_around(*surface, place, reach);
    };
  if (resolution.scan)
    options.intensity = [scan = resolution.scan](const Vec3& place) {
      return interpolate(*scan, place);
    };
  return options;
}

LesionOptions whole_tree(LesionOptions options) {
  options.centerline = -1;
  options.abscissa_mm = -1.0;
  return options;
}

double edge_around(const TriangleMesh& surface, const Vec3& place, double reach) {
  std::vector<double> edges;
  double nearest = std::numeric_limits<double>::max(), nearest_edge = 0.0;
  for (const Triangle& t : surface.triangles) {
    const Vec3 &a = surface.vertices[std::size_t(t[0])], &b = surface.vertices[std::size_t(t[1])],
               &c = surface.vertices[std::size_t(t[2])];
    const double away = distance((a + b + c) / 3.0, place);
    if (away > reach && away >= nearest) continue;
    const double edge = (distance(a, b) + distance(b, c) + distance(c, a)) / 3.0;
    if (away <= reach) edges.push_back(edge);
    if (away < nearest) {
      nearest = away;
      nearest_edge = edge;
    }
  }
  if (edges.empty()) return nearest_edge;
  const auto middle = edges.begin() + std::ptrdiff_t(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return *middle;
}

}  // namespace angio::centerline
