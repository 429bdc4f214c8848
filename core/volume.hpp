#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/vec3.hpp"

namespace angio {

/// Where a voxel grid lies in the patient: lps = origin + direction * (spacing o index).
struct VolumeGeometry {
  std::array<int, 3> size{0, 0, 0};   ///< voxels along i, j, k
  Vec3 spacing{1.0, 1.0, 1.0};        ///< [mm], > 0, along i, j, k
  Vec3 origin;                        ///< centre of voxel (0, 0, 0), LPS [mm]
  Mat3 direction = Mat3::identity();  ///< columns are the unit axes i, j, k in LPS; det = +1

  /// The longest edge of a voxel [mm].
  [[nodiscard]] double longest_spacing() const {
    return std::max({spacing.x, spacing.y, spacing.z});
  }
  [[nodiscard]] std::size_t voxel_count() const {
    return std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]);
  }
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (std::size_t(k) * std::size_t(size[1]) + std::size_t(j)) * std::size_t(size[0]) +
           std::size_t(i);
  }
  [[nodiscard]] bool contains(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
  /// @param index  continuous voxel index; (0, 0, 0) is a voxel's centre
  [[nodiscard]] Vec3 lps_from_index(const Vec3& index) const {
    return origin + direction * Vec3{index.x * spacing.x, index.y * spacing.y, index.z * spacing.z};
  }
  [[nodiscard]] Vec3 index_from_lps(const Vec3& point_in_lps) const {
    const Vec3 d = transpose(direction) * (point_in_lps - origin);
    return {d.x / spacing.x, d.y / spacing.y, d.z / spacing.z};
  }
  friend bool operator==(const VolumeGeometry&, const VolumeGeometry&) = default;
};

/// A voxel grid in patient space; voxel (i, j, k) is values[geometry.offset(i, j, k)].
template <class Value>
struct Volume {
  VolumeGeometry geometry;
  std::vector<Value> values;  ///< shape [size k, size j, size i], i fastest

  Volume() = default;
  explicit Volume(const VolumeGeometry& grid, Value fill = Value{})
      : geometry(grid), values(grid.voxel_count(), fill) {}

  [[nodiscard]] Value& at(int i, int j, int k) { return values[geometry.offset(i, j, k)]; }
  [[nodiscard]] const Value& at(int i, int j, int k) const {
    return values[geometry.offset(i, j, k)];
  }
};

/// The value at a point by trilinear interpolation; outside, that of the nearest border point.
///
/// @param point_in_lps  [mm]
double interpolate(const Volume<float>& volume, const Vec3& point_in_lps);

/// The gradient [value/mm] in LPS of the trilinear interpolant smoothed over one voxel (central
/// differences half a voxel to each side).
Vec3 interpolate_gradient(const Volume<float>& volume, const Vec3& point_in_lps);

}  // namespace angio
