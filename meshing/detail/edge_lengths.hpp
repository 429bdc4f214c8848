#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// Mean length of the edges at each vertex [mm], shape [vertex_count].
std::vector<double> mean_edge_lengths(const TriangleMesh& mesh);

/// Lets wanted lengths grow by a fifth of the way only, so that neighbouring triangles are alike.
void limit_growth(const TriangleMesh& mesh, std::vector<double>& lengths);

/// Wanted edge lengths: 2 pi r / edges_per_circumference, where r is the nearest line's radius or
/// the surface's own radius of curvature if that is less; lengthened evenly where the triangle
/// budget asks for it.
///
/// @param least_length  [mm] no shorter edges than this
void set_edge_lengths(SurfaceDraft& draft, const SurfaceTarget& target, const CenterlineTree& tree,
                      const LumenMeshOptions& options, double least_length,
                      std::vector<std::string>& warnings);

/// The larger principal curvature of the target at a point, without its sign [1/mm].
///
///     S = P (dn/dx) P in the tangent plane, by central differences over 2 step
double greatest_curvature(const SurfaceTarget& target, const Vec3& point, double step);

}  // namespace angio::meshing::detail
