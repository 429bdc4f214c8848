#pragma once

#include <type_traits>
#include <vector>

#include "core/host_device.hpp"

namespace angio {

/// A run of values that another owns, in the computer's memory or in a device's: where it begins,
/// and how many there are. It converts to the pointer, so that a loop indexes it as one.
template <class Value>
struct ArrayView {
  Value* data = nullptr;
  int count = 0;

  ArrayView() = default;
  ANGIO_HOST_DEVICE ArrayView(Value* values, int size) : data(values), count(size) {}
  template <class Other>
  requires(std::is_same_v<const Other, Value>) ANGIO_HOST_DEVICE
      ArrayView(const ArrayView<Other>& other)
      : data(other.data), count(other.count) {}

  ANGIO_HOST_DEVICE operator Value*() const { return data; }
};

template <class Value>
ArrayView<const Value> view_of(const std::vector<Value>& values) {
  return {values.data(), int(values.size())};
}
template <class Value>
ArrayView<Value> view_of(std::vector<Value>& values) {
  return {values.data(), int(values.size())};
}

}  // namespace angio
