#pragma once

#include <vector>

#include "air_mesh/tet_topology.hpp"

/// Points in the air, between the surfaces.
///
/// Not every gap between two surfaces can be filled with tetrahedra over the surfaces' vertices
/// alone (Schoenhardt 1928): two coarse meshes that touch make such places. A point in the air that
/// sees the whole outside of a hollow fills it.
namespace angio::air_mesh {

/// The tets around a vertex, starting with one of them; only for vertices off the boundary.
std::vector<int> star_of(const TetTopology& air, int tet, int vertex);

/// The outer faces of a set of tets, directed so that (face, a point inside) is right-handed.
std::vector<Triangle> outside_of(const TetTopology& air, const std::vector<int>& tets);

/// The point that lies farthest inside all of the faces' planes, found from a guess by steps along
/// the normal of the nearest plane.
struct InnerPoint {
  Vec3 point;
  double height = 0.0;  ///< over the nearest plane [mm]; not positive: it does not see all faces
};
InnerPoint find_inner_point(const std::vector<Triangle>& faces, const std::vector<Vec3>& x,
                            const Vec3& guess);

/// A hollow whose outer faces a point all sees.
struct SeenHollow {
  std::vector<int> tets;  ///< empty: none was found
  Vec3 point;
};

/// Finds such hollows around some tets.
class HollowSearch {
 public:
  HollowSearch(const TetTopology& air, const std::vector<Vec3>& x, std::vector<int> seeds)
      : air_(air), x_(x), seeds_(std::move(seeds)), mark_(std::size_t(air.slot_count()), 0) {}

  /// The smallest one for a point: tets behind unseen faces are taken out until there are none, up
  /// to `most` tets. Where a face of the boundary is not seen the point is moved in front of it,
  /// some times.
  SeenHollow find(const Vec3& point, int most);

 private:
  bool grow(SeenHollow& hollow, int most, TetFace& unseen);

  const TetTopology& air_;
  const std::vector<Vec3>& x_;
  std::vector<int> seeds_, mark_;
  int stamp_ = 0;
};

/// Places where a point may see the outside of a hollow around some tets: in front of the
/// boundary's faces around them, and in the middle of the tets.
std::vector<Vec3> places_around(const TetTopology& air, const std::vector<Vec3>& x,
                                const std::vector<int>& tets);

}  // namespace angio::air_mesh
