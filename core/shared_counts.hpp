#pragma once

#include <atomic>

#include "core/host_device.hpp"

/// Numbers in memory that many threads change at the same time, on the CPU or on the GPU. Who comes
/// first is not determined: what is put in a place by them must be sorted afterwards.
namespace angio {

/// number += by. @return the number before
ANGIO_HOST_DEVICE inline int add_to(int& number, int by) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(&number, by);
#else
  return std::atomic_ref(number).fetch_add(by, std::memory_order_relaxed);
#endif
}

/// number = value. @return the number before
ANGIO_HOST_DEVICE inline int exchange(int& number, int value) {
#if defined(__CUDA_ARCH__)
  return atomicExch(&number, value);
#else
  return std::atomic_ref(number).exchange(value, std::memory_order_relaxed);
#endif
}

/// number = max(number, value), where neither is negative: then floats are in order as their bits.
ANGIO_HOST_DEVICE inline void raise_to(float& number, float value) {
#if defined(__CUDA_ARCH__)
  if (value > number) atomicMax(reinterpret_cast<int*>(&number), __float_as_int(value));
#else
  std::atomic_ref most(number);
  float before = most.load(std::memory_order_relaxed);
  while (before < value && !most.compare_exchange_weak(before, value, std::memory_order_relaxed)) {
  }
#endif
}

}  // namespace angio
