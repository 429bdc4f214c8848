#include "pipeline/case/resolution.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/statistics.hpp"
#include "formats/files.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {

namespace {

constexpr const char* kVolume = "segmentation/volume.nrrd";
constexpr const char* kSurface = "segmentation/lumen_surface.vtp";

}  // namespace

std::vector<std::string> resolution_files() { return {kVolume, kSurface}; }

Resolution case_resolution(const StageFiles& files) {
  Resolution resolution;
  if (files.exists(kVolume)) {
    const Vec3 spacing = segmentation::read_volume_file(files.path(kVolume)).geometry.spacing;
    resolution.longest_mm = std::max({spacing.x, spacing.y, spacing.z});
    resolution.mean_mm = std::cbrt(spacing.x * spacing.y * spacing.z);
  } else if (files.exists(kSurface)) {
    resolution.surface =
        std::make_shared<const TriangleMesh>(formats::read_surface(files.path(kSurface)).mesh);
  }
  return resolution;
}

centerline::LesionOptions lesion_options(centerline::LesionOptions options,
                                         const Resolution& resolution) {
  options.voxel_mm = resolution.mean_mm;
  if (resolution.surface)
    options.least_diameter_mm = [surface = resolution.surface](const Vec3& place, double reach) {
      return least_diameter_shown(*surface, place, reach);
    };
  return options;
}

centerline::LesionOptions whole_tree(centerline::LesionOptions options) {
  options.centerline = -1;
  options.abscissa_mm = -1.0;
  return options;
}

double least_diameter_shown(const TriangleMesh& surface, const Vec3& place, double reach) {
  constexpr double kEdges = 2.0;
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
  if (edges.empty()) return kEdges * nearest_edge;
  return kEdges * median(std::move(edges));
}

}  // namespace angio::pipeline
