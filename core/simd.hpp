#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

/// Several numbers worked on at once, by the compiler's vector extension, so that a formula written
/// once for `Real` runs on one number or on a pack of them. Every operation is that of IEEE 754 on
/// each lane: a pack gives the same bits as its lanes one by one, whatever the processor's width.
namespace angio {

template <class Scalar, int kLanes>
struct Pack {
  static_assert(sizeof(Scalar) * kLanes <= 64 && (kLanes & (kLanes - 1)) == 0);
  using Vector [[gnu::vector_size(sizeof(Scalar) * kLanes)]] = Scalar;
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::int32_t, std::int64_t>;
  using Mask [[gnu::vector_size(sizeof(Scalar) * kLanes)]] = Bits;

  Vector v{};

  Pack() = default;
  Pack(Scalar s) : v(s - Vector{}) {}  // NOLINT: every lane the same
  static Pack from(Vector vector) {
    Pack p;
    p.v = vector;
    return p;
  }
  static Pack load(const Scalar* memory) {
    Pack p;
    std::memcpy(&p.v, memory, sizeof p.v);
    return p;
  }
  void store(Scalar* memory) const { std::memcpy(memory, &v, sizeof v); }

  Scalar operator[](int lane) const { return v[lane]; }
  void set(int lane, Scalar value) { v[lane] = value; }

  Pack& operator+=(const Pack& b) { return v += b.v, *this; }
  Pack& operator-=(const Pack& b) { return v -= b.v, *this; }
  Pack& operator*=(const Pack& b) { return v *= b.v, *this; }
  Pack& operator/=(const Pack& b) { return v /= b.v, *this; }
  friend Pack operator+(Pack a, const Pack& b) { return a += b; }
  friend Pack operator-(Pack a, const Pack& b) { return a -= b; }
  friend Pack operator*(Pack a, const Pack& b) { return a *= b; }
  friend Pack operator/(Pack a, const Pack& b) { return a /= b; }
  friend Pack operator-(const Pack& a) { return from(-a.v); }
  friend Mask operator>(const Pack& a, const Pack& b) { return a.v > b.v; }
  friend Mask operator<(const Pack& a, const Pack& b) { return a.v < b.v; }

  /// `yes` in the lanes where the condition holds, else `no`.
  friend Pack select(Mask condition, const Pack& yes, const Pack& no) {
    return from(condition ? yes.v : no.v);
  }
  friend Pack sqrt(const Pack& a) {
    Pack r;
    for (int i = 0; i < kLanes; ++i) r.v[i] = std::sqrt(a.v[i]);
    return r;
  }
};

}  // namespace angio
