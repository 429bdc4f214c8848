#pragma once

#include <string>
#include <vector>

#include "core/progress.hpp"
#include "simulation/balloon_catalogue.hpp"
#include "simulation/simulation.hpp"

/// The free inflation test bench: a balloon alone, no vessel, held at pressures or volumes.
namespace angio::simulation {

/// How a free balloon ends.
enum class BalloonEnds {
  hemispheres,   ///< the whole balloon: its ends hold its shoulders back
  tube,          ///< a piece far from any end of an endless tube that is closed somewhere: its
                 ///< length is free and carries the pressure on the ends
  fixed_length,  ///< the same, its length held
};

/// A balloon as a cylinder with hemispherical ends, or as a piece of an endless one.
struct FreeBalloon {
  double radius_mm = 1.5;   ///< of the mid-surface, unloaded, [0.1, 50]; with a chart it must be
                            ///< half of rest_diameter_mm(material.chart)
  double length_mm = 15.0;  ///< of the cylindrical part, unloaded, [0.5, 500]
  BalloonMaterial material;
  BalloonEnds ends = BalloonEnds::hemispheres;  ///< length and volume of a piece are those of
                                                ///< length_mm of it

  /// @throws OptionError that names the field
  void validate() const;
};

/// The balloon of a catalogue entry, unloaded.
///
/// The entry's length is that of the cylindrical part before inflation; with a chart the radius is
/// half of its rest_diameter_mm, else half of the nominal diameter.
FreeBalloon free_balloon(const CatalogueBalloon& balloon);

enum class InflateSolver {
  newton,  ///< sparse Newton's method on the CPU: the reference
  vbd,     ///< vertex block descent, the solver of simulate(), in single precision
  paper,   ///< the seed paper's position based dynamics: not convergent, for comparison only
};

struct InflateOptions {
  std::vector<double> pressures_atm;  ///< above the outside, each in [0, 100]
  std::vector<double> volumes_mm3;    ///< enclosed, no less than the unloaded volume; either these
                                      ///< or the pressures are given
  int around = 24;  ///< vertices around the balloon, 8, 12, .. 256: the error of the
                    ///< diameter falls with its square
  /// Of the unbalanced force, relative, [0, 0.01]; vbd: also of the way still to go. 0: 1e-8 for
  /// newton, 1e-4 for vbd.
  double tolerance = 0.0;
  InflateSolver solver = InflateSolver::newton;
  Backend backend = Backend::automatic;  ///< of vbd

  [[nodiscard]] double tolerance_in_force() const;

  void validate() const;
};

/// One state of rest.
struct InflationPoint {
  double pressure_atm = 0.0;  ///< above the outside
  double diameter_mm = 0.0;   ///< at the middle, of the membrane's mid-surface
  double length_mm = 0.0;     ///< of the cylindrical part, between its ends' rings
  double volume_mm3 = 0.0;    ///< enclosed; the facets' times what it is in excess unloaded
  double wall_mm = 0.0;       ///< thickness of the membrane at the middle
  double stress_mpa = 0.0;    ///< greatest principal Cauchy stress at the middle, mean of the ring
  double energy_mj = 0.0;     ///< stored in the membrane [mJ]
  double residual = 0.0;      ///< unbalanced force over the forces that balance
  /// False: no state of rest was found. Under pressure the balloon then is past its limit point,
  /// and the other values are those of the last state before it (newton) or of where the solver
  /// stopped (vbd). The solver paper never is at rest.
  bool converged = false;
};

/// Finds the balloon's state of rest for every pressure or volume that is asked for, in that order.
///
/// Newton's method reaches each from the unloaded one through states of rest, so that under
/// pressure it is the one that a slow inflation meets first. Volumes go past a limit point,
/// pressures do not.
std::vector<InflationPoint> inflate(const FreeBalloon& balloon, const InflateOptions& options,
                                    const Progress& progress = {});

}  // namespace angio::simulation
