#pragma once

#include "core/host_device.hpp"

namespace angio {

/// `yes` where the condition holds, else `no`: what a formula that is to run on packs of numbers
/// (core/simd.hpp has its overload for them) says in place of `? :`. Both are evaluated.
template <class Value>
ANGIO_HOST_DEVICE constexpr Value select(bool condition, const Value& yes, const Value& no) {
  return condition ? yes : no;
}

}  // namespace angio
