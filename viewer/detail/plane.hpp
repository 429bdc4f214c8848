#pragma once

#include <array>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

/// Plane sections of volumes and surfaces.
namespace angio::viewer::detail {

/// A square piece of a plane, seen as a picture.
struct PlaneWindow {
  Vec3 center;                 ///< LPS [mm]
  Vec3 right{1, 0, 0};         ///< unit
  Vec3 down{0, 1, 0};          ///< unit, at right angles to right
  double half_size_mm = 10.0;  ///< shown to each side, > 0

  /// Pixel coordinates of a point's foot on the plane; the middle of the first pixel is (0, 0).
  struct Pixel {
    double x = 0.0;
    double y = 0.0;
  };
  [[nodiscard]] Pixel pixel_of(const Vec3& point, int pixels) const;
  [[nodiscard]] Vec3 point_of(double x, double y, int pixels) const;
};

using Segment = std::array<Vec3, 2>;

/// Where a surface meets a plane. A triangle that lies in the plane gives nothing.
///
/// @param normal  unit
std::vector<Segment> cut(const TriangleMesh& mesh, const Vec3& origin, const Vec3& normal);

/// The volume at a point by trilinear interpolation; outside the volume, the given value.
float sample_point(const Volume<float>& volume, const Vec3& point, float outside);

/// The volume on the plane by trilinear interpolation, rows from the top, shape [pixels, pixels];
/// outside the volume, the given value.
std::vector<float> sample_plane(const Volume<float>& volume, const PlaneWindow& window, int pixels,
                                float outside);

/// The value below which `fraction` of the finite values lie; 0 if there is none.
float percentile(std::vector<float> values, double fraction);

/// The least finite value; 0 if there is none.
float lowest(const std::vector<float>& values);

}  // namespace angio::viewer::detail
