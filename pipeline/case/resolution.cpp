#include "pipeline/case/resolution.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "formats/files.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

namespace angio::pipeline {

namespace {

constexpr const char* kVolume = "segmentation/volume.nrrd";
constexpr const char* kSurface = "segmentation/lumen_surface.vtp";

}  // namespace

std::vector<std::string> resolution_files() { return {kVolume, kSurface}; }

Resolution resolution_of(const Volume<float>& volume) {
  // Between inside and outside a scan has shades of grey, a label map nothing: it shows half as
  // much.
  constexpr double kLabelVoxels = 2.0;
  const Vec3 spacing = volume.geometry.spacing;
  const double voxels = segmentation::is_label_map(volume) ? kLabelVoxels : 1.0;
  Resolution resolution;
  resolution.longest_mm = voxels * std::max({spacing.x, spacing.y, spacing.z});
  resolution.mean_mm = voxels * std::cbrt(spacing.x * spacing.y * spacing.z);
  return resolution;
}

Resolution case_resolution(const StageFiles& files) {
  Resolution resolution;
  if (files.exists(kVolume)) {
    resolution = resolution_of(segmentation::read_volume_file(files.path(kVolume)));
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
  const auto middle = edges.begin() + std::ptrdiff_t(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return kEdges * *middle;
}

}  // namespace angio::pipeline
