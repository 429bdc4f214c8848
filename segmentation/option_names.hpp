#pragma once

#include <array>

#include "core/enum_names.hpp"
#include "segmentation/read_volume.hpp"

/// How users write this stage's options.
namespace angio {

template <>
struct EnumNames<segmentation::AngleIncrements> {
  static constexpr std::array kNames{"from-base", "cumulative"};
};

}  // namespace angio
