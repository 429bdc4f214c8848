#pragma once

#include <array>

#include "core/enum_names.hpp"
#include "meshing/meshing.hpp"

/// The words for the meshing's choices in TOML and on the command line.
namespace angio {

template <>
struct EnumNames<meshing::BalloonEnds> {
  static constexpr auto kNames = std::to_array({"cones", "hemispheres"});
};

}  // namespace angio
