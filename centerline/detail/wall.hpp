#pragma once

#include <vector>

#include "core/vec3.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

/// The wall of a lumen as seen from inside: what a level set and a surface have in common.
class Wall {
 public:
  virtual ~Wall() = default;
  /// Distance [mm] from a point inside to the wall along a unit direction, at most `longest`;
  /// 0 when the point is outside.
  [[nodiscard]] virtual double ray(const Vec3& from, const Vec3& direction,
                                   double longest) const = 0;
  [[nodiscard]] virtual bool inside(const Vec3& point) const = 0;
  /// How far from a point the data end, not the lumen (the border of the volume) [mm]; below zero
  /// beyond it.
  [[nodiscard]] virtual double depth_in_data(const Vec3& point) const = 0;
  [[nodiscard]] bool beyond_data(const Vec3& point) const { return depth_in_data(point) < 0.0; }
  /// The detail the data can show [mm].
  [[nodiscard]] virtual double resolution() const = 0;
};

/// The zero surface of a level set, negative inside: found on the trilinear interpolant, refined on
/// the tricubic (Catmull-Rom) one. The trilinear interpolant of a distance to an axis is too high
/// by about h^2 / (12 r), which would make a tube of 2.5 voxels' radius 1.3 % too thin.
class LevelSetWall final : public Wall {
 public:
  explicit LevelSetWall(const Volume<float>& level_set);
  [[nodiscard]] double ray(const Vec3& from, const Vec3& direction, double longest) const override;
  [[nodiscard]] bool inside(const Vec3& point) const override;
  [[nodiscard]] double depth_in_data(const Vec3& point) const override;
  [[nodiscard]] double resolution() const override { return step_; }

 private:
  [[nodiscard]] double linear(const Vec3& index) const;
  [[nodiscard]] double cubic(const Vec3& index) const;

  const Volume<float>& level_set_;
  double step_;
};

}  // namespace angio::centerline
