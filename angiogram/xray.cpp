#include "angiogram/xray.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/error.hpp"

namespace angio::angiogram {
namespace {

/// A corner as the detector has it: right and up in pixels, from the middle of the picture's lower
/// left pixel; depth towards the detector [mm].
struct Corner {
  double x = 0.0, y = 0.0, depth = 0.0;
  int vertex = 0;
};

/// Twice the area of a, b and the place; the same number, but for its sign, from both sides of an
/// edge.
double side(const Corner& a, const Corner& b, double x, double y) {
  const bool is_turned = a.vertex > b.vertex;
  const Corner& from = is_turned ? b : a;
  const Corner& to = is_turned ? a : b;
  const double value = (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x);
  return is_turned ? -value : value;
}

/// Whether the place, moved by (e, e^2), lies left of the edge.
bool is_left(const Corner& a, const Corner& b, double value) {
  if (value != 0.0) return value > 0.0;
  if (a.y != b.y) return b.y < a.y;
  return b.x > a.x;
}

void add_triangle(const std::array<Corner, 3>& corners, int pixels, std::vector<double>& chords) {
  const auto [a, b, c] = corners;
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (area == 0.0) return;  // seen edge on
  const auto first = [](double low) { return int(std::max(0.0, std::ceil(low))); };
  const auto last = [&](double high) { return int(std::min(pixels - 1.0, std::floor(high))); };
  const int x0 = first(std::min({a.x, b.x, c.x})), x1 = last(std::max({a.x, b.x, c.x}));
  const int y0 = first(std::min({a.y, b.y, c.y})), y1 = last(std::max({a.y, b.y, c.y}));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double ab = side(a, b, x, y), bc = side(b, c, x, y), ca = side(c, a, x, y);
      const bool left = is_left(a, b, ab);
      if (is_left(b, c, bc) != left || is_left(c, a, ca) != left) continue;
      const double depth = (bc * a.depth + ca * b.depth + ab * c.depth) / area;
      const auto row = std::size_t(pixels - 1 - y);
      // Counter-clockwise for the detector: here the ray leaves.
      chords[row * std::size_t(pixels) + std::size_t(x)] += left ? depth : -depth;
    }
}

}  // namespace

std::vector<double> chord_lengths(const TriangleMesh& mesh, const XrayFrame& frame) {
  if (!(frame.half_size_mm > 0.0) || frame.pixels < 1 || frame.pixels > 10000)
    throw InputError("an X-ray picture of that size cannot be made. Choose 1 to 10000 pixels");
  const CArmAxes axes = c_arm_axes(frame.angles);
  const double scale = 1.0 / frame.pixel_mm(), middle = 0.5 * (frame.pixels - 1);
  std::vector<Corner> corners;
  corners.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 from = vertex - frame.center;
    corners.push_back({middle + scale * dot(from, axes.right), middle + scale * dot(from, axes.up),
                       dot(from, axes.to_detector), int(corners.size())});
  }
  std::vector<double> chords(std::size_t(frame.pixels) * std::size_t(frame.pixels), 0.0);
  for (const Triangle& t : mesh.triangles)
    add_triangle(
        {corners[std::size_t(t[0])], corners[std::size_t(t[1])], corners[std::size_t(t[2])]},
        frame.pixels, chords);
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
