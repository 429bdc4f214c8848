#pragma once

#include <utility>
#include <vector>

#include "core/tet_mesh.hpp"
#include "simulation/pbd/tets.hpp"
#include "simulation/pbd/view.hpp"
#include "simulation/step/convert.hpp"

/// As step/make_views.hpp.
namespace angio::simulation::detail {

/// The reference method's gas.
template <class Real, class Memory>
PbdGas<Real> make_pbd_gas(const Scene& scene, Memory& memory) {
  const PbdGasTets tets = pbd_gas_tets(scene);
  std::vector<Real> inverse_mass;
  for (std::size_t v = 0; v < scene.mass.size(); ++v)
    inverse_mass.push_back(scene.fixed[v] ? Real(0) : Real(1.0 / scene.mass[v]));
  PbdGas<Real> gas;
  gas.is_on = true;
  gas.tet_count = int(tets.volume.size());
  gas.colors = int(tets.color_begin.size()) - 1;
  gas.color_begin = memory.store(tets.color_begin);
  gas.whole = tets.whole;
  gas.apex = memory.store(local<Real>(scene, tets.apex));
  gas.triangles = memory.store(tets.triangles);
  gas.inverse_mass = memory.store(inverse_mass);
  gas.volume = memory.store(converted_all<Real>(tets.volume));
  return gas;
}

/// The reference method's contact: the air tets between the surfaces, balloon vertices first.
template <class Real, class Memory>
PbdContact<Real> make_pbd_contact(const Scene& scene, const SimulationOptions& options,
                                  Memory& memory) {
  std::vector<Tet> air = scene.air;
  const auto at = [&](int v) { return scene.start[std::size_t(v)]; };
  for (Tet& t : air)
    if (tet_volume(at(t[0]), at(t[1]), at(t[2]), at(t[3])) < 0.0) std::swap(t[0], t[1]);
  const PbdTets tets = pbd_tets(scene, options, air);
  PbdContact<Real> contact;
  contact.is_on = true;
  contact.tet_count = int(tets.balloon_corners.size());
  contact.colors = int(tets.color_begin.size()) - 1;
  contact.color_begin = memory.store(tets.color_begin);
  contact.tets = memory.store(tets.vertices);
  contact.balloon_corners = memory.store(tets.balloon_corners);
  contact.inverse_mass = memory.store(converted_all<Real>(tets.inverse_mass));
  contact.triggered = memory.store(std::vector<char>(tets.balloon_corners.size(), 0));
  contact.volume_1 = Real(tets.volume_1);
  contact.volume_2 = Real(tets.volume_2);
  return contact;
}

template <class Real, class Memory>
PbdView<Real> make_pbd_view(const Scene& scene, const SimulationOptions& options, Memory& memory) {
  PbdView<Real> view;
  view.vertex_count = scene.vertex_count();
  if (projects_contact(scene, options))
    view.contact = make_pbd_contact<Real>(scene, options, memory);
  if (pbd_policy(options).gas) view.gas = make_pbd_gas<Real>(scene, memory);
  return view;
}

}  // namespace angio::simulation::detail
