#pragma once

#include <vector>

#include "core/vec3.hpp"

namespace angio::simulation::detail {

/// The quadratic columns of a slab's map, as functions phi_k of its members.
///
/// Mueller 2005, section 4.3, maps q~ = (x, y, z, x^2, y^2, z^2, xy, yz, zx) of a member's offset
/// q by a 3 x 9 matrix. Here the six squares and products are replaced by six combinations of them
/// that span the same shapes and are, weighted by the members' stiffness k, orthogonal to one
/// another, to x, y, z and to the constant (so that the centre stays the centre, which Mueller's do
/// not see to):
///
///     sum_i k_i phi_k(i) phi_l(i) = rho^2 sum_i k_i  if k = l, else 0;   rho^2 = mean of |q|^2
///
/// A coefficient so is a root-mean-square displacement over rho, a strain, and the best map needs
/// no 9 x 9 inverse. Combinations that vanish on all members, as x^2 + y^2 - r^2 does around a
/// round tube, are zero.
///
/// @param offset  q [mm], from the centre weighted by `weight`, shape [member]
/// @param weight  k > 0, shape [member]
/// @return phi [mm], shape [member][kShapeModes], rows first
std::vector<double> quadratic_modes(const std::vector<Vec3>& offset,
                                    const std::vector<double>& weight);

}  // namespace angio::simulation::detail
