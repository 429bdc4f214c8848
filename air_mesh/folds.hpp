#pragma once

#include <array>
#include <vector>

#include "air_mesh/tet_topology.hpp"

/// Where surfaces touch there is next to no air between them, and tets may be folded into each
/// other.
namespace angio::air_mesh {

/// What has to be left out of a mesh so that the rest covers no point twice.
struct Folds {
  std::vector<int> inverted;
  std::vector<int> overlapping;           ///< right-handed, over an inverted one
  std::vector<std::array<int, 2>> pairs;  ///< inverted, right-handed: which overlap
};

/// The outer faces of the mesh are surfaces that do not cross. So each point of the gap is covered
/// once more by right-handed tets than by inverted ones (the mesh has degree one there, and none
/// outside), and what is covered by two right-handed ones lies in an inverted one, too. Without the
/// inverted ones and all that overlap one, no two tets share a point, and none reaches out of the
/// gap.
///
/// Tets overlap unless a plane parts them to 1e-9 mm (separating axes: their faces' normals and the
/// cross products of their edges).
///
/// @param quality  by slot; not positive: inverted
Folds find_folds(const TetTopology& air, const std::vector<Vec3>& x,
                 const std::vector<double>& quality);

/// Adds to some tets all that hang together with a fold of theirs, by overlaps and faces.
///
/// @return ascending
std::vector<int> with_whole_folds(const TetTopology& air, const Folds& folds,
                                  std::vector<int> tets);

}  // namespace angio::air_mesh
