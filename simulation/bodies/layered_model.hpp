#pragma once

#include <vector>

#include "simulation/materials/solid.hpp"
#include "simulation/wall.hpp"

namespace angio::simulation::detail {

/// The wall's solid as arrays: what does not change, and the points as a state makes them.
struct SolidModel {
  std::vector<int> corners;                     ///< [wedge][6]
  std::vector<int> region;                      ///< [wedge]
  std::vector<SolidPoint<double>> mesh_points;  ///< of the mesh's shape, shape [2 wedge]
  std::vector<SolidPoint<double>> points;       ///< with pre-stress and plastic stretch
  std::vector<int> patch;                       ///< shape [wedge]
  std::vector<int> patch_begin, patch_wedges;   ///< wedges that share one dilatation
  std::vector<double> patch_volume;             ///< unloaded [mm^3]
  std::vector<double> patch_bulk;               ///< K, times the tissue ratio [Pa]
  std::vector<double> tissue_ratio;             ///< shape [wedge]
  std::vector<double> volume;                   ///< unloaded [mm^3], shape [wedge]
  std::vector<Vec3> fibers;                     ///< [wedge][2], unit
  std::vector<Vec3> around;                     ///< the circumference's direction, shape [wedge]
  std::vector<SolidLaw<double>> laws;           ///< shape [region]
  std::vector<double> mass;                     ///< [g], shape [vertex]
  std::vector<double> foundation;               ///< springs to the mesh's shape [uN/mm], [vertex]

  [[nodiscard]] SolidView<double> view(const Vec3* x) const;
  [[nodiscard]] int wedge_count() const { return static_cast<int>(region.size()); }
  [[nodiscard]] int patch_count() const { return static_cast<int>(patch_volume.size()); }
};

/// @param wall  as check_wall takes it
SolidModel make_solid_model(const LayeredWall& wall, const WallOptions& options);

/// Multiplies a state's pre-stress and plastic stretch into the points.
void set_memory(const WallState& state, SolidModel& model);

/// The corners of a wedge.
std::array<Vec3, 6> corners_of(const SolidModel& model, int wedge, const std::vector<Vec3>& x);

/// Lets every point flow at the positions of the state (solid_flow.hpp) and renews the model's
/// points.
/// @return the largest equivalent strain that was added
double flow(SolidModel& model, WallState& state, double dt);

/// Stress and strain of the wedges at the positions of the state.
std::vector<WallStress> wedge_stresses(const SolidModel& model, const LayeredWall& wall,
                                       const WallState& state);

/// Of the points' plastic strain, shape [wedge][kWedgePoints], the wedges' means.
std::vector<double> wedge_plastic_strain(const SolidModel& model,
                                         const std::vector<double>& plastic_strain);

/// Of the wedges' values the means over those around each vertex, by their volume.
std::vector<double> vertex_means(const SolidModel& model, const LayeredWall& wall,
                                 const std::vector<double>& of_wedges);

/// Stress and strain at the positions of the state, of wedges and vertices.
WallFields fields(const SolidModel& model, const LayeredWall& wall, const WallState& state);

}  // namespace angio::simulation::detail
