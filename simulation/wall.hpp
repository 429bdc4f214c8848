#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/triangle_mesh.hpp"

/// The vessel's wall as a layered thick solid: intima, media, adventitia and plaque, nearly
/// incompressible, fibre-reinforced, able to yield; pre-stressed by the blood pressure under which
/// it was seen.
namespace angio::simulation {

/// Corners of a wedge: a triangle on the lumen's side, then the same triangle one layer further
/// out. The lumen-side triangle's normal leaves the lumen, so that the volume is positive.
using Wedge = std::array<int, 6>;

/// What a wedge is made of.
enum class WallRegion { intima = 0, media = 1, adventitia = 2, plaque = 3, calcium = 4 };
inline constexpr int kWallRegionCount = 5;
const char* name(WallRegion region);

/// See LayeredWall::tissue_ratio.
inline constexpr double kLeastTissueRatio = 1.0, kMostTissueRatio = 20.0;

/// The wall's solid mesh: copies of the lumen's surface, joined layer by layer.
struct LayeredWall {
  std::vector<Vec3> vertices;      ///< [mm]; the lumen surface's vertices come first, in its order
  std::vector<Wedge> wedges;       ///< vertex indices, shape [wedge]
  std::vector<int> layer;          ///< 0 next to the lumen, shape [wedge]
  std::vector<WallRegion> region;  ///< shape [wedge]
  std::vector<Vec3> axial;         ///< the vessel's direction there, unit, shape [wedge]
  /// Tissue that a wedge stands for, over its own volume, shape [wedge]; empty: 1. Where
  /// the mesh has no room for the wall's thickness, its energy counts as often as the thickness is
  /// missing: the membrane that it is carries what the wall would.
  std::vector<double> tissue_ratio;
  std::vector<Triangle> lumen_triangles;  ///< normals leave the lumen
  std::vector<Triangle> outer_triangles;  ///< normals leave the wall
  /// Held in place: 1 all, or the sum of 2, 4, 8 along x, y, z; shape [vertex]. In a simulation
  /// what SimulationModel::wall_fixed names stays held; any other column that is held here has
  /// no sound layers, and goes with the mean displacement of its neighbours.
  std::vector<char> fixed;
};

/// The law of one region: nearly incompressible, with two families of fibres at +- angle from the
/// circumference.
///
///     Psi = G/2 (I1' - 3) + sum_i k1 / (2 k2) (exp(k2 [(1 - rho)(I1' - 3)^2 + rho <I4_i - 1>^2]) -
///     1)
///           + K/2 ((J^2 - 1)/2 - ln J)
///
/// Source: Holzapfel, Gasser, Ogden, J. Elasticity 61 (2000), Eqs. 63-66 (rho = 1); Holzapfel,
/// Sommer, Gasser, Regitnig, Am. J. Physiol. 289 (2005) H2048, with its mu = G/2 and the sum over
/// both families. <x> = max(x, 0): fibres carry tension only.
struct WallRegionMaterial {
  double shear_kpa = 20.0;        ///< G of the matrix, [0.1, 1e6]
  double bulk_kpa = 5000.0;       ///< K, at least 5 G, up to 1e8
  double fiber_k1_kpa = 0.0;      ///< [0, 1e5]; 0: no fibres
  double fiber_k2 = 1.0;          ///< (0, 1000]
  double fiber_angle_deg = 0.0;   ///< from the circumference, [0, 90]
  double fiber_share = 1.0;       ///< rho, [0, 1]; 1 is the law of 2000
  double yield_kpa = 0.0;         ///< von Mises stress above which it flows, [0, 1e6]; 0: never
  double creep_per_s = 0.0;       ///< decay of what is above it [1/s], [0, 1e6]; 0: at once
  double density_g_mm3 = 1.1e-3;  ///< [1e-5, 0.1]
};

/// How the plaque is made.
enum class Plaque { fibrous, hypocellular, calcified, lipid };
const char* name(Plaque plaque);

/// The human left anterior descending artery's layers, the named plaque, and calcified plaque as
/// calcium (sources: docs/method/simulation.md).
std::array<WallRegionMaterial, kWallRegionCount> wall_materials(Plaque plaque = Plaque::fibrous);

struct WallOptions {
  std::array<WallRegionMaterial, kWallRegionCount> materials = wall_materials();
  double blood_pressure_kpa = 10.0;  ///< under which the wall was seen, [0, 50]
  double axial_stretch = 1.044;  ///< in place, of the unloaded wall (Holzapfel 2005), [0.9, 1.5]
  double foundation_kpa_per_mm = 10.0;  ///< surrounding tissue on the outer surface, [0, 1e5]

  void validate() const;
};

/// Where the wall is and what it remembers. Two quadrature points a wedge, the inner one first.
struct WallState {
  std::vector<Vec3> vertices;          ///< [mm]
  std::vector<Mat3> prestress;         ///< F0 at each point: unloaded to seen, shape [2 wedge]
  std::vector<Mat3> plastic;           ///< Fp at each point, det 1, shape [2 wedge]
  std::vector<double> plastic_strain;  ///< gathered equivalent log strain, shape [2 wedge]
};

struct WallSolution {
  WallState state;
  /// Of the shape from the wall's vertices, the largest [mm].
  double displacement_mm = 0.0;
  Vec3 place;             ///< of the vertex that has it, in the mesh's shape (prestress_wall only)
  double load = 1.0;      ///< share of the pressure that was reached (prestress_wall only)
  double residual = 0.0;  ///< unbalanced force over the forces that balance
  int iterations = 0;     ///< of Newton's method, all in all
  bool converged = false;
};

/// @throws InputError naming the vertex or wedge: not finite, out of range, inside out, flat,
///         without thickness, in pieces, nothing that holds it
void check_wall(const LayeredWall& wall, const WallOptions& options);

/// The unloaded wall: no pre-stress, no plastic strain, in the shape of the mesh.
WallState unloaded_state(const LayeredWall& wall);

/// Finds the stresses with which the wall is in balance in the shape of the mesh, under the blood
/// pressure and the axial stretch, without the surrounding tissue's help and nowhere above the
/// yield stress. It has converged if the wall leaves that shape by no more than 0.01 mm.
WallSolution prestress_wall(const LayeredWall& wall, const WallOptions& options);

/// The balance under another pressure in the lumen, from a state.
///
/// @param pressure_kpa  above that around the wall
/// @param time_s        for which regions that creep do so; 0: they only yield, as those without
///                      creep
WallSolution solve_wall(const LayeredWall& wall, const WallOptions& options, const WallState& start,
                        double pressure_kpa, double time_s = 0.0);

/// Stress and strain of one wedge or around one vertex.
struct WallStress {
  double principal_kpa = 0.0;        ///< largest principal Cauchy stress
  double circumferential_kpa = 0.0;  ///< Cauchy stress along the circumference
  double axial_kpa = 0.0;            ///< along the vessel
  double von_mises_kpa = 0.0;
  double log_strain = 0.0;      ///< largest principal, from the shape of the mesh
  double plastic_strain = 0.0;  ///< gathered equivalent log strain
  double volume_ratio = 1.0;    ///< J
};

struct WallFields {
  std::vector<WallStress> wedges;    ///< shape [wedge]
  std::vector<WallStress> vertices;  ///< means over the wedges around, by volume, shape [vertex]
};
WallFields wall_fields(const LayeredWall& wall, const WallOptions& options, const WallState& state);

/// A wall around a straight lumen along z, for tests and validation.
struct TubeWall {
  double length_mm = 2.0;
  int around = 24;  ///< vertices of a ring, >= 3
  int along = 4;    ///< rings less one, >= 1
  std::function<double(double angle, double z)> inner_radius_mm;
  std::function<double(double angle, double z)> outer_radius_mm;
  std::vector<double> layer_shares = {0.27, 0.36, 0.40};  ///< of the thickness, inside first
  std::vector<WallRegion> layer_regions = {WallRegion::intima, WallRegion::media,
                                           WallRegion::adventitia};
  char rim = 8;  ///< of LayeredWall::fixed for the first and last ring: held along z
};
LayeredWall make_tube_wall(const TubeWall& tube);

}  // namespace angio::simulation
