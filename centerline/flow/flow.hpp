#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "centerline/centerline.hpp"
#include "core/centerline.hpp"

/// Pressure and flow along a tree of vessels at full dilation of the small vessels behind it.
namespace angio::centerline {

/// The defaults are those of a coronary tree.
struct FlowOptions {
  double aortic_pressure_mmhg = 93.0;  ///< mean, at the inlet, [40, 200]
  double venous_pressure_mmhg = 5.0;   ///< behind the small vessels, [0, 30]
  /// Through the inlet of the healthy tree, [0, 2000]; 0: velocity times the inlet's healthy area.
  double inlet_flow_ml_min = 0.0;
  /// Mean over the section, [0.05, 2]. The one value of fixed-flow QFR: Tu et al., JACC Cardiovasc.
  /// Interv. 9(19), 2016.
  double hyperaemic_velocity_m_s = 0.35;
  /// n of Q ~ d^n at forks, [2, 4]; 3: Murray, Proc. Natl. Acad. Sci. 12(3), 1926,
  /// doi:10.1073/pnas.12.3.207.
  double branching_exponent = 3.0;
  double viscosity_mpa_s = 3.5;   ///< of blood, [0.5, 20]
  double density_kg_m3 = 1060.0;  ///< of blood, [900, 1200]
  /// Kt of the loss behind a throat, [0, 5]; 1.52: Young, Tsai 1973; 1: Borda, Carnot.
  double expansion_coefficient = 1.52;
  /// Standard deviation of diameters, all wrong alike, [0, 2]; unset: the voxel / sqrt(12), as in
  /// find_reference(), or kSurfaceError of a surface that shows no voxels.
  std::optional<double> diameter_error_mm;
  /// Standard deviation of the flow, [0, 90]. Our assumption: people's hyperaemic velocities are
  /// not known better than that from a picture.
  double flow_error_percent = 25.0;

  static constexpr double kSurfaceError = 0.1;  ///< [mm], our assumption

  void validate() const;  ///< @throws OptionError naming the field
};

/// A stretch of vessel between forks. All arrays have shape [point], two points at least.
struct FlowBranch {
  int parent = -1;               ///< the branch before; -1: it begins at the inlet
  std::vector<double> abscissa;  ///< [mm] from the inlet, not descending
  std::vector<double> radius;    ///< of a circle as large as the lumen [mm]; 0: not measured
  std::vector<double> healthy;   ///< the same without disease [mm], > 0
};

/// A point of a branch.
struct FlowPlace {
  std::size_t branch = 0, point = 0;
};

struct FlowTree {
  std::vector<FlowBranch> branches;           ///< parents before daughters, the inlet's first
  std::vector<std::vector<FlowPlace>> paths;  ///< where each point of each line lies; may be empty
};

/// The branches of a tree. The radius is sqrt(section area / pi), at least the tube's and at most
/// 1.5 of it (a larger section takes in a neighbour); the healthy one is find_reference()'s, whose
/// rule says, too, where nothing is measured: in branchings and at the lines' ends.
/// @param voxel_mm  as in find_reference()
FlowTree make_flow_tree(const CenterlineTree& tree, double voxel_mm);

/// The tree with the radii of a line as measured on its wall (measure_lumen), linear between the
/// profile's places. Before the first and behind the last of them, and where the tree has no
/// measure, nothing changes.
/// @param path  index of the line
FlowTree with_lumen(FlowTree tree, const CenterlinePath& line, std::size_t path,
                    const LumenProfile& profile);

/// Pressure and flow of one tree.
struct FlowSolution {
  std::vector<std::vector<double>> pressure_mmhg;  ///< shape [branch][point]
  std::vector<double> flow_ml_min;                 ///< shape [branch]
  bool converged = false;
};

/// What is told, and what would be told if one of the things that are not known were otherwise by
/// one standard deviation: all diameters less and more, the flow less and more.
struct FlowResult {
  FlowSolution best;
  std::array<FlowSolution, 4> varied;
  double inlet_flow_ml_min = 0.0;  ///< that the healthy tree would have
  double inlet_diameter_mm = 0.0;  ///< healthy
};

/// Steady flow through the tree, and through the small vessels behind each outlet.
///
///     p_in - p_out = Kv Q + K Q |Q|                                    along a branch
///     Kv = (8 mu / pi) integral of ds / r^4                            friction (Poiseuille)
///     K  = Kt (rho / 2) sum over throats (1 / A_throat - 1 / A_behind)^2
///     R_i = (Pa - Pv) / (w_i Q_healthy)                                behind outlet i
///     w_daughter = w_parent d^n / (sum over daughters of d^n)          healthy diameters d
///
/// Sources: friction and loss, Young, Tsai, J. Biomech. 6(4), 1973, 395-410,
/// doi:10.1016/0021-9290(73)90099-7, with the friction integrated along the vessel as in
/// Mirramezani, Shadden, Ann. Biomed. Eng., 2020 (the vessel of svZeroDSolver). The split is
/// Murray's. Where a throat begins and ends is our rule. The resistances are those of healthy
/// diameters, so that a treatment changes the lumen alone. Left out: what is got back where a
/// vessel widens (pressures are those of blood that flows as fast as in the vessel around), losses
/// at forks and in bends, entrance lengths, pulsation, side branches that the tree does not have.
///
/// A throat is the narrowest place since the vessel was last widest; it ends where the radius is
/// less than 95 % of the widest behind it. At a fork a throat opens into the healthy vessel.
/// Radii are linear between points; unmeasured ones between the measured ones of their branch,
/// healthy where there are none.
///
/// Newton's method on the whole tree, from the healthy flows: each step is a tree of resistors.
/// @param diameter_error_mm  of the image that the radii are from, where the options have none
/// @throws InputError  no branch, an array of another length, a number that is none, a radius < 0
/// @throws OptionError
FlowResult solve_flow(const FlowTree& tree, const FlowOptions& options, double diameter_error_mm);

/// A number of a result with its uncertainty.
struct Estimate {
  double value = 0.0;
  double low = 0.0, high = 0.0;  ///< one standard deviation away; of both causes, by their squares
};
Estimate estimate(const FlowResult& result,
                  const std::function<double(const FlowSolution&)>& number);

}  // namespace angio::centerline
