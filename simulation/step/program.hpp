#pragma once

#include "simulation/materials/gas.hpp"
#include "simulation/pbd/sweep.hpp"
#include "simulation/step/leap.hpp"
#include "simulation/step/sweep_balloon.hpp"
#include "simulation/step/sweep_guidewire.hpp"
#include "simulation/step/sweep_layered_wall.hpp"
#include "simulation/step/sweep_slabs.hpp"

/// The step as a program for a team of threads (launch.hpp), the same source for every backend.
///
/// An implicit Euler step by vertex block descent: sweeps over the vertices, colour by colour, each
/// vertex taking a Newton step in its own 3 x 3 block.
///
/// Source: Chen, Liu, Yang, Yuksel, "Vertex Block Descent", ACM TOG 43 (2024), Eqs. 4-9; here with
/// over-relaxation in place of the Chebyshev acceleration, and with the enclosed gas, which couples
/// all vertices through one number, met exactly once a colour: the volume is linear in the vertices
/// of a colour, V(p) = V + sum g . H^-1 (f + (p - p_0) g), and the gas law is solved against it.
namespace angio::simulation::detail {

/// When a step's sweeps end.
struct StepRules {
  int least_sweeps = 0;      ///< unless nothing is to be done
  int most_sweeps = 120;     ///< while the force balance is open
  double tolerance = 0.005;  ///< lag that ends the sweeps, as a share of the balloon's radius
  double radius = 1.0;       ///< of the balloon [mm]
  double residual = 0.02;    ///< sweeps go on above it
  double rest = 1e-3;        ///< residual below which nothing is to be done: sweeps end early
  /// From this many sweeps on a frame ends at kLaterLag of the tolerance and kLaterResidual: the
  /// next one goes on from there. This bounds what a vessel costs that keeps a frame open.
  int later_sweeps = 1 << 30;
  /// A frame that is so far off balance that it is no result gets up to this many, until it is not.
  int last_sweeps = 0;
  double least_load = 0.0;  ///< pressure [Pa] against which a slack balloon's forces are measured
  bool still = false;       ///< no inertia, no prediction: equilibria
};

inline constexpr double kLaterLag = 4.0, kLaterResidual = 0.05;
/// A residual from which on a frame is off balance (success.hpp), less a margin.
inline constexpr double kOffBalance = 0.2, kBalanceMargin = 0.75;

/// Where the time of a step goes [s].
struct StepTimes {
  double search = 0.0;               ///< of near pairs
  double refresh = 0.0;              ///< of pairs, slabs and goals
  double balloon = 0.0, wall = 0.0;  ///< sweeps
  double rest = 0.0;                 ///< begin and end of the step
};

/// What a step tells.
struct StepReport {
  double residual = 0.0;        ///< net force over load, root of sums of squares
  double lag = 0.0;             ///< estimated distance from equilibrium over the radius
  double friction_delta = 0.0;  ///< see README [mm]
  double viscous_delta = 0.0;   ///< see README [mm]
  int sweeps = 0;
  int searches = 0;       ///< of near pairs
  int pair_count = 0;     ///< near in the last one
  int contact_count = 0;  ///< balloon vertices in contact
  StepTimes times;
};

/// Where a step goes on: it halts where new candidates are needed.
enum class StepStage { begin, foresight, sweeps };

/// The numbers of a step that outlive a launch.
struct StepStatus {
  double pressure = 0.0, volume = 0.0;  ///< absolute [Pa], enclosed [mm^3]
  double load_floor = 0.0;              ///< squared [uN^2]
  double compliance = 0.0;              ///< dV/dp of all colours in the last sweep [mm^3/Pa]
  double moved[4]{};                    ///< of the last sweeps, root mean square, newest first [mm]
  GasLaw<double> law;
  StepReport report;
  LeapStatus leap;
  int since_search = 0;     ///< sweeps
  bool blocked = false;     ///< a vertex has met its bound in the last sweep
  bool halted = false;      ///< for want of candidates
  bool wall_rests = false;  ///< a layered one that is left alone: in balance, and no pair is near
  double tet_growth = 1.0;  ///< of the paper's gas: targets over volumes at the start
  StepStage stage = StepStage::begin;
  int frame = 0;  ///< that is under way or has ended
};

/// Stiffness of the spring that leads to a prescribed volume, times the balloon's dV/dp.
inline constexpr double kVolumeSpring = 1.0;
/// A step is begun with this share of the last one's motion: balloon and wall then go on together,
/// which sweeps alone, moving one against the other, do slowly. Below 1, so that errors die out.
inline constexpr double kForesight = 0.9;
inline constexpr int kLeastSweeps = 3;  // for what rests
/// A vertex that has met its bound waits for so many sweeps for the next search. Layers of folds
/// are near each other everywhere: searches are dear there, and the less travel the fewer pairs.
inline constexpr int kPatience = 2, kFoldsPatience = 4;
/// A vertex may go this multiple of its last step's motion between two searches, but no less and no
/// more than these multiples of the contact distance; layers of folds one length all, and less
/// where surfaces may meet themselves.
inline constexpr double kTravelAhead = 1.5;
inline constexpr double kLeastTravel = 0.1, kMostTravel = 2.0;
inline constexpr double kFoldsTravel = 0.25, kOwnTravel = 1.0;
inline constexpr int kSweepsToTell = 4;  // for the lag to be known

/// The most that a vertex goes between two searches, of the contact distance. Of scene or view.
template <class Model>
ANGIO_HOST_DEVICE inline double most_travel(const Model& model) {
  return model.has_folds ? kFoldsTravel : model.self_distance > 0 ? kOwnTravel : kMostTravel;
}

template <class Real>
ANGIO_HOST_DEVICE inline int last_of_balloon(const StepView<Real>& s) {
  return s.balloon_color_begin[s.balloon_colors];
}

/// Are near pairs searched, and motions bounded by them?
template <class Team, class Real>
ANGIO_HOST_DEVICE inline bool has_pairs(const StepView<Real>& s) {
  return Team::kSurroundings && ((s.wall_count > 0 && !s.paper.is_on) || s.rod.shape.count > 0 ||
                                 s.self_distance > Real(0));
}

/// Moves a vertex as far as its bounds let it. @return the part taken
template <class Team, class Real>
ANGIO_HOST_DEVICE inline Real bounded_share(const StepView<Real>& s, int v,
                                            const Vec3T<Real>& move) {
  return has_pairs<Team>(s) ? allowed_share(s, v, move, s.travel[v]) : Real(1);
}

/// Six times the volume of the tetrahedron of a balloon triangle and the origin [mm^3].
template <class Real>
ANGIO_HOST_DEVICE inline double six_volumes(const StepView<Real>& s, int t) {
  const Vec3T<Real>&a = s.x[s.triangles[3 * t]], &b = s.x[s.triangles[3 * t + 1]],
        &c = s.x[s.triangles[3 * t + 2]];
  const Vec3T<double> p{a.x, a.y, a.z}, q{b.x, b.y, b.z}, r{c.x, c.y, c.z};
  return dot(p, cross(q, r));
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline double enclosed_volume(Team& team, const StepView<Real>& s) {
  double total[1];
  team.template sum<1, 1>(
      s.triangle_count, [&](int t, const auto&, auto* part) { part[0] += six_volumes(s, t); },
      total);
  return total[0] / 6.0;
}

/// A third of the triangles around each vertex of the surfaces.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void measure_areas(Team& team, const StepView<Real>& s) {
  team.template for_each<1>(s.balloon_count + s.wall_count, [&](int v, const auto&) {
    const bool balloon = v < s.balloon_count;
    const int* begin = balloon ? s.corner_begin + v : s.wall_corner_begin + (v - s.balloon_count);
    const CornerLink* corners = balloon ? s.corners : s.wall_corners;
    Real area = 0;
    for (int c = begin[0]; c < begin[1]; ++c)
      area += norm(cross(s.x[corners[c].next] - s.x[v], s.x[corners[c].last] - s.x[v])) / Real(6);
    s.area[v] = area;
  });
}

/// How far a vertex may go between two searches: by how far it went in the last step.
template <class Real>
ANGIO_HOST_DEVICE inline Real useful_travel(const StepView<Real>& s, int v) {
  const Real most = Real(most_travel(s)) * s.contact_distance;
  const Real least = s.has_folds ? most : Real(kLeastTravel) * s.contact_distance;
  const Real motion = Real(kTravelAhead) * s.dt * norm(s.velocity[v]);
  return motion < least ? least : motion < most ? motion : most;
}

/// The paper's air mass of each tet in place of the law: all grow as the balloon's volume is to.
template <class Real>
ANGIO_HOST_DEVICE inline void fill_tets(const StepView<Real>& s, StepStatus& status) {
  GasLaw<double>& law = status.law;
  status.tet_growth = law.volume > 0.0 ? law.volume / s.paper_gas.whole : 1.0;
  law.volume = 0.0;
  law.slope_pressure = double(s.outside_pressure);
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void begin_step(Team& team, const StepView<Real>& s,
                                         const StepRules& rules, StepStatus& status) {
  if (Team::kSolids && s.paper_gas.is_on) fill_tets(s, status);
  team.template for_each<1>(s.vertex_count, [&](int v, const auto&) {
    s.x_before[v] = s.x[v];
    s.x_inertial[v] = rules.still ? s.x[v] : s.x[v] + s.dt * s.velocity[v];
  });
  measure_areas(team, s);
  team.barrier();
  if (has_pairs<Team>(s))
    team.template for_each<1>(contact_vertex_count(s), [&](int i, const auto&) {
      const int v = contact_vertex(s, i);
      s.travel[v] = useful_travel(s, v);
    });
  double total[1];
  team.template quick_sum<1, 1>(
      s.balloon_count,
      [&](int v, const auto&, auto* part) {
        const Real load = Real(rules.least_load) * s.area[v];
        part[0] += load * load;
      },
      total);
  status.load_floor = total[0];
  for (double& moved : status.moved) moved = 0.0;
  status.leap = {};
  status.report = {};
  status.blocked = status.wall_rests = false;
}

/// The same where a step goes on: twice as far where the last search did not let it go far enough.
template <class Real>
ANGIO_HOST_DEVICE inline Real longer_travel(const StepView<Real>& s, int v) {
  const Real most = Real(most_travel(s)) * s.contact_distance;
  const Real twice = Real(2) * norm(s.x[v] - s.x_searched[v]);
  return twice < s.travel[v] ? s.travel[v] : twice < most ? twice : most;
}

/// Searches the candidates for near pairs (step_contact.hpp). @return false if the candidates are
/// used up and new ones are needed
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool search_pairs(Team& team, const StepView<Real>& s,
                                           StepStatus& status) {
  if (!has_pairs<Team>(s)) return true;
  const double begin = team.now();
  const int count = contact_vertex_count(s);
  const bool goes_on = status.stage == StepStage::sweeps;
  double used[2];  // of the balloon, and of wall and guidewire: the two sides of a candidate
  team.template most<2>(
      count,
      [&](int i, const auto&, auto* part) {
        const int v = contact_vertex(s, i);
        if (goes_on) s.travel[v] = longer_travel(s, v);
        const Real far = s.gone[v] = norm(s.x[v] - s.x_candidates[v]) + s.travel[v];
        auto& side = part[v < s.balloon_count ? 0 : 1];
        side = far > side ? far : side;
      },
      used);
  // A thousandth for rounding. Both sides of a surface's contact with itself are of that surface.
  const Real closer = Real(1.001 * (used[0] + used[1])),
             folds = Real(1.001 * 2.0 * (used[0] > used[1] ? used[0] : used[1]));
  const bool has_skin = s.self_distance > Real(0);
  status.halted = !(closer < s.candidate_reach - s.contact_range) ||
                  (has_skin && !(folds < s.skin_reach - s.self_distance));
  if (status.halted) return false;
  const Real known_others = s.contact_range + closer, known_skin = s.self_distance + folds;
  const Real known = has_skin && known_skin > known_others ? known_skin : known_others;
  const auto known_to = [&](int v) {
    const bool owns = s.owned_begin[v] < s.owned_begin[v + 1];
    return Team::kIsSmall && owns ? known_around(s, v, Real(used[0]), Real(used[1])) : known;
  };
  double total[1];
  team.template quick_sum<Team::kClusterLanes, 1>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = contact_vertex(s, i);
        part[0] += Real(search_owned(s, v, known_to(v), lanes));
      },
      total);
  if constexpr (Team::kIsSmall)
    if (team.leader()) list_pairs_at_once(s);
  team.template for_each<Team::kClusterLanes>(count, [&](int i, const auto& lanes) {
    const int v = contact_vertex(s, i);
    if constexpr (!Team::kIsSmall) list_pairs(s, v, known, lanes);
    if (lanes.rank() == 0) s.x_searched[v] = s.x[v];
  });
  team.barrier();
  status.report.pair_count = int(total[0]);
  ++status.report.searches;
  status.since_search = 0;
  status.report.times.search += team.now() - begin;
  return true;
}

/// Vertices that move: the balloon's, then those of the wall's inside.
template <class Real>
ANGIO_HOST_DEVICE inline int moving_count(const StepView<Real>& s) {
  return last_of_balloon(s) +
         (s.wall_colors > 0 ? s.wall_color_begin[s.wall_colors] - s.balloon_count : 0);
}
template <class Real>
ANGIO_HOST_DEVICE inline int moving_vertex(const StepView<Real>& s, int i) {
  const int movable = last_of_balloon(s);
  return i < movable ? i : s.balloon_count + i - movable;
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
        s.x[v] += share * move;
        for (int l = 1; Team::kSolids && v >= s.balloon_count && l < s.columns.levels; ++l) {
          const int u = v + l * s.columns.stride;
          s.x[u] += share * by(u);
        }
        part[0] += share < Real(1) ? Real(1) : Real(0);
      },
      held);
  return held[0] > 0.0;
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void measure_gas(Team& team, const StepView<Real>& s, StepStatus& status) {
  status.volume = enclosed_volume(team, s);
  status.pressure = pressure_at(status.law, status.volume);
}

/// Takes the rod's moves: nodes and ties by one share, that of the least room.
/// @return volume gained [mm^3]
template <class Real, class Team>
ANGIO_HOST_DEVICE inline double take_rod(Team& team, const StepView<Real>& s) {
  const RodView<Real>& rod = s.rod;
  const int parts = rod_part_count(rod);
  team.template for_each<1>(parts, [&](int i, const auto&) {
    rod.share[i] = bounded_share<Team>(s, rod_part_vertex(rod, i), rod_move(rod, i));
  });
  team.barrier();
  if (team.leader()) {
    Real least = Real(1);
    for (int i = 0; i < parts; ++i) least = rod.share[i] < least ? rod.share[i] : least;
    rod.report->share = double(least);
  }
  team.barrier();
  const Real share = Real(rod.report->share);
  double total[1];
  team.template sum<1, 1>(
      parts,
      [&](int i, const auto&, auto* part) {
        const Vec3T<Real> move = share * rod_move(rod, i);
        s.x[rod_part_vertex(rod, i)] += move;
        if (i >= rod.shape.count) part[0] += dot(rod.loads[i].by_volume, move);
      },
      total);
  return total[0];
}

/// Goes on with the last step's motion.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void foresee(Team& team, const StepView<Real>& s, const StepRules& rules,
                                      StepStatus& status) {
  if (!rules.still)
    move_all(team, s, [&](int v) { return Real(kForesight) * (s.x_inertial[v] - s.x_before[v]); });
  if (Team::kSurroundings && !rules.still && s.rod.shape.count > 0) {
    team.template for_each<1>(s.rod.shape.count, [&](int i, const auto&) {
      const int v = s.rod.first + i;
      s.rod.rows[i].force = kForesight * in_double(s.x_inertial[v] - s.x_before[v]);
    });
    team.barrier();
    take_rod(team, s);
  }
  measure_gas(team, s, status);
}

/// To be called before a sweep that leaps are to take into account.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void mark_positions(Team& team, const StepView<Real>& s) {
  team.template for_each<1>(s.vertex_count, [&](int v, const auto&) { s.x_swept[v] = s.x[v]; });
}

/// After a sweep: leaps to where the sweeps lead, if they go on in one direction (step_leap.hpp).
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void leap(Team& team, const StepView<Real>& s, StepStatus& status) {
  double total[3];
  team.template quick_sum<1, 3>(
      s.vertex_count,
      [&](int v, const auto&, auto* part) {
        const Vec3T<Real> before = s.swept_by[v], now = s.x[v] - s.x_swept[v];
        part[0] += dot(before, now);
        part[1] += norm_squared(before);
        part[2] += norm_squared(now);
        s.swept_by[v] = now;
        s.x_swept[v] = s.x[v];
      },
      total);
  const double length = leap_length(status.leap, total);
  if (!(length > 0.0)) return;
  const bool held = move_all(team, s, [&](int v) { return Real(length) * s.swept_by[v]; });
  status.blocked = status.blocked || held;
  status.leap = {};
  for (double& moved : status.moved) moved = 0.0;
  mark_positions(team, s);
  measure_gas(team, s, status);
}

/// Fits the wall's slabs and its goals, and renews the contact pairs.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void refresh(Team& team, const StepView<Real>& s) {
  if (!Team::kSurroundings || (!has_pairs<Team>(s) && s.wall_count == 0)) return;
  if (s.candidate_count > 0) {
    team.template for_each<1>(contact_vertex_count(s), [&](int i, const auto&) {
      const int v = contact_vertex(s, i);
      s.gone[v] = norm(s.x[v] - s.x_searched[v]);
    });
    team.barrier();
  }
  team.template for_each<Team::kVertexLanes>(
      s.candidate_count > 0 ? contact_vertex_count(s) : 0, [&](int i, const auto& lanes) {
        const int v = contact_vertex(s, i);
        for (int p = s.owned_begin[v] + lanes.rank(); p < s.owned_end[v]; p += lanes.size())
          refresh_pair(s, p);
      });
  team.template for_each<Team::kClusterLanes>(
      s.cluster_count, [&](int c, const auto& lanes) { fit_cluster(s, c, lanes); });
  team.barrier();
  if (s.cluster_count > 0)
    team.template for_each<1>(s.wall_count, [&](int i, const auto&) { set_goal(s, i); });
  if (s.wet && s.candidate_count > 0)
    team.template for_each<1>(s.balloon_count + s.wall_count,
                              [&](int v, const auto&) { refresh_film(s, v); });
  team.barrier();
}

/// Sums of a sweep.
struct SweepSums {
  double net = 0.0, load = 0.0;            ///< squared [uN^2]
  double moved = 0.0;                      ///< squared [mm^2], of the balloon
  double compliance = 0.0;                 ///< [mm^3/Pa]
  bool blocked = false;                    ///< a vertex has met its bound
  double wall_net = 0.0, wall_load = 0.0;  ///< the wall's part of net and load
};

/// A colour's moves at the present pressure, and how its volume answers to pressure.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void propose_moves(Team& team, const StepView<Real>& s, int first,
                                            int count, Real gauge, double (&total)[4]) {
  team.template quick_sum<Team::kBalloonLanes, 4>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = first + i;
        Move<Real> move;
        const VertexForces<Real> f =
            balloon_forces<Team::kSurroundings>(s, v, lanes, move.by_volume);
        const Mat3T<Real> inverse = inverse_block(f.hessian);
        const Vec3T<Real> load = gauge * move.by_volume;
        const bool held = f.touching || norm_squared(f.adhesion) > Real(0);
        const Real relax = held ? Real(1) : s.relaxation;
        move.by_force = relax * (inverse * (f.force + load));
        move.by_pressure = relax * (inverse * move.by_volume);
        if (Team::kSurroundings && s.candidate_count > 0) {
          move.friction = norm(inverse * f.friction);
          move.adhesion = norm(inverse * f.adhesion);
        }
        move.taut = f.taut;
        part[0] += dot(move.by_volume, move.by_force);
        part[1] += dot(move.by_volume, move.by_pressure);
        part[2] += norm_squared(f.force + load);
        part[3] += norm_squared(load) + f.contact * f.contact;
        lanes.sync();
        if (lanes.rank() == 0) s.moves[v] = move;
      },
      total);
}

/// Takes the moves with the change of pressure; total: volume gained, squared motion, blocked.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void take_moves(Team& team, const StepView<Real>& s, int first, int count,
                                         Real change, Real gauge, double (&total)[3]) {
  team.template quick_sum<Team::kBalloonLanes, 3>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = first + i;
        const Move<Real> move = s.moves[v];
        Vec3T<Real> by = move.by_force + change * move.by_pressure;
        if (!move.taut) by *= balloon_line_search(s, v, lanes, gauge, by);
        const Real share = bounded_share<Team>(s, v, by);
        by *= share;
        part[0] += dot(move.by_volume, by);
        part[1] += norm_squared(by);
        part[2] += share < Real(1) ? Real(1) : Real(0);
        lanes.sync();
        if (lanes.rank() == 0) s.x[v] += by;
      },
      total);
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_balloon(Team& team, const StepView<Real>& s, StepStatus& status,
                                            SweepSums& sums) {
  GasLaw<double>& law = status.law;
  for (int color = 0; color < s.balloon_colors; ++color) {
    const int first = s.balloon_color_begin[color],
              count = s.balloon_color_begin[color + 1] - first;
    const Real p = Real(status.pressure);
    double proposed[4], taken[3];
    propose_moves(team, s, first, count, p - s.outside_pressure, proposed);
    if (law.volume > 0.0) {
      const double whole =
          status.compliance > 0.0 ? status.compliance : s.balloon_colors * proposed[1];
      law.spring = kVolumeSpring / whole;
    }
    const double least = 1e-3 * status.volume, grown = status.volume + proposed[0];
    const Real change =
        meet(converted<Real>(law), p, Real(grown > least ? grown : least), Real(proposed[1])) - p;
    take_moves(team, s, first, count, change, p + change - s.outside_pressure, taken);
    status.volume += taken[0];
    status.pressure = pressure_at(law, status.volume);
    sums.net += proposed[2];
    sums.load += proposed[3];
    sums.compliance += proposed[1];
    sums.moved += taken[1];
    sums.blocked = sums.blocked || taken[2] > 0.0;
  }
  status.compliance = sums.compliance;
  if (law.volume > 0.0) law.slope_pressure = status.pressure;
}

/// Moves the guidewire and what is tied to it.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_rod(Team& team, const StepView<Real>& s, StepStatus& status,
                                        SweepSums& sums) {
  const Real gauge = Real(status.pressure) - s.outside_pressure;
  team.template for_each<Team::kVertexLanes>(rod_part_count(s.rod), [&](int i, const auto& lanes) {
    gather_rod_load(s, i, lanes, gauge);
  });
  team.barrier();
  if (team.leader()) propose_rod(s);
  team.barrier();
  status.volume += take_rod(team, s);
  status.pressure = pressure_at(status.law, status.volume);
  sums.net += s.rod.report->net;
  sums.load += s.rod.report->load;
  sums.blocked = sums.blocked || s.rod.report->share < 1.0;
  team.barrier();
}

/// Moves the wall's vertices of a colour; total: squared net force and load, blocked.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void move_wall_vertices(Team& team, const StepView<Real>& s, int first,
                                                 int count, double (&total)[3]) {
  team.template quick_sum<Team::kVertexLanes, 3>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const int v = first + i;
        const VertexForces<Real> f = wall_forces(s, v, lanes);
        const Real net = norm_squared(f.force);
        part[0] += net;
        part[1] += f.magnitude * f.magnitude;
        Vec3T<Real> move;
        if (net > Real(0)) move = inverse_block(f.hessian) * f.force;
        const Real share = bounded_share<Team>(s, v, move);
        part[2] += share < Real(1) ? Real(1) : Real(0);
        lanes.sync();
        if (lanes.rank() == 0) move_wall_vertex(s, v, share * move);
      },
      total);
}

/// The same of a layered wall's columns.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void move_wall_columns(Team& team, const StepView<Real>& s, int first,
                                                int count, double (&total)[3]) {
  team.template quick_sum<Team::kVertexLanes, 3>(
      count,
      [&](int i, const auto& lanes, auto* part) {
        const ColumnMove<Real> column = propose_column(s, first + i, lanes);
        part[0] += column.net;
        part[1] += column.load;
        const Real share = take_column(s, first + i, lanes, column, s.travel[first + i]);
        part[2] += share < Real(1) ? Real(1) : Real(0);
      },
      total);
}

template <class Real, class Team>
ANGIO_HOST_DEVICE inline void sweep_wall(Team& team, const StepView<Real>& s, SweepSums& sums) {
  const double net_before = sums.net, load_before = sums.load;
  for (int color = 0; color < s.wall_colors; ++color) {
    const int first = s.wall_color_begin[color], count = s.wall_color_begin[color + 1] - first;
    double total[3];
    bool layered = false;
    if constexpr (Team::kSolids) {
      layered = s.columns.levels > 0;
      if (layered) move_wall_columns(team, s, first, count, total);
    }
    if (!layered) move_wall_vertices(team, s, first, count, total);
    make_wall_moves(team, s, first, count);
    sums.net += total[0];
    sums.load += total[1];
    sums.blocked = sums.blocked || total[2] > 0.0;
  }
  sums.wall_net = sums.net - net_before;
  sums.wall_load = sums.load - load_before;
}

/// The distance still to go, from how the last sweeps' motions m shrink: m q / (1 - q) [mm].
ANGIO_HOST_DEVICE inline double estimated_lag(const double (&moved)[4]) {
  if (!(moved[3] > 0.0)) return moved[0];  // too few sweeps to tell
  double q = std::cbrt(moved[0] / moved[3]);
  q = q < 0.98 ? q : 0.98;
  return moved[0] * q / (1.0 - q);
}

/// The tets of the paper's gas, colour by colour.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void project_gas(Team& team, const StepView<Real>& s, double growth) {
  const PaperGas<Real>& gas = s.paper_gas;
  for (int color = 0; color < gas.colors; ++color) {
    const int first = gas.color_begin[color];
    team.template for_each<1>(gas.color_begin[color + 1] - first, [&](int i, const auto&) {
      const int tet = first + i;
      project_gas_tet(gas, tet, Real(growth * double(gas.volume[tet])), s.x);
    });
    team.barrier();
  }
}

/// The tets of the paper's contact, colour by colour.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void project_air(Team& team, const StepView<Real>& s, StepReport& report) {
  double sums[3] = {};
  for (int color = 0; color < s.paper.colors; ++color) {
    const int first = s.paper.color_begin[color];
    double total[3];
    team.template quick_sum<1, 3>(
        s.paper.color_begin[color + 1] - first,
        [&](int i, const auto&, auto* part) {
          PaperDeltas<Real> deltas;
          project_tet(s, first + i, deltas);
          part[0] += deltas.touching ? Real(1) : Real(0);
          part[1] += deltas.friction;
          part[2] += deltas.viscous;
        },
        total);
    for (int k = 0; k < 3; ++k) sums[k] += total[k];
  }
  report.contact_count = int(sums[0]);
  report.friction_delta = sums[1];
  report.viscous_delta = sums[2];
}

/// The paper's gas and contact after a sweep (paper_gas.hpp, step_paper.hpp).
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void project_paper(Team& team, const StepView<Real>& s,
                                            StepStatus& status) {
  if (!s.paper.is_on && !s.paper_gas.is_on) return;
  team.barrier();
  if (s.paper_gas.is_on) project_gas(team, s, status.tet_growth);
  if (s.paper.is_on) project_air(team, s, status.report);
  measure_gas(team, s, status);
}

/// One sweep over balloon and wall.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline SweepSums sweep(Team& team, const StepView<Real>& s, bool wall,
                                         StepStatus& status) {
  SweepSums sums;
  StepTimes& times = status.report.times;
  const double begin = team.now();
  refresh(team, s);
  const double refreshed = team.now();
  sweep_balloon(team, s, status, sums);
  if (Team::kSurroundings && s.rod.shape.count > 0) sweep_rod(team, s, status, sums);
  const double swept = team.now();
  if (Team::kSurroundings && wall) sweep_wall(team, s, sums);
  if constexpr (Team::kSolids) project_paper(team, s, status);
  times.refresh += refreshed - begin;
  times.balloon += swept - refreshed;
  times.wall += team.now() - swept;
  return sums;
}

/// Sweeps until the step has converged or has had its sweeps. @return false if it must halt for new
/// candidates; to be called again when they are there
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool run_sweeps(Team& team, const StepView<Real>& s,
                                         const StepRules& rules, StepStatus& status) {
  StepReport& report = status.report;
  // A balloon alone has no mode that is slow.
  const bool leaps = Team::kSurroundings && s.wall_count > 0 && !s.paper_gas.is_on;
  if (leaps) mark_positions(team, s);
  const int patience = s.has_folds ? kFoldsPatience : kPatience;
  const auto goes_on = [&] {
    return report.sweeps < rules.most_sweeps ||
           (report.sweeps < rules.last_sweeps && report.residual > kBalanceMargin * kOffBalance);
  };
  while (goes_on()) {
    if (status.blocked && status.since_search >= patience && !search_pairs(team, s, status))
      return false;
    status.wall_rests = status.wall_rests && report.pair_count == 0;
    const SweepSums sums = sweep(team, s, !status.wall_rests, status);
    // A solid that is in balance stays there until a pair can reach it.
    status.wall_rests =
        status.wall_rests || (s.columns.levels > 0 && report.pair_count == 0 &&
                              sums.wall_net <= rules.rest * rules.rest * sums.wall_load);
    ++report.sweeps;
    ++status.leap.sweeps;
    ++status.since_search;
    status.blocked = sums.blocked;
    report.residual = std::sqrt(sums.net / (sums.load + status.load_floor));
    for (int i = 3; i > 0; --i) status.moved[i] = status.moved[i - 1];
    status.moved[0] = std::sqrt(sums.moved / s.balloon_count);
    report.lag = estimated_lag(status.moved) / rules.radius;
    const bool is_late = report.sweeps >= rules.later_sweeps;
    const bool near = status.leap.sweeps >= kSweepsToTell && report.sweeps >= rules.least_sweeps &&
                      report.lag < (is_late ? kLaterLag : 1.0) * rules.tolerance &&
                      report.residual < (is_late ? kLaterResidual : rules.residual);
    const bool rests = report.residual < rules.rest;
    if (report.sweeps >= kLeastSweeps && !sums.blocked && (near || rests)) break;
    if (leaps) leap(team, s, status);
  }
  return true;
}

/// Measures the contact, lets the wall flow, and takes the velocities.
template <class Real, class Team>
ANGIO_HOST_DEVICE inline void end_step(Team& team, const StepView<Real>& s,
                                       const PlasticFlow<Real>& plasticity, StepStatus& status) {
  status.volume = enclosed_volume(team, s);
  if (!(status.law.volume > 0.0)) status.pressure = pressure_at(status.law, status.volume);
  team.template for_each<1>(
      s.vertex_count, [&](int v, const auto&) { s.velocity[v] = (s.x[v] - s.x_before[v]) / s.dt; });
  if (!Team::kSurroundings || s.wall_count == 0) return;
  refresh(team, s);
  double total[3];
  team.template quick_sum<1, 3>(
      s.balloon_count + s.wall_count,
      [&](int v, const auto& lanes, auto* part) {
        VertexForces<Real> f;
        if (has_pairs<Team>(s)) add_contact(s, v, lanes, f);
        if (v >= s.balloon_count) {
          // Pairs across an edge pull aside against each other: what is left of them.
          s.contact_pressure[v - s.balloon_count] =
              norm(f.force - f.friction - f.adhesion - f.own) / s.area[v];
          return;
        }
        part[0] += f.touching_wall ? Real(1) : Real(0);
        if (v >= last_of_balloon(s)) return;
        part[1] += s.moves[v].friction;
        part[2] += s.moves[v].adhesion;
      },
      total);
  if (!s.paper.is_on) {  // else what the last sweep has projected
    status.report.contact_count = int(total[0]);
    status.report.friction_delta = total[1];
    status.report.viscous_delta = total[2];
  }
  if (s.wet)
    team.template for_each<1>(s.balloon_count + s.wall_count,
                              [&](int v, const auto&) { flow_film(s, v); });
  team.template for_each<Team::kClusterLanes>(
      s.cluster_count, [&](int c, const auto& lanes) { flow_cluster(s, plasticity, c, lanes); });
  if constexpr (Team::kSolids)
    team.template for_each<1>(s.wedge_count, [&](int w, const auto&) { flow_wedge(s, w); });
  team.barrier();
}

/// Takes a step, or goes on with one that has halted. @return false if it halts for new candidates
template <class Real, class Team>
ANGIO_HOST_DEVICE inline bool run_step(Team& team, const StepView<Real>& s, const StepRules& rules,
                                       const PlasticFlow<Real>& plasticity, StepStatus& status) {
  const double begin = team.now();
  StepTimes& times = status.report.times;
  if (status.stage == StepStage::begin) {
    begin_step(team, s, rules, status);
    status.stage = StepStage::foresight;
  }
  const bool begun = status.stage == StepStage::foresight;
  if (begun) {
    if (!search_pairs(team, s, status)) return false;
    foresee(team, s, rules, status);
    status.stage = StepStage::sweeps;
  }
  if (begun) times.rest += team.now() - begin - times.search;
  if (!run_sweeps(team, s, rules, status)) return false;
  const double swept = team.now();
  end_step(team, s, plasticity, status);
  times.rest += team.now() - swept;
  status.stage = StepStage::begin;
  return true;
}

}  // namespace angio::simulation::detail
