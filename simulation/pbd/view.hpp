#pragma once

#include "simulation/pbd/contact.hpp"
#include "simulation/pbd/gas.hpp"
#include "simulation/step/array_role.hpp"

namespace angio::simulation::detail {

/// What the position-based reference method projects within a step.
template <class Real>
struct PbdView {
  int vertex_count = 0;
  PbdContact<Real> contact;
  PbdGas<Real> gas;

  [[nodiscard]] ANGIO_HOST_DEVICE bool is_on() const { return contact.is_on || gas.is_on; }
  /// Does it keep balloon and wall apart, in place of the barrier?
  [[nodiscard]] ANGIO_HOST_DEVICE bool parts_surfaces() const { return contact.is_on; }
  /// Does it fill the balloon, in place of the gas law?
  [[nodiscard]] ANGIO_HOST_DEVICE bool fills_balloon() const { return gas.is_on; }

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, contact.colors + 1, contact.color_begin);
    visit(ArrayRole::model, 4 * contact.tet_count, contact.tets);
    visit(ArrayRole::model, contact.tet_count, contact.balloon_corners);
    visit(ArrayRole::state, contact.tet_count, contact.triggered);
    visit(ArrayRole::model, gas.colors + 1, gas.color_begin);
    visit(ArrayRole::model, 3 * gas.tet_count, gas.triangles);
    visit(ArrayRole::model, gas.tet_count, gas.apex, gas.volume);
    visit(ArrayRole::model, vertex_count, contact.inverse_mass, gas.inverse_mass);
  }
};

}  // namespace angio::simulation::detail
