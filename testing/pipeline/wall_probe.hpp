#pragma once

#include <vtkImplicitPolyDataDistance.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <filesystem>

#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

namespace angio {

/// Where the wall of a case is, and on which side of it a point lies. The wall is what the lines
/// were made of: the surface as it was read, or the zero of the level set (VTK's contour of it);
/// distances are VTK's, exact on the triangles.
class WallProbe {
 public:
  /// @param folder  of the case. @throws InputError if it has neither surface nor level set
  explicit WallProbe(const std::filesystem::path& folder);
  [[nodiscard]] double to_wall(const Vec3& point) const;  ///< [mm], unsigned
  [[nodiscard]] bool is_inside(const Vec3& point) const;

 private:
  [[nodiscard]] double signed_distance(const Vec3& point) const;
  void set_surface(const TriangleMesh& mesh);

  Volume<float> level_set_;
  mutable vtkNew<vtkImplicitPolyDataDistance> distance_;
};

}  // namespace angio
