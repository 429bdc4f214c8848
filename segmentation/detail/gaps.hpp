#pragma once

#include <cstdint>
#include <vector>

#include "core/volume.hpp"

namespace angio::segmentation::detail {

/// Joins vessels that end towards each other: a stenosis that is too tight for the voxels to show
/// parts a vessel in two, and what lies behind it would be a tree of its own.
///
/// Of the places where pieces of a mask are nearest to each other, no farther than 1.5 diameters of
/// the thinner and 5 mm, a way is made where both end there in line with it. A piece ends at a
/// voxel if, of its voxels within a reach R of it, hardly one lies ahead, those of the first half
/// behind are together no wider than half of it (a vessel that passes by is as wide as R), nor
/// those of the second half, and these lie within 40 degrees of the gap's line. R grows from 5 mm
/// until it holds the vessel. One piece is no more than twice as wide as the other.
///
/// @param mask         a vessel's voxels are not 0; ways are set to `way`
/// @param least_mm3    of a piece [mm^3]
void join_across_gaps(Volume<std::uint8_t>& mask, std::uint8_t way, double least_mm3);

/// Parts vessels that pass each other: of two that lie closer than the voxels can show well, the
/// image between is a saddle, which looks like a thin vessel from flank to flank. Ways between two
/// pieces, none of which ends there (as above, but within 70 degrees: a branch may leave aslant),
/// are set to 0.
///
/// @param mask  as above; pieces are of what is neither 0 nor `way`
void part_passing_vessels(Volume<std::uint8_t>& mask, std::uint8_t way, double least_mm3);

}  // namespace angio::segmentation::detail
