#pragma once

#include <vector>

#include "simulation/bodies/scene.hpp"
#include "simulation/pbd/policy.hpp"

/// The tets that the position-based reference method projects.
namespace angio::simulation::detail {

/// Does the reference method's contact act, and on a wall?
bool projects_contact(const Scene& scene, const SimulationOptions& options);

/// What the reference method's contact projects, colour by colour.
struct PbdTets {
  std::vector<int> vertices;  ///< four a tet, those of the balloon first, right-handed
  std::vector<int> balloon_corners;
  std::vector<int> color_begin;           ///< tet
  std::vector<double> inverse_mass;       ///< [1/g], shape [vertex]; 0: held
  double volume_1 = 0.0, volume_2 = 0.0;  ///< [mm^3]
};

/// @param air  right-handed tets
/// @throws InputError if there are none
PbdTets pbd_tets(const Scene& scene, const SimulationOptions& options, const std::vector<Tet>& air);

/// The viscous items of the tets that stay, as `now` has them.
///
/// @param triggered  shape [tet of `before`]
std::vector<char> kept_items(const PbdTets& before, const std::vector<char>& triggered,
                             const PbdTets& now);

/// The tets of the paper's gas: each triangle of the balloon with the guidewire's nearest node.
/// Those that enclose nothing at the start, at the ends, get no gas. Colour by colour.
struct PbdGasTets {
  std::vector<Vec3> apex;        ///< [mm], shape [tet]
  std::vector<int> triangles;    ///< three vertices a tet
  std::vector<double> volume;    ///< at the start [mm^3], > 0
  std::vector<int> color_begin;  ///< tet
  double whole = 0.0;            ///< what the balloon encloses then [mm^3]
};

/// @throws InputError if there is no guidewire
PbdGasTets pbd_gas_tets(const Scene& scene);

/// k sum Q / sum V over the tets: the pressure that a frame of the paper's gas reports [Pa].
///
/// @param growth  of their targets over their volumes at the start
double mean_tet_pressure(const PbdGasTets& tets, double growth, double outside,
                         const std::vector<Vec3>& x);

}  // namespace angio::simulation::detail
