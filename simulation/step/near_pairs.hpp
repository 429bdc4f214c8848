#pragma once

#include "simulation/step/views.hpp"

/// The step's contact: near pairs, their forces, and how far a vertex may go.
///
/// Contact is found on two levels. The host lists candidates, all primitives that face each other
/// nearer than `candidate_reach`, rarely. A search among them, on the device, names the near pairs
/// and bounds each vertex's motion until the next search:
///
///  - it may not pass a plane across the gap of any of its near pairs; the planes of a pair's two
///    sides are 0.1 of the gap apart, and never less than the least gap, far above rounding: no gap
///    becomes smaller;
///  - it may not go further than its `travel`, which follows from its speed; a pair is near where
///    its gap is less than the range of what acts on it and the travel of its two sides, so that
///    pairs that are not near stay out of contact;
///  - a search counts only while what the balloon's vertices have gone since the candidates were
///    found with what they may go, at most, and the same of the wall's, are together less than
///    candidate_reach - contact_range: then all near pairs are among them.
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
inline constexpr double kLeastGap = 0.005, kOwnLeastGap = 0.05;

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
  if (c.skin) return Real(c.distance);
  if (c.edges || c.inner || !s.wet) return s.contact_distance;
  if (s.wet[c.vertex[0]]) return s.contact_range;
  return s.adhesion.gap_1 > s.contact_distance ? s.adhesion.gap_1 : s.contact_distance;
}

/// What an inner pair stands for: of a vertex's area, of the square of an edge's length, of a
/// triangle's area. The three count an inner surface once to twice.
inline constexpr double kInnerVertex = 0.5, kInnerEdge = 0.15, kInnerFace = 0.25;

/// The vertices that pairs may be of: those of the surfaces, then the guidewire's.
template <class Real>
ANGIO_HOST_DEVICE inline int contact_vertex_count(const StepView<Real>& s) {
  return s.balloon_count + s.wall_count + s.rod.shape.count;
}
template <class Real>
ANGIO_HOST_DEVICE inline int contact_vertex(const StepView<Real>& s, int i) {
  const int surfaces = s.balloon_count + s.wall_count;
  return i < surfaces ? i : s.rod.first + i - surfaces;
}

/// Weights of the closest points of a candidate or a pair.
template <class Pair, class Real>
ANGIO_HOST_DEVICE inline GapWeights<Real> closest_points(const Pair& pair,
                                                         const Vec3T<Real> (&p)[4]) {
  if (pair.edges) return segment_segment_gap(p[0], p[1], p[2], p[3]);
  return pair.vertex[2] == pair.vertex[3] ? point_segment_gap(p[0], p[1], p[2])
                                          : point_triangle_gap(p[0], p[1], p[2], p[3]);
}

/// The area that an inner candidate stands for; p from its first vertex.
template <class Real>
ANGIO_HOST_DEVICE inline Real inner_area(const StepView<Real>& s, const Candidate& candidate,
                                         const Vec3T<Real> (&p)[4]) {
  if (candidate.edges) return Real(kInnerEdge) * norm_squared(p[1]);
  if (candidate.vertex[2] == candidate.vertex[3])
    return Real(kInnerVertex) * s.area[candidate.vertex[0]];
  return Real(0.5 * kInnerFace) * norm(cross(p[2] - p[1], p[3] - p[1]));
}

/// A vertex's colour on its surface; those that do not move have none, -1.
template <class Real>
ANGIO_HOST_DEVICE inline int color_of(const StepView<Real>& s, int v) {
  const bool wall = v >= s.balloon_count;
  const int* begin = wall ? s.wall_color_begin : s.balloon_color_begin;
  if (v >= begin[wall ? s.wall_colors : s.balloon_colors]) return -1;
  int color = 0;
  while (v >= begin[color + 1]) ++color;
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

/// A plane between the two sides of a pair: along its unit normal side a lies above `low_a`, side b
/// below `high_b`.
template <class Real>
struct PartingPlane {
  Vec3T<Real> normal;  ///< from side b to side a; 0 where the two meet
  Real height[4]{};    ///< of the corners along it, from the first [mm]
  Real low_a{}, high_b{};
  Real distance{};  ///< of the closest points that were found: never less than the true one
  Real gap{};       ///< low_a - high_b, less its rounding: never more than the true distance
};

/// A pair's plane by its normal: what it proves does not depend on how the normal was found.
template <class Real, class Pair>
ANGIO_HOST_DEVICE inline PartingPlane<Real> plane_across(const Pair& pair, const Vec3T<Real>& gap,
                                                         const Vec3T<Real> (&p)[4]) {
  PartingPlane<Real> plane;
  plane.distance = norm(gap);
  plane.normal = plane.distance > Real(0) ? gap / plane.distance : Vec3T<Real>{};
  const int side_a = pair.edges ? 2 : 1;
  Real far = 0;
  for (int i = 0; i < 4; ++i) {
    const Real h = plane.height[i] = dot(plane.normal, p[i]), size = norm(p[i]);
    far = size > far ? size : far;
    if (i < side_a)
      plane.low_a = i == 0 || h < plane.low_a ? h : plane.low_a;
    else
      plane.high_b = i == side_a || h > plane.high_b ? h : plane.high_b;
  }
  plane.gap = plane.low_a - plane.high_b - Real(4) * kEpsilon<Real> * far;
  return plane;
}

template <class Real, class Pair>
ANGIO_HOST_DEVICE inline Vec3T<Real> gap_between(const Pair& pair, const Vec3T<Real> (&p)[4]) {
  const GapWeights<Real> weights = closest_points(pair, p);
  Vec3T<Real> gap;
  for (int i = 1; i < 4; ++i) gap += weights.w[i] * p[i];
  return gap;
}

/// A plane that proves less than this share of the distance found is looked for again.
inline constexpr double kSureShare = 0.9;

/// The plane across a pair's gap; p from its first vertex. The closest points of long edges that
/// lie along each other a tiny gap apart, or of slivers, drown in single precision: there they are
/// found in double precision, from the same positions.
template <class Real, class Pair>
ANGIO_HOST_DEVICE inline PartingPlane<Real> parting_plane(const Pair& pair,
                                                          const Vec3T<Real> (&p)[4]) {
  const PartingPlane<Real> plane = plane_across(pair, gap_between(pair, p), p);
  if (plane.gap >= Real(kSureShare) * plane.distance || sizeof(Real) >= sizeof(double))
    return plane;
  Vec3T<double> exact[4];
  for (int i = 1; i < 4; ++i) exact[i] = in_double(p[i]);
  const Vec3T<double> gap = gap_between(pair, exact);
  const double d = norm(gap);
  const Vec3T<double> unit = d > 0.0 ? gap / d : gap;  // before it is rounded
  PartingPlane<Real> again =
      plane_across(pair, Vec3T<Real>{Real(unit.x), Real(unit.y), Real(unit.z)}, p);
  again.distance = Real(d);
  return again.gap > plane.gap ? again : plane;
}

/// What no plane parts does not move until the next search.
inline constexpr double kNoMotion = -1.0;

/// A candidate at the present positions. @return false if a plane proves that it is not nearer than
/// `reach`
template <class Real>
ANGIO_HOST_DEVICE inline bool approach(const StepView<Real>& s, const Candidate& candidate,
                                       Real reach, NearPair<Real>& pair) {
  const Vec3T<Real> base = s.x[candidate.vertex[0]];
  Vec3T<Real> p[4];  // from the first vertex
  for (int i = 1; i < 4; ++i) p[i] = s.x[candidate.vertex[i]] - base;
  const PartingPlane<Real> plane = parting_plane(candidate, p);
  const Real room = plane.gap - Real(candidate.radius);
  if (!(room < reach)) return false;
  pair.edges = candidate.edges;
  pair.inner = candidate.inner;
  pair.skin = candidate.skin;
  pair.radius = Real(candidate.radius);
  pair.distance = candidate.skin ? Real(candidate.distance) : s.contact_distance;
  pair.gap_searched = room;
  pair.normal = plane.normal;
  pair.area = candidate.inner ? inner_area(s, candidate, p)
              : candidate.edges
                  ? Real(kEdgeShare) * norm(p[1]) * norm(p[3] - p[2])
                  : Real(0.5) * Real(1.0 - kEdgesOfArea) * s.area[candidate.vertex[0]];
  const int side_a = candidate.edges ? 2 : 1;
  const Real least =
      pair.skin ? Real(kOwnLeastGap) * pair.distance : Real(kLeastGap) * s.contact_distance;
  const Real spare = Real(0.5) * (room - least);
  const Real share = Real(kShareOfGap) * room < spare ? Real(kShareOfGap) * room : spare;
  for (int i = 0; i < 4; ++i) {
    pair.vertex[i] = candidate.vertex[i];
    const Real beyond = i < side_a ? plane.height[i] - plane.low_a : plane.high_b - plane.height[i];
    const Real limit = beyond + share;
    pair.limit[i] = !(plane.gap > Real(0)) ? Real(kNoMotion) : limit > Real(0) ? limit : Real(0);
  }
  if (pair.skin) find_twins(s, pair);
  return true;
}

/// By how much the gap of a candidate or pair may close when each vertex goes `way` [mm].
template <class Real, class Primitives>
ANGIO_HOST_DEVICE inline Real closed_by(const Real* way, const Primitives& c) {
  Real a = way[c.vertex[0]], b = way[c.vertex[3]];
  for (int i = 1; i < 3; ++i) {
    Real& side = c.edges && i == 1 ? a : b;
    const Real other = way[c.vertex[i]];
    side = other > side ? other : side;
  }
  return a + b;
}
/// The same by what they have `gone`; a thousandth for rounding.
template <class Real, class Primitives>
ANGIO_HOST_DEVICE inline Real closed_at_most(const StepView<Real>& s, const Primitives& c) {
  return Real(1.001) * closed_by(s.gone, c);
}

/// The gap with which a candidate that a vertex is in may have been found, at most, if it is near
/// now: `gone` holds what a vertex has gone since then and what it may go, and a candidate's other
/// vertices of a side are around the first.
///
/// @param balloon, others  the most of `gone`, of the balloon and of all else
template <class Real>
ANGIO_HOST_DEVICE inline Real known_around(const StepView<Real>& s, int v, Real balloon,
                                           Real others) {
  const bool of_balloon = v < s.balloon_count, of_rod = v >= s.balloon_count + s.wall_count;
  Real around = of_rod ? others : s.gone[v];
  const int* begin = of_balloon ? s.corner_begin + v : s.wall_corner_begin + (v - s.balloon_count);
  const CornerLink* corners = of_balloon ? s.corners : s.wall_corners;
  for (int c = of_rod ? 0 : begin[0]; c < (of_rod ? 0 : begin[1]); ++c) {
    const Real next = s.gone[corners[c].next], last = s.gone[corners[c].last];
    around = next > around ? next : around;
    around = last > around ? last : around;
  }
  const Real known = s.contact_range + Real(1.001) * (around + (of_balloon ? others : balloon));
  const Real own = s.self_distance + Real(1.001) * (around + (of_balloon ? balloon : others));
  return s.self_distance > Real(0) && own > known ? own : known;
}

/// Names the near ones of the candidates that a vertex owns, in their order. `gone` holds what a
/// vertex has gone since they were found and what it may go.
///
/// @param known  candidates that were found with this gap or a larger one are not near by now
/// @return their number
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline int search_owned(const StepView<Real>& s, int v, Real known,
                                          const Lanes& lanes) {
  const int first = s.owned_begin[v], last = s.owned_begin[v + 1];
  int end = first;
  // By ascending gap.
  for (int round = first; round < last && Real(s.candidates[round].gap) < known;
       round += lanes.size()) {
    const int c = round + lanes.rank();
    NearPair<Real> pair;
    const Real range = c < last ? range_of(s, s.candidates[c]) : Real(0);
    const bool near =
        c < last && Real(s.candidates[c].gap) - closed_at_most(s, s.candidates[c]) < range &&
        approach(s, s.candidates[c], range + closed_by(s.travel, s.candidates[c]), pair);
    const int place = end + lanes.before(near);
    if (c < last && s.pair_of) s.pair_of[c] = near ? place : -1;
    if (near) s.pairs[place] = pair;
    end += lanes.sum(near ? 1 : 0);
  }
  if (lanes.rank() == 0) s.owned_end[v] = end;
  return end - first;
}

/// Lists a vertex's near pairs, and the planes among them that it can reach at all.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void list_pairs(const StepView<Real>& s, int v, Real known,
                                         const Lanes& lanes) {
  const int first = s.ref_begin[v], last = s.ref_begin[v + 1];
  int refs = first, bounds = first;
  const auto may_be_named = [&](int r) {
    return r < last && Real(s.candidates[s.candidate_refs[r].pair].gap) < known;
  };
  for (int round = first; may_be_named(round); round += lanes.size()) {  // by ascending gap
    const int r = round + lanes.rank();
    const int index = may_be_named(r) ? s.pair_of[s.candidate_refs[r].pair] : -1;
    const int corner = index < 0 ? 0 : s.candidate_refs[r].corner;
    const bool binds = index >= 0 && s.pairs[index].limit[corner] < s.travel[v];
    const int place = refs + lanes.before(index >= 0), plane = bounds + lanes.before(binds);
    if (index >= 0) s.refs[place] = {index, corner};
    if (binds) {
      const NearPair<Real>& pair = s.pairs[index];
      const bool side_a = corner < (pair.edges ? 2 : 1);
      s.bounds[plane] = {side_a ? pair.normal : -pair.normal, pair.limit[corner]};
    }
    refs += lanes.sum(index >= 0 ? 1 : 0);
    bounds += lanes.sum(binds ? 1 : 0);
  }
  if (lanes.rank() > 0) return;
  s.ref_end[v] = refs;
  s.bound_end[v] = bounds;
}

/// The same of all vertices, by one thread, from the near pairs that the owners have named: far
/// quicker than looking through each vertex's candidates, where threads are few.
template <class Real>
inline void list_pairs_at_once(const StepView<Real>& s) {
  const int count = contact_vertex_count(s);
  const auto for_corners = [&](const auto& body) {
    for (int i = 0; i < count; ++i) {
      const int owner = contact_vertex(s, i);
      for (int p = s.owned_begin[owner]; p < s.owned_end[owner]; ++p)
        for (int corner = 0; corner < 4; ++corner) body(p, corner, s.pairs[p].vertex[corner]);
    }
  };
  for (int i = 0; i < count; ++i) s.ref_end[contact_vertex(s, i)] = 0;
  for_corners([&](int, int, int v) { ++s.ref_end[v]; });
  for (int i = 0, end = 0; i < count; ++i) {
    const int v = contact_vertex(s, i);
    s.listed_begin[v] = s.bound_end[v] = end;
    end += s.ref_end[v];
    s.ref_end[v] = s.listed_begin[v];
  }
  for_corners([&](int p, int corner, int v) {
    const NearPair<Real>& pair = s.pairs[p];
    s.refs[s.ref_end[v]++] = {p, corner};
    if (!(pair.limit[corner] < s.travel[v])) return;
    const bool side_a = corner < (pair.edges ? 2 : 1);
    s.bounds[s.bound_end[v]++] = {side_a ? pair.normal : -pair.normal, pair.limit[corner]};
  });
}

/// Recomputes a pair's closest points and weight at the present positions, `gone` from the last
/// search, unless it is too far for anything to act.
template <class Real>
ANGIO_HOST_DEVICE inline void refresh_pair(const StepView<Real>& s, int index) {
  NearPair<Real>& pair = s.pairs[index];
  // A pair just out of contact is kept ready for the motion of one sweep.
  const Real ready = Real(1.5) * pair.distance, range = range_of(s, pair);
  pair.film = pair.weight = Real(0);
  pair.gap = pair.gap_searched - closed_at_most(s, pair);
  if (pair.gap >= (ready > range ? ready : range)) return;
  const Vec3T<Real> p[4] = {s.x[pair.vertex[0]], s.x[pair.vertex[1]], s.x[pair.vertex[2]],
                            s.x[pair.vertex[3]]};
  pair.weights = closest_points(pair, p);
  Vec3T<Real> gap, before;  // the weights sum to 0
  const Vec3T<Real> base_before = s.x_before[pair.vertex[0]];
  for (int i = 1; i < 4; ++i) {
    gap += pair.weights.w[i] * (p[i] - p[0]);
    before += pair.weights.w[i] * (s.x_before[pair.vertex[i]] - base_before);
  }
  pair.gap_before = before;
  const Real d = norm(gap);
  pair.direction = d > Real(0) ? gap / d : pair.normal;
  pair.gap = d - pair.radius;
  if (pair.gap < ready)
    pair.weight = pair.area * (pair.edges ? sine_squared(p[1] - p[0], p[3] - p[2]) : Real(1));
}

/// The nearest triangle before a vertex, among the pairs that it owns; null: there is none.
template <class Real>
ANGIO_HOST_DEVICE inline NearPair<Real>* nearest_face(const StepView<Real>& s, int v) {
  NearPair<Real>* nearest = nullptr;
  for (int p = s.owned_begin[v]; p < s.owned_end[v]; ++p) {
    NearPair<Real>& pair = s.pairs[p];
    if (pair.edges || pair.inner || pair.skin) continue;
    if (!nearest || pair.gap < nearest->gap) nearest = &pair;
  }
  return nearest;
}

/// Puts a wet vertex's film before the nearest triangle; after all pairs are renewed.
template <class Real>
ANGIO_HOST_DEVICE inline void refresh_film(const StepView<Real>& s, int v) {
  if (!s.wet[v]) return;
  NearPair<Real>* nearest = nearest_face(s, v);
  if (nearest && nearest->gap < s.contact_range) nearest->film = nearest->area;
}

/// Wets or dries a vertex at the end of a step.
template <class Real>
ANGIO_HOST_DEVICE inline void flow_film(const StepView<Real>& s, int v) {
  const NearPair<Real>* nearest = nearest_face(s, v);
  s.wet[v] = nearest && stays_wet(s.adhesion, s.wet[v] != 0, nearest->gap) ? 1 : 0;
}

/// Adds a pair's film to its corner with weight w, at a gap d along n. Where the film gives way its
/// stiffness is negative and left out: the step is then short, never the wrong way.
template <class Real>
ANGIO_HOST_DEVICE inline void add_film(const StepView<Real>& s, const NearPair<Real>& pair, Real w,
                                       const Vec3T<Real>& n, Real d, VertexForces<Real>& out) {
  const FilmPull<Real> pull = film_pull(s.adhesion, d);
  const Vec3T<Real> force = (-pull.traction * pair.film * w) * n;
  out.force += force;
  out.adhesion += force;
  out.magnitude += norm(force);
  if (pull.stiffness > Real(0)) out.hessian += outer((pull.stiffness * pair.film * w * w) * n, n);
}

/// What acts between the two sides of a pair.
template <class Real>
struct PairForces {
  bool touching = false;
  Real gap{};        // along the pair's direction [mm]
  Real normal{};     // that parts them [uN]
  Real stiffness{};  // along the gap [uN/mm]
  Real rub{};        // friction per slip [uN/mm]
  Vec3T<Real> slip;  // in this step, of side a against side b [mm]
};

/// Within a sweep a gap is taken along its last direction with its last weights, d = n . sum w_i
/// x_i (exact to first order); refresh_pair renews both before each sweep.
template <class Real>
ANGIO_HOST_DEVICE inline PairForces<Real> pair_forces(const StepView<Real>& s,
                                                      const NearPair<Real>& pair) {
  PairForces<Real> out;
  const Vec3T<Real> n = pair.direction, base = s.x[pair.vertex[0]];
  Vec3T<Real> gap;
  for (int i = 1; i < 4; ++i) gap += pair.weights.w[i] * (s.x[pair.vertex[i]] - base);
  const Real least = Real(0.05) * pair.distance;
  Real d = out.gap = dot(n, gap) - pair.radius;
  if (!(pair.weight > Real(0)) || d >= pair.distance) return out;
  if (!(d > least)) {
    const Real true_gap = norm(gap) - pair.radius, tiny = Real(1e-3) * least;
    d = true_gap < least ? (true_gap > tiny ? true_gap : tiny) : least;
  }
  const Barrier<Real> b = barrier(d, pair.distance);
  // The slope goes with the distance: any carries the same pressure at its half.
  const Real scale = s.contact_stiffness * (s.contact_distance / pair.distance) * pair.weight;
  out.touching = true;
  out.normal = -scale * b.slope;
  out.stiffness = scale * b.curvature;
  if (pair.inner || pair.skin)
    return out;  // a shaft slides in its balloon, wet folds on each other
  out.slip = gap - pair.gap_before;
  out.slip -= dot(out.slip, n) * n;
  out.rub = out.normal * friction_per_slip(s.friction, norm(out.slip));
  return out;
}

/// Adds the barrier, the friction and the film of a vertex's pairs, each lane its share of them.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void add_contact(const StepView<Real>& s, int v, const Lanes& lanes,
                                          VertexForces<Real>& out) {
  for (int r = s.ref_begin[v] + lanes.rank(); r < s.ref_end[v]; r += lanes.size()) {
    const NearPair<Real>& pair = s.pairs[s.refs[r].pair];
    const Real w = pair.weights.w[s.refs[r].corner];
    if (!(pair.weight + pair.film > Real(0)) || w == Real(0)) continue;
    const PairForces<Real> forces = pair_forces(s, pair);
    const Vec3T<Real> n = pair.direction;
    if (pair.film > Real(0)) add_film(s, pair, w, n, forces.gap, out);
    if (!forces.touching) continue;
    const Real share = forces.normal * abs_of(w);
    out.touching = true;
    out.touching_wall = out.touching_wall || !(pair.inner || pair.skin);
    out.contact += share;
    out.magnitude += share;
    const Vec3T<Real> friction = (-forces.rub * w) * forces.slip;
    out.force += (forces.normal * w) * n + friction;
    if (pair.skin) out.own += (forces.normal * w) * n;
    out.friction += friction;
    // With a twin that moves at the same time: (a u + b v)^2 <= (|a| + |b|) (|a| u^2 + |b| v^2).
    const int twin = pair.twin[s.refs[r].corner];
    const Real both = w * w + (twin < 0 ? Real(0) : abs_of(w * pair.weights.w[twin]));
    const Real along = forces.stiffness * both, across = forces.rub * w * w;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        out.hessian(i, j) +=
            along * n[i] * n[j] + across * ((i == j ? Real(1) : Real(0)) - n[i] * n[j]);
  }
}

/// The longest part of a move that keeps the vertex within its bounds since the last search.
///
/// @param travel  [mm]
/// @return share in [0, 1]
template <class Real>
ANGIO_HOST_DEVICE inline Real allowed_share(const StepView<Real>& s, int v, const Vec3T<Real>& move,
                                            Real travel) {
  using std::sqrt;
  const Vec3T<Real> done = s.x[v] - s.x_searched[v];
  Real share = Real(1);
  for (int b = s.ref_begin[v]; b < s.bound_end[v]; ++b) {
    const MotionBound<Real>& bound = s.bounds[b];
    if (bound.limit < Real(0)) return Real(0);
    const Real more = -dot(bound.normal, move);
    if (!(more > Real(0))) continue;
    const Real left = bound.limit + dot(bound.normal, done);
    if (more > left) {
      const Real part = left > Real(0) ? left / more : Real(0);
      share = part < share ? part : share;
    }
  }
  // |done + t move| <= travel
  const Real a = dot(move, move), b = dot(done, move), c = dot(done, done) - travel * travel;
  if (a + Real(2) * b + c > Real(0)) {
    const Real root = b * b - a * c;
    Real part = root > Real(0) && a > Real(0) ? (-b + sqrt(root)) / a : Real(0);
    part = part > Real(0) ? part : Real(0);
    share = part < share ? part : share;
  }
  return share;
}

}  // namespace angio::simulation::detail
