#pragma once

#include <memory>
#include <string>

#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {

/// What a target knows of a point.
struct TargetSample {
  double signed_distance = 0.0;  ///< [mm], negative inside; right to first order near zero
  Vec3 normal;                   ///< unit vector that leaves the lumen
};

/// Where a remeshed surface has to lie: the zero of a signed distance.
class SurfaceTarget {
 public:
  virtual ~SurfaceTarget() = default;
  [[nodiscard]] virtual TargetSample evaluate(const Vec3& point) const = 0;
  /// What the lumen was found in, for people: "image" or "surface".
  [[nodiscard]] virtual std::string source() const { return "surface"; }

  /// A place of the target's level, and the normal there.
  struct Place {
    Vec3 point, normal;
  };
  /// The place of a given signed distance nearest to a point, by at most four Newton steps.
  [[nodiscard]] Place project(Vec3 point, double step_limit, double level = 0.0) const;
  /// The same within the plane through the point; the point itself where the surface runs along it.
  [[nodiscard]] Place project_in_plane(Vec3 point, const Vec3& plane_normal, double step_limit,
                                       double level = 0.0) const;
};

/// The zero of a level set that is tricubic between voxels (Catmull-Rom). A trilinear one cuts the
/// corners of a round vessel: at a radius of two voxels it would lose 4 % of the volume.
///
/// Source: Keys, "Cubic convolution interpolation for digital image processing", IEEE Trans. ASSP
///         29 (1981), Eq. 15 with a = -1/2
class LevelSetTarget final : public SurfaceTarget {
 public:
  explicit LevelSetTarget(const Volume<float>& level_set) : level_set_(level_set) {}
  [[nodiscard]] TargetSample evaluate(const Vec3& point) const override;
  [[nodiscard]] std::string source() const override { return "image"; }

 private:
  const Volume<float>& level_set_;
};

/// A triangle surface with interpolated normals.
class MeshTarget final : public SurfaceTarget {
 public:
  explicit MeshTarget(const TriangleMesh& mesh);
  [[nodiscard]] TargetSample evaluate(const Vec3& point) const override;

 private:
  [[nodiscard]] Vec3 normal_at(const ClosestPoint::Result& place) const;

  const TriangleMesh& mesh_;
  std::vector<Vec3> vertex_normals_;
  ClosestPoint closest_;
};

}  // namespace angio::meshing::detail
