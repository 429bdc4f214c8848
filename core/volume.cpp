#include "core/volume.hpp"

#include <algorithm>
#include <cmath>

namespace angio {
namespace {

double interpolate_at_index(const Volume<float>& volume, const Vec3& index) {
  const VolumeGeometry& grid = volume.geometry;
  int base[3];
  double t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int last = grid.size[std::size_t(axis)] - 1;
    const double u = std::clamp(index[axis], 0.0, double(last));
    base[axis] = std::min(int(u), std::max(last - 1, 0));
    t[axis] = last > 0 ? u - base[axis] : 0.0;
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    int at[3];
    for (int axis = 0; axis < 3; ++axis) {
      const int up = (corner >> axis) & 1;
      weight *= up ? t[axis] : 1.0 - t[axis];
      at[axis] = std::min(base[axis] + up, grid.size[std::size_t(axis)] - 1);
    }
    if (weight > 0.0) sum += weight * double(volume.at(at[0], at[1], at[2]));
  }
  return sum;
}

}  // namespace

double interpolate(const Volume<float>& volume, const Vec3& point_in_lps) {
  return interpolate_at_index(volume, volume.geometry.index_from_lps(point_in_lps));
}

Vec3 interpolate_gradient(const Volume<float>& volume, const Vec3& point_in_lps) {
  const Vec3 index = volume.geometry.index_from_lps(point_in_lps);
  Vec3 gradient_ijk;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 before = index;
    Vec3 after = index;
    before[axis] -= 0.5;
    after[axis] += 0.5;
    gradient_ijk[axis] =
        (interpolate_at_index(volume, after) - interpolate_at_index(volume, before)) /
        volume.geometry.spacing[axis];
  }
  return volume.geometry.direction * gradient_ijk;
}

}  // namespace angio
