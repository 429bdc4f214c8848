#pragma once

#include <optional>
#include <vector>

#include "centerline/detail/lumen_voxels.hpp"

namespace angio::centerline {

/// Least-cost paths from a source voxel to all others.
struct Front {
  std::vector<double> cost;    ///< of the least-cost path [1/mm], shape [voxel]; infinite: cut off
  std::vector<double> length;  ///< of the least-cost path [mm], shape [voxel]; infinite: cut off
  std::vector<int> previous;   ///< voxel before this one on its path; -1 at the source
};

/// Paths in the middle of the vessel: least integral of ds / depth^2 (Dijkstra on linked voxels).
///
/// The cost of VMTK's minimal paths is 1/depth; the square keeps closer to the middle in bends and
/// makes shortcuts along the wall dearer. Lengths are those of these paths: the shortest paths
/// would run along the inner wall of a wide bend, where its end is hardly farther than its outer
/// wall half way round.
Front march(const LumenVoxels& lumen, int source);

/// The same where links have been cut since: only what was reached over them is reached anew.
void march_round_cuts(const LumenVoxels& lumen, Front& front);

/// The voxels of the least path from the source to `target`, source first.
std::vector<int> trace(const Front& front, int target);

/// An end of the lumen as seen from a source.
struct LumenEnd {
  int voxel = -1;
  double prominence = 0.0;  ///< length [mm] from where it joins a longer branch to its tip
  bool at_loop_cut = false;
  bool is_meeting = false;          ///< of two ways round a loop that is not cut there: no inlet
  std::optional<Vec3> middle = {};  ///< where its line ends [mm]; none: where the voxels lead
  std::optional<double> tube_radius = {};  ///< [mm]; of a short branch that is a tube
};

/// The ends of the lumen: the maxima of the path length from the source, each with its prominence.
///
/// The voxels from which the farthest neighbours lead to one maximum are its basin. Basins are
/// joined at the saddles between them, the farthest first; where two pieces meet, the one with the
/// lower maximum ends: its prominence is the fall from its maximum to there (0-dimensional
/// persistence; Edelsbrunner, Letscher, Zomorodian 2002). For a side branch that is its length from
/// the flow divider to its tip, whatever the shape of its wall.
///
/// @param least_prominence  [mm]; lower maxima are left out
/// @return the most prominent first; the farthest voxel has its whole length as prominence
std::vector<LumenEnd> find_maxima(const LumenVoxels& lumen, const Front& front,
                                  double least_prominence);

/// Finds loops of vessels and cuts the lumen there, so that every stretch of a loop gets an end.
///
/// What the paths to the ends do not run through, though it is long and hangs on to them at two
/// places or more, is the other way round a loop. It is cut off where it was reached last; where
/// the paths take a bridge instead, over which two stretches of vessel touch, the bridge is cut.
///
/// @param paths  voxel paths from the source to the ends
/// @return the voxels next to a cut
std::vector<int> cut_loops(LumenVoxels& lumen, const Front& lengths,
                           const std::vector<std::vector<int>>& paths);

/// The vessel's radius behind a tip: the greatest depth on the way back, until the way is longer
/// than the vessel is wide.
double radius_behind(const LumenVoxels& lumen, const Front& front, int tip);

/// A tip is no end where two ways round a loop meet: then the voxels beside it were reached from
/// elsewhere (four radii back more than two radii from the tip's own path).
/// @return a voxel beside the tip on the other way; nothing: it is an end
std::optional<int> meeting_front(const LumenVoxels& lumen, const Front& front, int tip);

/// Cuts the bridge on one of the two ways that meet at a tip, if there is one.
/// @param met  from meeting_front
/// @return the voxels next to the cut; none: both ways are vessels
std::vector<int> cut_bridge_behind(LumenVoxels& lumen, const Front& front, int tip, int met);

}  // namespace angio::centerline
