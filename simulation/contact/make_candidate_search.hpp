#pragma once

#include <bit>
#include <vector>

#include "simulation/contact/candidate_finder.hpp"
#include "simulation/contact/candidate_search.hpp"
#include "simulation/step/bounded_motion.hpp"

/// From a scene to the arrays of a search, in the computer's memory; `Memory` as in make_views.hpp.
namespace angio::simulation::detail {

/// A body's surface, or its line of segments.
struct BodyPrimitives {
  Body body;
  std::vector<Primitive> of_corners[3];  ///< vertices, edges, triangles
};

template <class Corners>
void add_primitive(const Corners& corners, std::vector<Primitive>& primitives) {
  Primitive primitive;
  primitive.corners = int(corners.size());
  primitive.index = int(primitives.size());
  for (std::size_t i = 0; i < 3; ++i)
    primitive.vertex[i] = corners[std::min(i, corners.size() - 1)];
  primitives.push_back(primitive);
}

inline BodyPrimitives primitives_of(const Scene& scene, Body body) {
  BodyPrimitives out{body, {}};
  const BodyRange& range = scene.bodies[body];
  for (int v = range.first; v < range.end(); ++v) add_primitive(std::array{v}, out.of_corners[0]);
  if (body == Body::guidewire) {
    for (int v = range.first + 1; v < range.end(); ++v)
      add_primitive(Edge{v - 1, v}, out.of_corners[1]);
    return out;
  }
  const bool wall = body == Body::wall;
  for (const Edge& e : wall ? scene.wall.edges : scene.balloon.edges)
    add_primitive(e, out.of_corners[1]);
  for (const Triangle& t : wall ? scene.wall.triangles : scene.balloon.triangles)
    add_primitive(t, out.of_corners[2]);
  return out;
}

/// What faces what, as CandidateFinder has it: each of `asked` corners looks for items of `sought`.
struct FacingBodies {
  Body asks, sought;
  int asked_corners, sought_corners;
  bool item_first = false, self = false, shaft = false;
};

inline std::vector<FacingBodies> facing_bodies(const Scene& scene, bool of_wall) {
  const Body balloon = Body::balloon, wall = Body::wall, wire = Body::guidewire;
  std::vector<FacingBodies> all;
  if (of_wall && scene.bodies.wall().count > 0)
    all.insert(all.end(),
               {{wall, balloon, 1, 3}, {wall, balloon, 3, 1, true}, {wall, balloon, 2, 2, true}});
  if (scene.rod.count > 0)
    all.insert(all.end(), {{balloon, wire, 1, 2, false, false, true},
                           {balloon, wire, 2, 2, false, false, true},
                           {balloon, wire, 3, 1, true, false, true}});
  for (const Body surface : {balloon, wall})
    if (scene.self_distance > 0.0 && scene.bodies[surface].count > 0)
      all.insert(all.end(),
                 {{surface, surface, 1, 3, false, true}, {surface, surface, 2, 2, false, true}});
  return all;
}

/// Without what lies in the step's arrays (x to status), and without room for candidates.
///
/// @param frames  that a set of candidates should last
template <class Real, class Memory>
CandidateSearch<Real> make_candidate_search(const Scene& scene, const SimulationOptions& options,
                                            int frames, Memory& memory) {
  CandidateSearch<Real> view;
  const double distance = options.contact.distance_mm, self = scene.self_distance;
  const double move = most_move(scene.balloon.has_folds, self) * distance;
  const double reach = self > 0.0 ? 2.0 * (move + kSelfSlack * distance) : kMostReach * distance;
  view.rules = {frames, distance, contact_range(options), self, scene.rod.radius, move, reach};
  view.bodies = scene.bodies;
  view.vertex_count = scene.vertex_count();
  view.dt = Real(options.frame_s);
  std::vector<BodyPrimitives> primitives;
  for (int b = 0; b < kBodyCount; ++b) primitives.push_back(primitives_of(scene, Body(b)));
  const auto those = [&](Body body, int corners) -> const std::vector<Primitive>& {
    return primitives[std::size_t(body)].of_corners[corners - 1];
  };
  std::vector<SearchItem> items;
  std::vector<SearchQuery> queries;
  std::vector<char> has_kind(kPrimitiveKinds, 0);
  int family = 0;
  for (const FacingBodies& f : facing_bodies(scene, !pbd_policy(options).contact)) {
    const int kind = primitive_kind(f.sought, f.sought_corners);
    view.families[family] = {kind, f.item_first, f.self, f.shaft};
    for (const Primitive& p : those(f.asks, f.asked_corners)) queries.push_back({p, family});
    ++family;
    if (has_kind[std::size_t(kind)]++ > 0) continue;
    for (const Primitive& p : those(f.sought, f.sought_corners)) items.push_back({p, kind});
  }
  view.item_count = int(items.size());
  view.query_count = int(queries.size());
  view.bucket_count = int(std::bit_ceil(4 * items.size() + 1));
  view.items = memory.store(std::move(items));
  view.queries = memory.store(std::move(queries));
  view.start = memory.store(scene.start);
  view.fixed = memory.store(scene.fixed);
  const auto count = std::size_t(view.vertex_count);
  view.measures = memory.template allocate<SearchMeasures>(1);
  view.counts = memory.template allocate<int>(std::size_t(view.zero_count()));
  view.next = memory.template allocate<int>(std::size_t(view.item_count));
  view.cells = memory.template allocate<ItemCell>(std::size_t(view.item_count));
  view.owned_begin = memory.template allocate<int>(count + 1);
  view.ref_begin = memory.template allocate<int>(count + 1);
  view.x_found = memory.template allocate<Vec3T<Real>>(count);
  view.radii = memory.template allocate<SearchRadii<Real>>(1);
  return view;
}

/// As a step takes it.
template <class Real>
CandidateView<Real> shown(const CandidateSearch<Real>& search) {
  return {search.capacity, search.list,    search.owned_begin, search.ref_begin,
          search.refs,     search.x_found, search.radii};
}

}  // namespace angio::simulation::detail
