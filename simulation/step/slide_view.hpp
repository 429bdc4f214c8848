#pragma once

#include "core/host_device.hpp"
#include "core/vec3.hpp"
#include "simulation/step/array_role.hpp"

/// What slides along the guidewire: the balloon's distal neck.
namespace angio::simulation::detail {

/// What acts on one vertex of the neck along the wire.
template <class Real>
struct SlideLoad {
  Real force{};      ///< [uN]
  Real stiffness{};  ///< [uN/mm]
  Real by_volume{};  ///< [mm^2]
  Real magnitude{};  ///< of the contact on it [uN]
  Real share{};      ///< of the move that its bounds let it take
};

/// Vertices that move as one body along a line: one unknown.
template <class Real>
struct SlideView {
  int count = 0;                     ///< 0: nothing slides
  Vec3T<Real> along;                 ///< unit
  const int* vertices = nullptr;     ///< [count]
  SlideLoad<Real>* loads = nullptr;  ///< [count]

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, count, vertices);
    visit(ArrayRole::work, count, loads);
  }
};

}  // namespace angio::simulation::detail
