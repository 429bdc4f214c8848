#include "viewer/detail/plane.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace angio::viewer::detail {

PlaneWindow::Pixel PlaneWindow::pixel_of(const Vec3& point, int pixels) const {
  const double per_mm = 0.5 * pixels / half_size_mm;
  const double middle = 0.5 * (pixels - 1);
  return {middle + per_mm * dot(point - center, right),
          middle + per_mm * dot(point - center, down)};
}

Vec3 PlaneWindow::point_of(double x, double y, int pixels) const {
  const double mm = 2.0 * half_size_mm / pixels;
  const double middle = 0.5 * (pixels - 1);
  return center + (mm * (x - middle)) * right + (mm * (y - middle)) * down;
}

std::vector<Segment> cut(const TriangleMesh& mesh, const Vec3& origin, const Vec3& normal) {
  std::vector<double> height(mesh.vertices.size());
  for (std::size_t v = 0; v < height.size(); ++v)
    height[v] = dot(mesh.vertices[v] - origin, normal);
  std::vector<Segment> segments;
  for (const Triangle& triangle : mesh.triangles) {
    // A height of zero counts as above, so that a corner on the plane is met once, not twice.
    Segment segment;
    std::size_t count = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto a = std::size_t(triangle[c]);
      const auto b = std::size_t(triangle[(c + 1) % 3]);
      if ((height[a] < 0.0) == (height[b] < 0.0)) continue;
      const double t = height[a] / (height[a] - height[b]);
      segment[count++] = mesh.vertices[a] + t * (mesh.vertices[b] - mesh.vertices[a]);
    }
    if (count == 2) segments.push_back(segment);
  }
  return segments;
}

float sample_point(const Volume<float>& volume, const Vec3& point, float outside) {
  const VolumeGeometry& grid = volume.geometry;
  const Vec3 index = grid.index_from_lps(point);
  const bool is_inside = index.x >= -0.5 && index.y >= -0.5 && index.z >= -0.5 &&
                         index.x <= grid.size[0] - 0.5 && index.y <= grid.size[1] - 0.5 &&
                         index.z <= grid.size[2] - 0.5;
  return is_inside ? float(interpolate(volume, point)) : outside;
}

std::vector<float> sample_plane(const Volume<float>& volume, const PlaneWindow& window, int pixels,
                                float outside) {
  std::vector<float> values;
  values.reserve(std::size_t(pixels) * std::size_t(pixels));
  for (int y = 0; y < pixels; ++y)
    for (int x = 0; x < pixels; ++x)
      values.push_back(sample_point(volume, window.point_of(x, y, pixels), outside));
  return values;
}

float percentile(std::vector<float> values, double fraction) {
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return 0.0f;
  const auto rank = std::ptrdiff_t(std::llround(fraction * double(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[std::size_t(rank)];
}

float lowest(const std::vector<float>& values) {
  float least = std::numeric_limits<float>::infinity();
  for (const float value : values)
    if (std::isfinite(value)) least = std::min(least, value);
  return std::isfinite(least) ? least : 0.0f;
}

}  // namespace angio::viewer::detail
