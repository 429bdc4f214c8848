#pragma once

#include <array>

#include "core/enum_names.hpp"
#include "simulation/cloth.hpp"
#include "simulation/simulation.hpp"
#include "simulation/wall.hpp"

/// How users write this stage's options.
namespace angio {

template <>
struct EnumNames<simulation::MembraneModel> {
  static constexpr std::array kNames{"automatic", "plain", "relaxed"};
};
template <>
struct EnumNames<simulation::WallShape> {
  static constexpr std::array kNames{"linear", "quadratic"};
};
template <>
struct EnumNames<simulation::WallModel> {
  static constexpr std::array kNames{"shape_matching", "layered"};
};
template <>
struct EnumNames<simulation::WallRegion> {
  static constexpr std::array kNames{"intima", "media", "adventitia", "plaque", "calcium"};
};
template <>
struct EnumNames<simulation::Plaque> {
  static constexpr std::array kNames{"fibrous", "hypocellular", "calcified", "lipid"};
};
template <>
struct EnumNames<simulation::ContactModel> {
  static constexpr std::array kNames{"barrier", "paper"};
};
template <>
struct EnumNames<simulation::GasModel> {
  static constexpr std::array kNames{"enclosed", "per_tet"};
};
template <>
struct EnumNames<simulation::GuidewireModel> {
  static constexpr std::array kNames{"none", "rod"};
};
template <>
struct EnumNames<simulation::GuidewireRest> {
  static constexpr std::array kNames{"straight", "placed"};
};
template <>
struct EnumNames<simulation::GuidewireTip> {
  static constexpr std::array kNames{"held", "free"};
};
template <>
struct EnumNames<simulation::InflationControl> {
  static constexpr std::array kNames{"gas", "pressure", "volume"};
};
template <>
struct EnumNames<simulation::ClothSolver> {
  static constexpr std::array kNames{"newton", "vbd"};
};

}  // namespace angio
