#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// A direction and how steeply it leaves the flattest of some planes.
struct Outward {
  Vec3 direction;     ///< unit
  double rise = 0.0;  ///< least cosine to the planes' normals; <= 0: nothing leaves them all
};

/// The direction with the greatest least cosine to some unit normals: the axis of the narrowest
/// cone that holds them, found exactly.
///
/// Source: Aubry, Loehner, Commun. Numer. Methods Eng. 24 (2008) 1641 ("most normal normal")
Outward most_normal(const std::vector<Vec3>& normals);

/// A way of the same length that rises from every plane by `least_rise` at least, or as steeply as
/// any way does: turned towards `outward` no further than that needs.
Vec3 risen(const Vec3& way, const std::vector<Vec3>& normals, const Outward& outward,
           double least_rise);

/// Unit normals of the triangles around each vertex.
std::vector<std::vector<Vec3>> normals_around_vertices(const TriangleMesh& mesh);

}  // namespace angio::meshing::detail
