#pragma once

#include "simulation/step/parting_plane.hpp"

/// The step's contact: near pairs, their forces, and how far a vertex may go.
///
/// Contact is found on two levels. Candidates, all primitives that face each other nearer than the
/// search radius, are found every few frames. A search among them names the near pairs and bounds
/// each vertex's motion until the next search:
///
///  - it may not pass a plane across the gap of any of its near pairs; the planes of a pair's two
///    sides are 0.1 of the gap apart, and never less than the least gap, far above rounding: no gap
///    becomes smaller;
///  - it may not go further than its `max_move`, which follows from its speed; a pair is near where
///    its gap is less than the range of what acts on it and the moves of its two sides, so that
///    pairs that are not near stay out of contact;
///  - a search counts only while what the balloon's vertices have moved since the candidates were
///    found with what they may go, at most, and the same of the wall's, are together less than
///    search radius - range: then all near pairs are among them.
///
/// So no motion within the bounds takes one surface through the other, at any step of the sweeps.
/// Source: Chen et al., "Offset Geometric Contact", ACM TOG 44 (2025), section 3.4 (bounds by 0.45
/// of the distance); here with a plane across the gap instead of a ball, so that sliding and
/// parting are free.
namespace angio::simulation::detail {

/// Both sides together may use up twice this share of a gap before the next search.
inline constexpr double kShareOfGap = 0.45;

template <class Real>
ANGIO_HOST_DEVICE inline Real abs_of(Real x) {
  return x < Real(0) ? -x : x;
}

/// The gap that motions leave, as a share of the contact distance; and between two parts of one
/// surface, as a share of the gap below which they push: nothing presses as hard on a wall's ridge
/// as the two sides of the ridge, and a normal must be known across an edge.
inline constexpr double kLeastGap = 0.005, kSelfLeastGap = 0.05;

/// What pairs stand for, so that two surfaces that lie on each other count once: the points of
/// either surface for half its area each, less a tenth that the edge pairs stand for. Two meshes of
/// edges h and k on each other have (2 / pi) (2 sqrt 3 / h) (2 sqrt 3 / k) crossings per area
/// (Buffon), faded out by the squared sine of their angle, 2/3 in the mean: hence a tenth is
/// 0.02 |e_a| |e_b| for each, whatever the two sizes.
inline constexpr double kEdgesOfArea = 0.1, kEdgeShare = 0.02;

/// The gap below which something may act on a candidate or pair before the next frame: films hold
/// wet vertices to triangles, and a vertex gets wet within the first gap.
template <class Real, class Primitives>
ANGIO_HOST_DEVICE inline Real range_of(const StepView<Real>& s, const Primitives& c) {
  if (c.self) return Real(c.distance);
  if (c.edges || c.shaft || !s.contact.wet) return s.contact.law.distance;
  if (s.contact.wet[c.vertex[0]]) return s.contact.law.range;
  return s.contact.law.adhesion.gap_1 > s.contact.law.distance ? s.contact.law.adhesion.gap_1
                                                               : s.contact.law.distance;
}

/// What a pair of the shaft stands for: of a vertex's area, of the square of an edge's length, of a
/// triangle's area. The three count the shaft once to twice.
inline constexpr double kShaftVertex = 0.5, kShaftEdge = 0.15, kShaftFace = 0.25;

/// The area that a candidate of the shaft stands for; p from its first vertex.
template <class Real>
ANGIO_HOST_DEVICE inline Real shaft_area(const StepView<Real>& s, const Candidate& candidate,
                                         const Vec3T<Real> (&p)[4]) {
  if (candidate.edges) return Real(kShaftEdge) * norm_squared(p[1]);
  if (candidate.vertex[2] == candidate.vertex[3])
    return Real(kShaftVertex) * s.motion.area[candidate.vertex[0]];
  return Real(0.5 * kShaftFace) * norm(cross(p[2] - p[1], p[3] - p[1]));
}

/// A vertex's colour on its surface; those that do not move have none, -1.
template <class Real>
ANGIO_HOST_DEVICE inline int color_of(const StepView<Real>& s, int v) {
  const MeshView& mesh = mesh_around(s, v);
  if (v >= mesh.color_begin[mesh.colors]) return -1;
  int color = 0;
  while (v >= mesh.color_begin[color + 1]) ++color;
  return color;
}

/// Finds the corners of a pair's two sides that move at the same time.
template <class Real>
ANGIO_HOST_DEVICE inline void find_twins(const StepView<Real>& s, NearPair<Real>& pair) {
  const int side_a = pair.edges ? 2 : 1;
  for (int i = 0; i < 4; ++i) pair.twin[i] = -1;
  for (int i = 0; i < side_a; ++i) {
    const int color = color_of(s, pair.vertex[i]);
    for (int k = side_a; k < 4 && color >= 0; ++k) {
      if (color_of(s, pair.vertex[k]) != color) continue;
      pair.twin[i] = short(k);
      pair.twin[k] = short(i);
    }
  }
}

/// What no plane parts does not move until the next search.
inline constexpr double kNoMotion = -1.0;

/// A candidate at the present positions. @return false if a plane proves that it is not nearer than
/// `search_radius`
template <class Real>
ANGIO_HOST_DEVICE inline bool approach(const StepView<Real>& s, const Candidate& candidate,
                                       Real search_radius, NearPair<Real>& pair) {
  const Vec3T<Real> base = s.motion.x[candidate.vertex[0]];
  Vec3T<Real> p[4];  // from the first vertex
  for (int i = 1; i < 4; ++i) p[i] = s.motion.x[candidate.vertex[i]] - base;
  const PartingPlane<Real> plane = parting_plane(candidate, p);
  const Real gap = plane.gap - Real(candidate.radius);
  if (!(gap < search_radius)) return false;
  pair.edges = candidate.edges;
  pair.shaft = candidate.shaft;
  pair.self = candidate.self;
  pair.radius = Real(candidate.radius);
  pair.distance = candidate.self ? Real(candidate.distance) : s.contact.law.distance;
  pair.gap_searched = gap;
  pair.normal = plane.normal;
  pair.area = candidate.shaft ? shaft_area(s, candidate, p)
              : candidate.edges
                  ? Real(kEdgeShare) * norm(p[1]) * norm(p[3] - p[2])
                  : Real(0.5) * Real(1.0 - kEdgesOfArea) * s.motion.area[candidate.vertex[0]];
  const int side_a = candidate.edges ? 2 : 1;
  const Real least =
      pair.self ? Real(kSelfLeastGap) * pair.distance : Real(kLeastGap) * s.contact.law.distance;
  const Real spare = Real(0.5) * (gap - least);
  const Real share = Real(kShareOfGap) * gap < spare ? Real(kShareOfGap) * gap : spare;
  for (int i = 0; i < 4; ++i) {
    pair.vertex[i] = candidate.vertex[i];
    const Real beyond = i < side_a ? plane.height[i] - plane.low_a : plane.high_b - plane.height[i];
    const Real limit = beyond + share;
    pair.limit[i] = !(plane.gap > Real(0)) ? Real(kNoMotion) : limit > Real(0) ? limit : Real(0);
  }
  if (pair.self) find_twins(s, pair);
  return true;
}

/// By how much the gap of a candidate or pair may close when each vertex moves so far [mm].
template <class Real, class Primitives>
ANGIO_HOST_DEVICE inline Real closed_by(const Real* by, const Primitives& c) {
  Real a = by[c.vertex[0]], b = by[c.vertex[3]];
  for (int i = 1; i < 3; ++i) {
    Real& side = c.edges && i == 1 ? a : b;
    const Real other = by[c.vertex[i]];
    side = other > side ? other : side;
  }
  return a + b;
}
/// The same by what they have moved; a thousandth for rounding.
template <class Real, class Primitives>
ANGIO_HOST_DEVICE inline Real closed_at_most(const StepView<Real>& s, const Primitives& c) {
  return Real(1.001) * closed_by(s.contact.near.moved, c);
}

/// The gap with which a candidate that a vertex is in may have been found, at most, if it is near
/// now: a candidate's other vertices of a side are around the first.
///
/// @param most  of `moved`, for each body
template <class Real>
ANGIO_HOST_DEVICE inline Real found_gap_around(const StepView<Real>& s, int v,
                                               const Real (&most)[kBodyCount]) {
  const Real* moved = s.contact.near.moved;
  const Body body = s.bodies.of(v);
  Real around = most[int(body)];
  if (body != Body::guidewire) {
    const MeshView& mesh = mesh_around(s, v);
    around = moved[v];
    for (int c = mesh.corner_begin[v - mesh.first]; c < mesh.corner_begin[v - mesh.first + 1];
         ++c) {
      const Real next = moved[mesh.corners[c].next], last = moved[mesh.corners[c].last];
      around = next > around ? next : around;
      around = last > around ? last : around;
    }
  }
  const ContactLaw<Real>& law = s.contact.law;
  const Real others = law.range + Real(1.001) * (around + most_of_others(most, body));
  const Real self = law.self_distance + Real(1.001) * (around + most[int(body)]);
  return law.self_distance > Real(0) && self > others ? self : others;
}

/// Names the near ones of the candidates that a vertex owns, in their order. `moved` holds how
/// far a vertex has moved since they were found plus how far it may still move.
///
/// @param found_gap  candidates that were found with this gap or a larger one are not near by now
/// @return their number
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline int search_owned(const StepView<Real>& s, int v, Real found_gap,
                                          const Lanes& lanes) {
  const int first = s.contact.candidates.owned_begin[v],
            last = s.contact.candidates.owned_begin[v + 1];
  int end = first;
  // By ascending gap.
  for (int round = first; round < last && Real(s.contact.candidates.list[round].gap) < found_gap;
       round += lanes.size()) {
    const int c = round + lanes.rank();
    NearPair<Real> pair;
    const Real range = c < last ? range_of(s, s.contact.candidates.list[c]) : Real(0);
    const bool near =
        c < last &&
        Real(s.contact.candidates.list[c].gap) - closed_at_most(s, s.contact.candidates.list[c]) <
            range &&
        approach(s, s.contact.candidates.list[c],
                 range + closed_by(s.contact.near.max_move, s.contact.candidates.list[c]), pair);
    const int place = end + lanes.before(near);
    if (c < last && s.contact.near.pair_of) s.contact.near.pair_of[c] = near ? place : -1;
    if (near) s.contact.near.pairs[place] = pair;
    end += lanes.sum(near ? 1 : 0);
  }
  if (lanes.rank() == 0) s.contact.near.owned_end[v] = end;
  return end - first;
}

/// Lists a vertex's near pairs, and the planes among them that it can reach at all.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void list_pairs(const StepView<Real>& s, int v, Real found_gap,
                                         const Lanes& lanes) {
  const int first = s.contact.candidates.ref_begin[v], last = s.contact.candidates.ref_begin[v + 1];
  int refs = first, bounds = first;
  const auto may_be_named = [&](int r) {
    return r < last &&
           Real(s.contact.candidates.list[s.contact.candidates.refs[r].pair].gap) < found_gap;
  };
  for (int round = first; may_be_named(round); round += lanes.size()) {  // by ascending gap
    const int r = round + lanes.rank();
    const int index =
        may_be_named(r) ? s.contact.near.pair_of[s.contact.candidates.refs[r].pair] : -1;
    const int corner = index < 0 ? 0 : s.contact.candidates.refs[r].corner;
    const bool binds =
        index >= 0 && s.contact.near.pairs[index].limit[corner] < s.contact.near.max_move[v];
    const int place = refs + lanes.before(index >= 0), plane = bounds + lanes.before(binds);
    if (index >= 0) s.contact.near.refs[place] = {index, corner};
    if (binds) {
      const NearPair<Real>& pair = s.contact.near.pairs[index];
      const bool side_a = corner < (pair.edges ? 2 : 1);
      s.contact.near.bounds[plane] = {side_a ? pair.normal : -pair.normal, pair.limit[corner]};
    }
    refs += lanes.sum(index >= 0 ? 1 : 0);
    bounds += lanes.sum(binds ? 1 : 0);
  }
  if (lanes.rank() > 0) return;
  s.contact.near.ref_end[v] = refs;
  s.contact.near.bound_end[v] = bounds;
}

/// The same of all vertices, by one thread, from the near pairs that the owners have named: far
/// quicker than looking through each vertex's candidates, where threads are few.
template <class Real>
inline void list_pairs_at_once(const StepView<Real>& s) {
  const int count = s.bodies.contact_count();
  const auto for_corners = [&](const auto& body) {
    for (int i = 0; i < count; ++i) {
      const int owner = s.bodies.contact_vertex(i);
      for (int p = s.contact.candidates.owned_begin[owner]; p < s.contact.near.owned_end[owner];
           ++p)
        for (int corner = 0; corner < 4; ++corner)
          body(p, corner, s.contact.near.pairs[p].vertex[corner]);
    }
  };
  for (int i = 0; i < count; ++i) s.contact.near.ref_end[s.bodies.contact_vertex(i)] = 0;
  for_corners([&](int, int, int v) { ++s.contact.near.ref_end[v]; });
  for (int i = 0, end = 0; i < count; ++i) {
    const int v = s.bodies.contact_vertex(i);
    s.contact.near.listed_begin[v] = s.contact.near.bound_end[v] = end;
    end += s.contact.near.ref_end[v];
    s.contact.near.ref_end[v] = s.contact.near.listed_begin[v];
  }
  for_corners([&](int p, int corner, int v) {
    const NearPair<Real>& pair = s.contact.near.pairs[p];
    s.contact.near.refs[s.contact.near.ref_end[v]++] = {p, corner};
    if (!(pair.limit[corner] < s.contact.near.max_move[v])) return;
    const bool side_a = corner < (pair.edges ? 2 : 1);
    s.contact.near.bounds[s.contact.near.bound_end[v]++] = {side_a ? pair.normal : -pair.normal,
                                                            pair.limit[corner]};
  });
}

}  // namespace angio::simulation::detail
