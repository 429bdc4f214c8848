#pragma once

#include <gtest/gtest.h>

#include "core/surface_rims.hpp"
#include "meshing/meshing.hpp"

namespace angio::meshing {

/// @param id  as in InletOutletId
inline Vec3 cap_centre(const LumenMesh& lumen, int id) {
  for (const SurfaceRim& rim : surface_rims(lumen.open))
    if (lumen.inlet_outlet_id[std::size_t(rim.loop[0])] == id) return rim.centre;
  ADD_FAILURE() << "no cap has the id " << id;
  return {};
}

}  // namespace angio::meshing
