#pragma once

#include <vector>

#include "core/host_device.hpp"

/// A Fourier transform of a power of two in one memory, for the GPU: each team of threads has a
/// pair of rows in the memory that it shares, so that they are read and written once. The same code
/// runs on the CPU, where the tests hold it against FFTW.
namespace angio::reconstruction::detail {

struct Complex {
  float re = 0.0F, im = 0.0F;
};
ANGIO_HOST_DEVICE inline Complex operator+(Complex a, Complex b) {
  return {a.re + b.re, a.im + b.im};
}
ANGIO_HOST_DEVICE inline Complex operator-(Complex a, Complex b) {
  return {a.re - b.re, a.im - b.im};
}
ANGIO_HOST_DEVICE inline Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
ANGIO_HOST_DEVICE inline Complex conjugate(Complex a) { return {a.re, -a.im}; }
/// i a
ANGIO_HOST_DEVICE inline Complex turned(Complex a) { return {-a.im, a.re}; }

/// Forward, decimation in frequency: within each block of `span` numbers
///
///     y_m = w^(m k) sum_n (-i)^(m n) x_n,   w = exp(-2 pi i / span),   x_n = x[k + n span / 4]
///
/// (Gentleman, Sande, Proc. AFIPS 29:563, 1966). After all passes the frequencies stand in the
/// order of frequency_at(); the passes backward take them from there.
///
/// @param butterfly  of length / 4
/// @param roots      exp(-2 pi i j / length), shape [3 length / 4]
ANGIO_HOST_DEVICE inline void pass_forward(Complex* x, int length, int span, int butterfly,
                                           const Complex* roots) {
  const int quarter = span / 4, k = butterfly % quarter, stride = length / span;
  Complex* a = x + (butterfly / quarter) * span + k;
  const Complex s02 = a[0] + a[2 * quarter], d02 = a[0] - a[2 * quarter],
                s13 = a[quarter] + a[3 * quarter], d13 = turned(a[quarter] - a[3 * quarter]);
  a[0] = s02 + s13;
  a[quarter] = (d02 - d13) * roots[k * stride];
  a[2 * quarter] = (s02 - s13) * roots[2 * k * stride];
  a[3 * quarter] = (d02 + d13) * roots[3 * k * stride];
}

/// Its adjoint: decimation in time, backward.
ANGIO_HOST_DEVICE inline void pass_backward(Complex* x, int length, int span, int butterfly,
                                            const Complex* roots) {
  const int quarter = span / 4, k = butterfly % quarter, stride = length / span;
  Complex* a = x + (butterfly / quarter) * span + k;
  const Complex y0 = a[0], y1 = a[quarter] * conjugate(roots[k * stride]),
                y2 = a[2 * quarter] * conjugate(roots[2 * k * stride]),
                y3 = a[3 * quarter] * conjugate(roots[3 * k * stride]);
  const Complex s02 = y0 + y2, d02 = y0 - y2, s13 = y1 + y3, d13 = turned(y1 - y3);
  a[0] = s02 + s13;
  a[quarter] = d02 + d13;
  a[2 * quarter] = s02 - s13;
  a[3 * quarter] = d02 - d13;
}

/// The last pass forward, and the first backward, where the length is no power of four.
ANGIO_HOST_DEVICE inline void pass_of_two(Complex* x, int pair) {
  const Complex a = x[2 * pair], b = x[2 * pair + 1];
  x[2 * pair] = a + b;
  x[2 * pair + 1] = a - b;
}

/// Multiplies the spectrum of numbers by a response, in place.
/// @param team      calls a function with each of [0, count), then waits for all: each(count, f)
/// @param x         shape [length], a power of two, >= 4
/// @param response  in the order of frequency_at(), over `length`
template <class Team>
ANGIO_HOST_DEVICE void convolve(const Team& team, Complex* x, int length, const float* response,
                                const Complex* roots) {
  int span = length;
  for (; span >= 4; span /= 4)
    team.each(length / 4, [&](int b) { pass_forward(x, length, span, b, roots); });
  if (span == 2) team.each(length / 2, [&](int pair) { pass_of_two(x, pair); });
  team.each(length, [&](int i) { x[i] = {x[i].re * response[i], x[i].im * response[i]}; });
  if (span == 2) team.each(length / 2, [&](int pair) { pass_of_two(x, pair); });
  for (span = span == 2 ? 8 : 4; span <= length; span *= 4)
    team.each(length / 4, [&](int b) { pass_backward(x, length, span, b, roots); });
}

/// exp(-2 pi i j / length), shape [3 length / 4].
std::vector<Complex> fourier_roots(int length);

/// The frequency that stands at a place after the passes forward, [0, length).
int frequency_at(int place, int length);

/// The least power of two from a length on, from 4 on.
int fourier_length(int least);

}  // namespace angio::reconstruction::detail
