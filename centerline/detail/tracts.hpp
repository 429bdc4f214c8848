#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"

namespace angio::centerline {

/// How many points two paths have in common from the inlet.
int count_shared(const CenterlinePath& a, const CenterlinePath& b);

/// Splits the lines of a tree into tracts and groups (CenterlineTract).
///
/// Where two lines part, each leaves the tube (union of spheres) of the other at some point; a
/// branching begins, on the shared part, one sphere upstream of the nearer of these points, and
/// ends on each line where it has left the tubes of all others and, within a diameter, its own
/// section is seen all round: in a mouth the line turns, and runs beside the middle. Branchings
/// that overlap are one.
///
/// Source: Antiga, Steinman, "Robust and objective decomposition and mapping of bifurcating
/// vessels", IEEE TMI 23(6), 2004, doi:10.1109/TMI.2004.826946, section II-B; VMTK's branch
/// extractor. Departure: lines that share their points up to a branching are not grouped by
/// distance, but by these points.
///
/// A stretch elsewhere without a section that was seen all round, longer than three radii, is no
/// tube (a sac, a chamber, vessels that touch): it is blanked, too. So is one as long that runs
/// along the border of the data, which cuts its vessel open.
///
/// @param is_tube  1: the section was seen, shape [path][point]
/// @param is_cut   1: the inscribed ball reaches beyond the data, same shape; empty: nowhere
/// @return a note for each such stretch
std::vector<std::string> assign_tracts(CenterlineTree& tree,
                                       const std::vector<std::vector<char>>& is_tube,
                                       const std::vector<std::vector<char>>& is_cut = {});

}  // namespace angio::centerline
