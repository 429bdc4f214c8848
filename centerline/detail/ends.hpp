#pragma once

#include <optional>
#include <vector>

#include "centerline/detail/fronts.hpp"
#include "centerline/detail/lumen_voxels.hpp"
#include "centerline/detail/openings.hpp"
#include "core/progress.hpp"

/// Which of the lumen's tips are ends of vessels.
namespace angio::centerline {

struct Ends {
  std::vector<LumenEnd> ends;
  std::vector<LumenEnd> sacs;  ///< stand out like branches, but end without an outlet
  Front front;                 ///< from the source, behind the last cut
  std::vector<int> loop_cuts;  ///< a voxel next to each round's first cut
};

/// An open rim of the piece that is followed.
struct Rim {
  int voxel = -1;  ///< in its middle
  OpenRim opening;
};

/// The ends seen from `source`, spurs left out, loops cut.
/// @param flat_ends  each of them is an end, however short its vessel
/// @param min_length  of a branch [mm]; 0: by its shape
/// @param near_cut  1 for the voxels next to a cut so far, shape [voxel]
Ends find_ends(LumenVoxels& lumen, int source, const std::vector<OpenRim>& flat_ends,
               double min_length, std::vector<char>& near_cut, const Progress& progress);

/// Adds the ends that are seen from another source only: a wide end beside a long branch hardly
/// stands out when it is looked at from that branch. Tips no farther apart than the vessel is wide
/// are one end.
void add_missing(const LumenVoxels& lumen, const Ends& others, int source, Ends& ends);

/// Adds the round sections in which the border of the volume cuts vessels across, where no end is
/// known within three radii: of a wide vessel that a long branch leaves beside the border nothing
/// stands out. A vessel of four voxels or more; a cut along a vessel is not round.
void add_border_sections(const LumenVoxels& lumen, int source, Ends& ends);

/// Makes every rim an end, and no end of what else stands out but long vessels; a tip that lies on
/// a rim is that rim's. Where fewer vessels end in caps than in tips, or fewer than half as many in
/// open rims, as where a closed surface has two holes, a tip counts if its vessel is longer than
/// wide.
/// @param are_caps  the rims are those of a closed surface's caps
/// @param closed  gets the tips of vessels that end without a rim
void take_rims(const LumenVoxels& lumen, const std::vector<Rim>& rims, bool are_caps, int source,
               Ends& ends, std::vector<int>& closed);

/// The middle of the flat end that a tip lies on, if it does [mm].
std::optional<Vec3> flat_end_at(const LumenVoxels& lumen, const std::vector<OpenRim>& flat_ends,
                                int tip);

}  // namespace angio::centerline
