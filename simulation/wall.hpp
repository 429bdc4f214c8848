#pragma once

#include <array>
#include <string>
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
enum class WallRegion { intima = 0, media = 1, adventitia = 2, plaque = 3 };
inline constexpr int kWallRegionCount = 4;
const char* name(WallRegion region);

/// The wall's solid mesh: copies of the lumen's surface, joined layer by layer.
struct LayeredWall {
  std::vector<Vec3> vertices;      ///< [mm]; the lumen surface's vertices come first, in its order
  std::vector<Wedge> wedges;       ///< vertex indices, shape [wedge]
  std::vector<int> layer;          ///< 0 next to the lumen, shape [wedge]
  std::vector<WallRegion> region;  ///< shape [wedge]
  std::vector<Vec3> axial;         ///< the vessel's direction there, unit, shape [wedge]
  std::vector<Triangle> lumen_triangles;  ///< normals leave the lumen
  std::vector<Triangle> outer_triangles;  ///< normals leave the wall
  std::vector<char> fixed;                ///< held in place (the region's rims), shape [vertex]
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
enum class Plaque { fibrous, hypocellular, calcified };
const char* name(Plaque plaque);

/// The human left anterior descending artery's layers and the named plaque (README: sources).
std::array<WallRegionMaterial, kWallRegionCount> wall_materials(Plaque plaque = Plaque::fibrous);

}  // namespace angio::simulation
