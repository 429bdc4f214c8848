#pragma once

#include "simulation/materials/gas.hpp"
#include "simulation/step/leap.hpp"
#include "simulation/step/views.hpp"

/// What drives a step, what outlives it, and what it reports.
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
  /// From this many on a frame whose balloon is slack ends within kLaterResidual, as soon as a
  /// sweep moves it by less than the tolerance: where a membrane without tension lies is not
  /// determined, and sweeps push it about without end.
  int slack_sweeps = 1 << 30;
  /// A frame that is so far off balance that it is no result gets up to this many, until it is not;
  /// with a rod the first one until it is within kLaterResidual.
  int last_sweeps = 0;
  double least_load = 0.0;  ///< pressure [Pa] against which a slack balloon's forces are measured
  bool still = false;       ///< no inertia, no prediction: equilibria
};

inline constexpr double kLaterLag = 4.0, kLaterResidual = 0.05;
/// A balloon is slack as long as more than this share of its vertices is not taut.
inline constexpr double kSlackShare = 0.75;
/// A residual from which on a frame is off balance (success.hpp), less a margin.
inline constexpr double kOffBalance = 0.2, kBalanceMargin = 0.75;

/// Where the time of a step goes [s].
struct StepTimes {
  double search = 0.0;               ///< of near pairs
  double refresh = 0.0;              ///< of pairs, slabs and goals
  double balloon = 0.0, wall = 0.0;  ///< sweeps
  double rest = 0.0;                 ///< begin and end of the step
};

/// What a step reports.
struct StepReport {
  double residual = 0.0;        ///< net force over load, root of sums of squares
  double lag = 0.0;             ///< estimated distance from equilibrium over the radius
  double friction_delta = 0.0;  ///< docs/method/simulation.md [mm]
  double viscous_delta = 0.0;   ///< docs/method/simulation.md [mm]
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
  int since_search = 0;      ///< sweeps
  bool blocked = false;      ///< a vertex has met its bound in the last sweep
  bool halted = false;       ///< for want of candidates
  bool wall_rests = false;   ///< a layered one that is left alone: in balance, and no pair is near
  bool has_stepped = false;  ///< the start shape, which no forces have made, is behind
  double tet_growth = 1.0;   ///< of the paper's gas: targets over volumes at the start
  StepStage stage = StepStage::begin;
  int frame = 0;  ///< that is under way or has ended
};

}  // namespace angio::simulation::detail
