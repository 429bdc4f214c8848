#include "angiogram/xray.hpp"

#include <algorithm>
#include <cmath>

#include "angiogram/triangle_pixels.hpp"
#include "core/error.hpp"

namespace angio::angiogram {
std::vector<double> chord_lengths(const TriangleMesh& mesh, const XrayFrame& frame) {
  if (!(frame.half_size_mm > 0.0) || frame.pixels < 1 || frame.pixels > 10000)
    throw InputError("an X-ray picture of that size cannot be made. Choose 1 to 10000 pixels");
  const CArmAxes axes = c_arm_axes(frame.angles);
  const double scale = 1.0 / frame.pixel_mm(), middle = 0.5 * (frame.pixels - 1);
  std::vector<detail::Corner> corners;
  corners.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 from = vertex - frame.center;
    corners.push_back({middle + scale * dot(from, axes.right), middle + scale * dot(from, axes.up),
                       dot(from, axes.to_detector), int(corners.size())});
  }
  std::vector<double> chords(std::size_t(frame.pixels) * std::size_t(frame.pixels), 0.0);
  for (const Triangle& t : mesh.triangles)
    detail::add_triangle(
        {corners[std::size_t(t[0])], corners[std::size_t(t[1])], corners[std::size_t(t[2])]},
        frame.pixels, frame.pixels, [](double depth) { return depth; }, chords);
  for (double& chord : chords) chord = std::max(chord, 0.0);
  return chords;
}

std::vector<double> transmissions(std::vector<double> chords_mm, double attenuation_per_mm) {
  for (double& value : chords_mm) value = std::exp(-attenuation_per_mm * value);
  return chords_mm;
}

TriangleMesh with_caps(TriangleMesh open) {
  for (const std::vector<int>& rim : boundary_loops(open)) {
    Vec3 middle;
    for (const int vertex : rim) middle += open.vertices[std::size_t(vertex)];
    const int tip = int(open.vertices.size());
    open.vertices.push_back((1.0 / double(rim.size())) * middle);
    for (std::size_t i = 0; i < rim.size(); ++i)
      open.triangles.push_back({rim[i], rim[(i + 1) % rim.size()], tip});
  }
  return open;
}

}  // namespace angio::angiogram
