#pragma once

#include "core/host_device.hpp"

/// Which vertices belong to which body. All that asks of a vertex where it belongs asks here.
namespace angio::simulation::detail {

/// The bodies of a scene, in the order of their vertices.
enum class Body { balloon, wall, guidewire };
inline constexpr int kBodyCount = 3;

/// A body's vertices that may touch: from `first` on.
struct BodyRange {
  int first = 0, count = 0;

  [[nodiscard]] ANGIO_HOST_DEVICE int end() const { return first + count; }
};

/// The bodies of a scene one after the other; one that is not there has no vertices. The outer
/// copies of a layered wall stand between the wall and the next body.
struct BodyRanges {
  BodyRange ranges[kBodyCount];

  ANGIO_HOST_DEVICE BodyRange& operator[](Body body) { return ranges[int(body)]; }
  ANGIO_HOST_DEVICE const BodyRange& operator[](Body body) const { return ranges[int(body)]; }
  [[nodiscard]] ANGIO_HOST_DEVICE const BodyRange& balloon() const {
    return (*this)[Body::balloon];
  }
  [[nodiscard]] ANGIO_HOST_DEVICE const BodyRange& wall() const { return (*this)[Body::wall]; }
  [[nodiscard]] ANGIO_HOST_DEVICE const BodyRange& guidewire() const {
    return (*this)[Body::guidewire];
  }

  /// The body that a vertex belongs to; of a layered wall, whatever the level.
  [[nodiscard]] ANGIO_HOST_DEVICE Body of(int v) const {
    int body = 0;
    while (body + 1 < kBodyCount && v >= ranges[body + 1].first) ++body;
    return Body(body);
  }
  /// Balloon and wall: their vertices come first.
  [[nodiscard]] ANGIO_HOST_DEVICE int surface_count() const { return wall().end(); }
  /// The vertices that may touch something.
  [[nodiscard]] ANGIO_HOST_DEVICE int contact_count() const {
    int count = 0;
    for (const BodyRange& range : ranges) count += range.count;
    return count;
  }
  /// @param i  in [0, contact_count())
  [[nodiscard]] ANGIO_HOST_DEVICE int contact_vertex(int i) const {
    int body = 0;
    while (body + 1 < kBodyCount && i >= ranges[body].count) i -= ranges[body++].count;
    return ranges[body].first + i;
  }
};

/// May two bodies touch? Everything touches the balloon, and nothing else.
ANGIO_HOST_DEVICE inline bool may_touch(Body a, Body b) {
  return (a == Body::balloon) != (b == Body::balloon);
}

/// The most of the sums of two bodies' values, over the pairs of bodies that may touch.
template <class Real>
ANGIO_HOST_DEVICE inline Real most_of_pairs(const Real (&value)[kBodyCount]) {
  Real most = 0;
  for (int a = 0; a < kBodyCount; ++a)
    for (int b = a + 1; b < kBodyCount; ++b)
      if (may_touch(Body(a), Body(b)) && value[a] + value[b] > most) most = value[a] + value[b];
  return most;
}

/// The most of the values of the bodies that may touch this one.
template <class Real>
ANGIO_HOST_DEVICE inline Real most_of_others(const Real (&value)[kBodyCount], Body body) {
  Real most = 0;
  for (int b = 0; b < kBodyCount; ++b)
    if (may_touch(body, Body(b)) && value[b] > most) most = value[b];
  return most;
}

template <class Real>
ANGIO_HOST_DEVICE inline Real most_of(const Real (&value)[kBodyCount]) {
  Real most = 0;
  for (const Real one : value) most = one > most ? one : most;
  return most;
}

}  // namespace angio::simulation::detail
