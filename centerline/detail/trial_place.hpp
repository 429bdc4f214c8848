#pragma once

#include "centerline/detail/dip.hpp"

/// Where a balloon is tried in a vessel without a certain stenosis.
namespace angio::centerline {

/// Where no stenosis is certain, a vessel that is thinner than its tree makes it over a long
/// stretch is that thin by itself (behind a wide root, say): the reference is no more than the
/// median of its own diameters within three diameters of the reference and five of its own.
/// A short piece of vessel, which a lesion may fill, says nothing of that.
ReferenceDiameter no_wider_than_around(const Known& known);

/// The tightest place, relative to the reference, that leaves room for a balloon on both sides, in
/// a vessel that balloons are made for, and a diameter away from branchings, if there is one;
/// rather not in a bend of more than 45 degrees along two diameters, where a balloon kinks.
/// @param min_reference_mm  of a vessel that balloons are made for [mm]
Lesion tightest_place(const Known& known, double min_reference_mm);

}  // namespace angio::centerline
