#pragma once

#include <string>
#include <vector>

#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// Puts a straight tube on every rim, along the normal of the rim's plane: it leaves the vessel in
/// the rim's shape, becomes round within one diameter, and ends in the new rim. An extension that
/// would cross the lumen is left out, with a warning.
///
/// @param diameters  length over the diameter of the rim's circle of equal area, lengthened to an
///                   edge of the rim, with a warning; 0: none
void extend_rims(SurfaceDraft& draft, double diameters, std::vector<std::string>& warnings);

}  // namespace angio::meshing::detail
