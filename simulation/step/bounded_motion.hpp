#pragma once

#include "simulation/step/near_pairs.hpp"
#include "simulation/step/status.hpp"

/// The search for near pairs, and motions as far as they let a vertex move.
namespace angio::simulation::detail {

/// A vertex may move by this multiple of its last step's motion between two searches, but no less
/// and no more than these multiples of the contact distance; layers of folds one length all, and
/// less where surfaces may meet themselves.
inline constexpr double kMoveAhead = 1.5;
inline constexpr double kLeastMove = 0.1, kMostMove = 2.0;
inline constexpr double kFoldsMove = 0.25, kSelfMove = 1.0;

/// The longest part of a move that keeps the vertex within its bounds since the last search.
///
/// @param max_move  since then [mm]
/// @return share in [0, 1]
template <class Real>
ANGIO_HOST_DEVICE inline Real allowed_share(const StepView<Real>& s, int v, const Vec3T<Real>& move,
                                            Real max_move) {
  using std::sqrt;
  const Vec3T<Real> done = s.motion.x[v] - s.motion.x_searched[v];
  Real share = Real(1);
  for (int b = s.contact.candidates.ref_begin[v]; b < s.contact.near.bound_end[v]; ++b) {
    const MotionBound<Real>& bound = s.contact.near.bounds[b];
    if (bound.limit < Real(0)) return Real(0);
    const Real more = -dot(bound.normal, move);
    if (!(more > Real(0))) continue;
    const Real left = bound.limit + dot(bound.normal, done);
    if (more > left) {
      const Real part = left > Real(0) ? left / more : Real(0);
      share = part < share ? part : share;
    }
  }
  // |done + t move| <= max_move
  const Real a = dot(move, move), b = dot(done, move), c = dot(done, done) - max_move * max_move;
  if (a + Real(2) * b + c > Real(0)) {
    const Real root = b * b - a * c;
    Real part = root > Real(0) && a > Real(0) ? (-b + sqrt(root)) / a : Real(0);
    part = part > Real(0) ? part : Real(0);
    share = part < share ? part : share;
  }
  return share;
}

/// The most that a vertex moves between two searches, of the contact distance.
ANGIO_HOST_DEVICE inline double most_move(bool has_folds, double self_distance) {
  return has_folds ? kFoldsMove : self_distance > 0 ? kSelfMove : kMostMove;
}
template <class Real>
ANGIO_HOST_DEVICE inline Real most_move(const StepView<Real>& s) {
  return Real(most_move(s.balloon.has_folds, double(s.contact.law.self_distance))) *
         s.contact.law.distance;
}

template <class Real>
ANGIO_HOST_DEVICE inline int last_of_balloon(const StepView<Real>& s) {
  return s.balloon.mesh.color_begin[s.balloon.mesh.colors];
}

/// Are near pairs searched, and motions bounded by them?
template <class Team, class Real>
ANGIO_HOST_DEVICE inline bool has_pairs(const StepView<Real>& s) {
  return Team::kSurroundings &&
         ((s.bodies.wall().count > 0 && !s.pbd.parts_surfaces()) || s.guidewire.shape.count > 0 ||
          s.contact.law.self_distance > Real(0));
}

/// Moves a vertex as far as its bounds let it. @return the part taken
template <class Team, class Real>
ANGIO_HOST_DEVICE inline Real bounded_share(const StepView<Real>& s, int v,
                                            const Vec3T<Real>& move) {
  return has_pairs<Team>(s) ? allowed_share(s, v, move, s.contact.near.max_move[v]) : Real(1);
}

/// How far a vertex may move between two searches: by how far it moved in the last step.
template <class Real>
ANGIO_HOST_DEVICE inline Real useful_move(const StepView<Real>& s, int v) {
  const Real most = most_move(s);
  const Real least = s.balloon.has_folds ? most : Real(kLeastMove) * s.contact.law.distance;
  const Real motion = Real(kMoveAhead) * s.motion.dt * norm(s.motion.velocity[v]);
  return motion < least ? least : motion < most ? motion : most;
}

/// The same where a step goes on: twice as far where the last search did not let it go far enough.
template <class Real>
ANGIO_HOST_DEVICE inline Real longer_move(const StepView<Real>& s, int v) {
  const Real most = most_move(s);
  const Real twice = Real(2) * norm(s.motion.x[v] - s.motion.x_searched[v]);
  return twice < s.contact.near.max_move[v] ? s.contact.near.max_move[v]
         : twice < most                     ? twice
                                            : most;
}

/// How far each body has moved since the candidates were found plus how far it may still move, at
/// most [mm].
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void measure_moves(Team& team, const StepView<Real>& s, bool goes_on,
                                            double (&most)[kBodyCount]) {
  const NearPairView<Real>& near = s.contact.near;
  team.template most<kBodyCount>(
      s.bodies.contact_count(),
      [&](int i, const auto&, auto* part) {
        const int v = s.bodies.contact_vertex(i);
        if (goes_on) near.max_move[v] = longer_move(s, v);
        const Real far = near.moved[v] =
            norm(s.motion.x[v] - s.contact.candidates.x[v]) + near.max_move[v];
        auto& body = part[int(s.bodies.of(v))];
        body = far > body ? far : body;
      },
      most);
}

/// Names the near pairs and lists each vertex's.
///
/// @param found_gap  by vertex: candidates found with this gap or a larger one are not near
/// @param most       of them
/// @return their number
template <class Real, class Team, class FoundGap>
ANGIO_HOST_DEVICE inline int name_pairs(Team& team, const StepView<Real>& s,
                                        const FoundGap& found_gap, Real most) {
  const int count = s.bodies.contact_count();
  double total[1];
  team.template quick_sum<Team::kSlabLanes, 1>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = s.bodies.contact_vertex(i);
        part[0] += Real(search_owned(s, v, found_gap(v), lanes));
      },
      total);
  if constexpr (Team::kIsSmall)
    if (team.leader()) list_pairs_at_once(s);
  team.template for_each<Team::kSlabLanes>(count, [&](int i, const auto& lanes) {
    const int v = s.bodies.contact_vertex(i);
    if constexpr (!Team::kIsSmall) list_pairs(s, v, most, lanes);
    if (lanes.rank() == 0) s.motion.x_searched[v] = s.motion.x[v];
  });
  team.barrier();
  return int(total[0]);
}

/// Searches the candidates for near pairs (near_pairs.hpp). @return false if the candidates are
/// used up and new ones are needed
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool search_pairs(Team& team, const StepView<Real>& s,
                                           StepStatus& status) {
  if (!has_pairs<Team>(s)) return true;
  const double begin = team.now();
  const ContactLaw<Real>& law = s.contact.law;
  const CandidateView<Real>& candidates = s.contact.candidates;
  double used[kBodyCount];
  measure_moves(team, s, status.stage == StepStage::sweeps, used);
  // A thousandth for rounding. Both sides of a surface's contact with itself are of that surface.
  const Real closer = Real(1.001 * most_of_pairs(used)),
             self_closer = Real(1.001 * 2.0 * most_of(used));
  const bool has_self = law.self_distance > Real(0);
  const SearchRadii<Real> radii = *candidates.radii;
  status.halted = !(closer < radii.search - law.range) ||
                  (has_self && !(self_closer < radii.self - law.self_distance));
  if (status.halted) return false;
  const Real found_others = law.range + closer, found_self = law.self_distance + self_closer;
  const Real most = has_self && found_self > found_others ? found_self : found_others;
  Real most_used[kBodyCount];
  for (int b = 0; b < kBodyCount; ++b) most_used[b] = Real(used[b]);
  const auto found_gap = [&](int v) {
    const bool owns = candidates.owned_begin[v] < candidates.owned_begin[v + 1];
    return Team::kIsSmall && owns ? found_gap_around(s, v, most_used) : most;
  };
  status.report.pair_count = name_pairs(team, s, found_gap, most);
  ++status.report.searches;
  status.since_search = 0;
  status.report.times.search += team.now() - begin;
  return true;
}

/// Vertices that move: the balloon's, then those of the wall's inside.
template <class Real>
ANGIO_HOST_DEVICE inline int moving_count(const StepView<Real>& s) {
  return last_of_balloon(s) +
         (s.wall.mesh.colors > 0
              ? s.wall.mesh.color_begin[s.wall.mesh.colors] - s.bodies.wall().first
              : 0);
}
template <class Real>
ANGIO_HOST_DEVICE inline int moving_vertex(const StepView<Real>& s, int i) {
  const int movable = last_of_balloon(s);
  return i < movable ? i : s.bodies.wall().first + i - movable;
}

/// Moves every vertex v by by(v) as far as its bounds let it, and the column behind a wall's vertex
/// along. @return is a vertex held by its bounds?
template <class Real, class Team, class By>
ANGIO_HOST_DEVICE inline bool move_all(Team& team, const StepView<Real>& s, const By& by) {
  double held[1];
  team.template quick_sum<1, 1>(
      moving_count(s),
      [&](int i, const auto&, auto* part) {
        const int v = moving_vertex(s, i);
        const Vec3T<Real> move = by(v);
        const Real share = bounded_share<Team>(s, v, move);
        s.motion.x[v] += share * move;
        for (int l = 1;
             Team::kSolids && s.bodies.of(v) == Body::wall && l < s.layered.columns.levels; ++l) {
          const int u = v + l * s.layered.columns.stride;
          s.motion.x[u] += share * by(u);
        }
        part[0] += share < Real(1) ? Real(1) : Real(0);
      },
      held);
  return held[0] > 0.0;
}

}  // namespace angio::simulation::detail
