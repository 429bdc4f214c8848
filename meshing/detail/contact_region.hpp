#pragma once

#include "core/centerline.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing::detail {

/// The stretch of a path whose wall is wanted.
struct RegionExtent {
  const CenterlinePath* path = nullptr;
  double first_abscissa = 0.0;  ///< [mm] the section at each end
  double last_abscissa = 0.0;
};

/// The wall between two sections of a path, and side branches up to a section about one diameter
/// past their mouths.
///
/// Source: the seed paper's section 4.1, steps 1 and 2 (sections, signed distance to them, and
/// propagation over the connectivity), generalised: any number of branches; each section counts
/// only near itself, so that it does not cut other vessels.
/// @param seeds  points of the path between the sections; propagation starts at the wall's vertices
///               nearest to them
/// @throws InputError if the wall there is not one connected piece
ContactRegion extract_region(const TriangleMesh& open_lumen, const CenterlineTree& tree,
                             const RegionExtent& extent, const std::vector<Vec3>& seeds);

/// The part of a region that some of its triangles make; vertices keep their data.
ContactRegion with_triangles(const ContactRegion& region, const std::vector<Triangle>& triangles);

}  // namespace angio::meshing::detail
