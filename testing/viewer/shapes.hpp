#pragma once

#include "core/centerline.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "testing/temporary_folder.hpp"

/// Small shapes with known answers.
namespace angio::viewer::test {

/// A closed unit cube, outward normals, 8 vertices and 12 triangles, moved by `offset`.
TriangleMesh make_cube(const Vec3& offset = {});

/// An open tube about the z axis from z = 0; radius(z) = radius_mm (1 - depth exp(-((z - middle) /
/// 3 mm)^2)), bent towards x by `bend_mm` in its middle.
struct TubeShape {
  double radius_mm = 1.5;
  double length_mm = 30.0;
  double depth = 0.6;  ///< of the stenosis, [0, 1); 0 is a straight tube
  double bend_mm = 3.0;
  int ring_count = 61;
  int ring_vertex_count = 24;

  [[nodiscard]] double radius_at(double z) const;
  [[nodiscard]] Vec3 center_at(double z) const;
};
TriangleMesh make_tube(const TubeShape& shape);

/// A closed capsule on the tube's line between z0 and z1, of a radius smaller than the lumen's.
TriangleMesh make_balloon(const TubeShape& shape, double z0, double z1, double radius_mm);

CenterlinePath make_path(const TubeShape& shape);

/// 300 inside the tube, 40 outside, and the signed distance [mm] (negative inside), 0.5 mm voxels.
struct TubeVolumes {
  Volume<float> volume;
  Volume<float> level_set;
};
TubeVolumes make_volumes(const TubeShape& shape);

using angio::test::TemporaryFolder;

}  // namespace angio::viewer::test
