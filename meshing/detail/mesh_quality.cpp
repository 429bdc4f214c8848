#include "meshing/detail/mesh_quality.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.hpp"

namespace angio::meshing::detail {
namespace {

/// @param part  in [0, 1]
double percentile(std::vector<double> values, double part) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void measure_angles(const SurfaceDraft& draft, LumenQuality& quality) {
  std::vector<double> angles;
  quality.min_angle_degrees = quality.min_angle_off_rims_degrees = 180.0;
  for (const Triangle& t : draft.mesh.triangles) {
    const double angle = least_angle_degrees(draft.mesh.vertices[std::size_t(t[0])],
                                             draft.mesh.vertices[std::size_t(t[1])],
                                             draft.mesh.vertices[std::size_t(t[2])]);
    const bool at_rim =
        std::any_of(t.begin(), t.end(), [&](int v) { return draft.rim[std::size_t(v)] >= 0; });
    angles.push_back(angle);
    quality.min_angle_degrees = std::min(quality.min_angle_degrees, angle);
    if (!at_rim)
      quality.min_angle_off_rims_degrees = std::min(quality.min_angle_off_rims_degrees, angle);
    if (angle < 20.0) ++(at_rim ? quality.below_20_degrees_at_rims : quality.below_20_degrees);
    ++quality.angle_histogram[std::min<std::size_t>(std::size_t(angle / 5.0),
                                                    quality.angle_histogram.size() - 1)];
  }
  quality.angle_percentile_1_degrees = percentile(angles, 0.01);
  quality.angle_median_degrees = percentile(angles, 0.5);
}

void measure_edges(const TriangleMesh& mesh, LumenQuality& quality) {
  std::vector<double> lengths;
  for (const auto& [a, b] : unique_edges(mesh))
    lengths.push_back(distance(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)]));
  if (lengths.empty()) return;
  quality.edge_mean_mm =
      std::accumulate(lengths.begin(), lengths.end(), 0.0) / double(lengths.size());
  const auto [least, greatest] = std::minmax_element(lengths.begin(), lengths.end());
  quality.edge_min_mm = *least;
  quality.edge_max_mm = *greatest;
}

void measure_distances(const TriangleMesh& mesh, const SurfaceTarget& target,
                       LumenQuality& quality) {
  const std::size_t vertex_count = mesh.vertices.size();
  std::vector<double> signed_distance(vertex_count + mesh.triangles.size());
  parallel_for(std::ptrdiff_t(signed_distance.size()), [&](std::ptrdiff_t index) {
    const auto i = std::size_t(index);
    Vec3 place = i < vertex_count ? mesh.vertices[i] : Vec3{};
    if (i >= vertex_count)
      for (const int v : mesh.triangles[i - vertex_count])
        place += mesh.vertices[std::size_t(v)] / 3.0;
    signed_distance[i] = target.evaluate(place).signed_distance;
  });
  double between = 0.0;  // corners 1/12 each, middle 3/4: exact for quadratics
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    double mean = 0.75 * signed_distance[vertex_count + t];
    for (const int v : mesh.triangles[t]) mean += signed_distance[std::size_t(v)] / 12.0;
    between += 0.5 * norm(area_vector_doubled(mesh, mesh.triangles[t])) * mean;
  }
  quality.volume_change_mm3 = between;
  for (double& d : signed_distance) d = std::abs(d);
  quality.distance_mean_mm = std::accumulate(signed_distance.begin(), signed_distance.end(), 0.0) /
                             double(signed_distance.size());
  quality.distance_percentile_95_mm = percentile(signed_distance, 0.95);
  quality.distance_max_mm = percentile(signed_distance, 1.0);
}

}  // namespace

LumenQuality measure_quality(const SurfaceDraft& draft, const SurfaceTarget& target) {
  LumenQuality quality;
  quality.triangle_count = int(draft.mesh.triangles.size());
  quality.vertex_count = int(draft.mesh.vertices.size());
  quality.area_mm2 = surface_area(draft.mesh);
  measure_angles(draft, quality);
  measure_edges(draft.mesh, quality);
  measure_distances(draft.mesh, target, quality);
  return quality;
}

void set_volume(LumenQuality& quality, const TriangleMesh& capped) {
  quality.volume_mm3 = enclosed_volume(capped);
  quality.volume_change_percent = 100.0 * quality.volume_change_mm3 / quality.volume_mm3;
}

}  // namespace angio::meshing::detail
