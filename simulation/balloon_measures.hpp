#pragma once

#include <vector>

#include "simulation/simulation.hpp"

/// What a balloon's shape tells.
namespace angio::simulation {

/// The sharpest edge of a surface.
struct SharpestFold {
  double angle_degrees = 0.0;  ///< between the normals of its triangles: 0 flat, 180 folded
  Vec3 place;                  ///< its middle [mm]
};

/// A taut balloon is round: an edge sharper than this is a kink. A cone meets the cylinder, and the
/// flat end its neck, at no more than 90 degrees.
inline constexpr double kKinkDegrees = 120.0;

/// Of the balloon's membrane, without the edges at what is tied to the shaft: there a cone bulges
/// over its neck.
///
/// @param fixed  shape [vertex]
SharpestFold sharpest_fold(const TriangleMesh& balloon, const std::vector<char>& fixed);

/// How far the distal neck has slid along the wire since the start [mm]: the mean over its vertices
/// of t . (x - x0), t the direction in which the guidewire ends. NaN where nothing slides.
///
/// @param balloon  positions, shape [balloon vertex]
double elongation_mm(const SimulationModel& model, const std::vector<Vec3>& balloon);

/// By how much the balloon is wider towards its ends than in the lesion [%]: a dog's bone.
///
///     100 (D_end - D_lesion) / D_end,   D_end the larger of frame.end_diameters_mm
///
/// Source: Wiesent et al., PLoS ONE 14(10), 2019, e0224026 (of stents, radially); here of the
/// balloon's sections. Negative where the lesion's section is the widest. NaN where no ends are
/// watched or the balloon has no section there.
double dogboning_percent(const SimulationFrame& frame);

/// A guidewire from its near end to its tip.
struct WholeWire {
  std::vector<Vec3> nodes;       ///< [mm]
  std::vector<char> in_balloon;  ///< shape [node]
};

/// The guidewire with what lies of it outside the balloon. That goes along with the pole that it
/// leaves, less and less along it, and its far end stays:
///
///     x(u) = x0(u) + (1 - 3 u^2 + 2 u^3) (x_pole - x0_pole),   u from 0 at the pole to 1
///
/// @param inside  nodes in the balloon in a frame, as many as model.guidewire
WholeWire whole_wire(const SimulationModel& model, const std::vector<Vec3>& inside);

}  // namespace angio::simulation
