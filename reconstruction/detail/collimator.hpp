#pragma once

#include <optional>
#include <vector>

#include "reconstruction/reconstruction.hpp"

/// Collimators that no header names.
namespace angio::reconstruction::detail {

/// The part of a picture that no collimator covers, less its blurred edge: a leaf lies along a side
/// of the picture, lets less than half of the beam through (or is painted over with more than
/// twice of it), and ends in a straight line.
/// @param picture  line integrals, shape [rows, columns]
OpenField open_field(const std::vector<float>& picture, int columns, int rows);

/// The same of a rotational run, where the leaves stand still and the patient turns: a leaf's edge
/// is a step of the mean over frames, 0.3 or more darker outwards (semi-transparent filters, too),
/// that lies in a straight line along a side.
/// @param run  its pictures alone are looked at, not its masks
/// @return none: no side has a leaf
std::optional<OpenField> open_field(const RotationalRun& run);

}  // namespace angio::reconstruction::detail
