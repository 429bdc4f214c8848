#pragma once

#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "meshing/detail/level_band.hpp"

namespace angio::meshing::detail {

/// The part of a level set around its negative voxels, with one layer of positive voxels added on
/// every side, so that a vessel that leaves the volume is closed at the border.
///
/// @throws InputError if no voxel is negative
Volume<float> pad_level_set(const Volume<float>& level_set);

/// The zero surface of a level set by marching tetrahedra (six to a cell, Kuhn's subdivision).
///
/// Every tetrahedron has one planar cut at most and neighbours agree on shared faces, so the
/// surface is manifold, without self-intersection, and closed where the border layer is positive.
/// Its triangles are badly shaped: it is where remeshing starts.
///
/// Source: Doi, Koide, "An efficient method of triangulating equi-valued surfaces by using
///         tetrahedral cells", IEICE Trans. E74 (1991). Departure: a crossing is kept a
///         tenth away from the ends of its edge, so no triangle is tiny.
/// @param level_set  negative inside [mm]
/// @return in LPS [mm]; normals point to the positive side
TriangleMesh extract_isosurface(const Volume<float>& level_set);

/// The same, of a level set that is known beside its zero surface only.
TriangleMesh extract_isosurface(const LevelBand& band);

}  // namespace angio::meshing::detail
