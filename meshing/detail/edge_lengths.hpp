#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// Lets wanted lengths grow by a fifth of the way only, so that neighbouring triangles are alike.
void limit_growth(const TriangleMesh& mesh, std::vector<double>& lengths);

/// Wanted edge lengths: 2 pi r / edges_per_circumference with r from the nearest line, lengthened
/// evenly where the triangle budget asks for it.
///
/// @param least_length  [mm] no shorter edges than this
void set_edge_lengths(SurfaceDraft& draft, const CenterlineTree& tree,
                      const LumenMeshOptions& options, double least_length,
                      std::vector<std::string>& warnings);

}  // namespace angio::meshing::detail
