#include "datasets/detail/fine_surface.hpp"

#include <algorithm>

#include "datasets/detail/lumen_surface.hpp"

namespace angio::datasets::detail {
namespace {

constexpr int kVerticesPerRing = 48;
constexpr int kFiner = 3;  ///< facets leave the wall by a ninth

/// Whether rings across the axis can be stacked: they are parallel.
bool is_straight(const Branch& branch) {
  const auto end = [&](int sample) { return branch.center[std::size_t(sample)]; };
  const Vec3 chord = normalized(end(branch.last_sample) - end(branch.first_sample));
  return dot(chord, branch.tangent(branch.first_sample)) > 1.0 - 1e-9 &&
         dot(chord, branch.tangent(branch.last_sample)) > 1.0 - 1e-9;
}

/// @param finer  1, or how many times finer
TriangleMesh surface(const LumenShape& shape, double radius_mm, int finer) {
  if (shape.branches().size() == 1 && is_straight(shape.branches().front()))
    return tube_surface(shape, finer * kVerticesPerRing);
  // Fine enough for the narrowest place and for the gap at a carina, but within reason.
  double cell = std::min(0.16 * radius_mm, shape.least_radius_mm() / 1.3);
  for (const Branch& branch : shape.branches())
    if (branch.parent >= 0) cell = std::min(cell, 0.35 * branch.blend_mm);
  cell = std::max(cell, 0.04 * radius_mm);
  return tree_surface(shape, finer == 1 ? cell : std::min(cell, 0.16 * radius_mm / finer));
}

}  // namespace

TriangleMesh usual_surface(const LumenShape& shape, double radius_mm) {
  return surface(shape, radius_mm, 1);
}

TriangleMesh fine_surface(const LumenShape& shape, double radius_mm) {
  return surface(shape, radius_mm, kFiner);
}

}  // namespace angio::datasets::detail
