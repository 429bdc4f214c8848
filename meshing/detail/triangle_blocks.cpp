#include "meshing/detail/triangle_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace angio::meshing::detail {
namespace {

constexpr std::size_t kRun = 8;  // triangles of a box, boxes of the next level's

/// The ten lowest bits of a number, each followed by two zeros.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 16U) & 0x030000FFU;
  x = (x | x << 8U) & 0x0300F00FU;
  x = (x | x << 4U) & 0x030C30C3U;
  return (x | x << 2U) & 0x09249249U;
}

/// Triangles by the Morton code of their first corner.
std::vector<int> along_curve(const TriangleMesh& mesh) {
  constexpr double kCells = 1023.0;
  if (mesh.triangles.empty()) return {};
  const auto place = [&](const Triangle& t) { return mesh.vertices[std::size_t(t[0])]; };
  Vec3 low = place(mesh.triangles.front()), high = low;
  for (const Triangle& t : mesh.triangles)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], place(t)[axis]);
      high[axis] = std::max(high[axis], place(t)[axis]);
    }
  const double side = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  const double scale = side > 0.0 ? kCells / side : 0.0;
  std::vector<std::uint64_t> keys;
  keys.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis)
      code |= spread_bits(std::uint64_t(scale * (place(mesh.triangles[t])[axis] - low[axis])))
              << unsigned(axis);
    keys.push_back(code << 32U | t);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<int> order;
  order.reserve(keys.size());
  for (const std::uint64_t key : keys) order.push_back(int(key & 0xffffffffU));
  return order;
}

/// How many runs there are of so many things.
std::size_t run_count(std::size_t count) { return (count + kRun - 1) / kRun; }

/// The bounds of what is added.
struct Bounds {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
};

}  // namespace

TriangleBlocks::TriangleBlocks(const TriangleMesh& mesh) : triangles_(along_curve(mesh)) {
  const auto add_level = [&](std::size_t count, const auto& add_to) {
    std::vector<Box> boxes(run_count(count));
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      Bounds bounds;
      for (std::size_t i = b * kRun; i < std::min((b + 1) * kRun, count); ++i) add_to(bounds, i);
      boxes[b] = {0.5 * (bounds.low + bounds.high), 0.5 * (bounds.high - bounds.low)};
    }
    levels_.push_back(std::move(boxes));
  };
  add_level(triangles_.size(), [&](Bounds& bounds, std::size_t i) {
    for (const int v : mesh.triangles[std::size_t(triangles_[i])])
      bounds.add(mesh.vertices[std::size_t(v)]);
  });
  while (levels_.back().size() > 1) {
    const std::vector<Box> below = levels_.back();
    add_level(below.size(), [&](Bounds& bounds, std::size_t i) {
      bounds.add(below[i].middle - below[i].half);
      bounds.add(below[i].middle + below[i].half);
    });
  }
}

std::vector<int> TriangleBlocks::near_cut(const Plane& plane, const Ball& ball) const {
  std::vector<int> found;
  if (!triangles_.empty()) add_near_cut(levels_.size() - 1, 0, plane, ball, found);
  return found;
}

void TriangleBlocks::add_near_cut(std::size_t level, std::size_t block, const Plane& plane,
                                  const Ball& ball, std::vector<int>& found) const {
  constexpr double kRounding = 1.0 + 1e-9;
  const Box& box = levels_[level][block];
  double reach = 2e-8, squared = 0.0;  // of the box from the plane [mm], from the ball's middle
  for (int axis = 0; axis < 3; ++axis) {
    reach += kRounding * std::abs(plane.normal[axis]) * box.half[axis];
    const double off = std::abs(ball.middle[axis] - box.middle[axis]) - kRounding * box.half[axis];
    if (off > 0.0) squared += off * off;
  }
  if (std::abs(plane.signed_distance(box.middle)) > reach ||
      squared > kRounding * ball.radius * ball.radius)
    return;
  const std::size_t first = block * kRun;
  if (level == 0) {
    const std::size_t end = std::min(first + kRun, triangles_.size());
    found.insert(found.end(), triangles_.begin() + std::ptrdiff_t(first),
                 triangles_.begin() + std::ptrdiff_t(end));
    return;
  }
  const std::size_t end = std::min(first + kRun, levels_[level - 1].size());
  for (std::size_t b = first; b < end; ++b) add_near_cut(level - 1, b, plane, ball, found);
}

}  // namespace angio::meshing::detail
