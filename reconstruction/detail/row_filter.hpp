#pragma once

#include "reconstruction/detail/fourier.hpp"
#include "reconstruction/detail/row_ends.hpp"

/// The ramp filter (ramp_filter.hpp) of a pair of rows by a team of threads: one is the real part,
/// one the imaginary part of the same transform, which a response that is real keeps apart.
namespace angio::reconstruction::detail {

/// What all rows of a run share.
struct RowFilter {
  int columns = 0;
  int beyond = 0;  ///< pixels by which a row goes on at each end
  int length = 0;  ///< of the transform, a power of two, >= columns + 4 beyond
  double spacing_mm = 1.0;
  const float* response = nullptr;  ///< in the order of frequency_at(), shape [length]
  const Complex* roots = nullptr;   ///< fourier_roots(length)
};

/// What the threads of a team share.
struct RowPairEnds {
  WaterEdge edges[2][2];  ///< [row][0: at its first pixel, 1: at its last]
  bool is_within_body[2][2];

  [[nodiscard]] ANGIO_HOST_DEVICE int truncated_rows() const {
    return int(is_within_body[0][0] || is_within_body[0][1]) +
           int(is_within_body[1][0] || is_within_body[1][1]);
  }
};

struct RowOfPair {
  const Complex* pair;
  bool is_second;
  ANGIO_HOST_DEVICE float operator()(int i) const { return is_second ? pair[i].im : pair[i].re; }
};

/// @param sample  line integrals of both rows at column i: sample(i)
/// @param weight  what they are multiplied by before they are filtered: weight(i)
/// @param put     takes both, filtered: put(i, values)
/// @param values  the team's, shape [filter.length]
template <class Team, class Sample, class Weight, class Put>
ANGIO_HOST_DEVICE void filter_row_pair(const Team& team, const RowFilter& filter,
                                       const Sample& sample, const Weight& weight, const Put& put,
                                       Complex* values, RowPairEnds& ends) {
  const int columns = filter.columns, beyond = filter.beyond;
  Complex* pair = values + beyond;
  const auto end = [&](int e) { return row_end(RowOfPair{pair, e / 2 == 1}, columns, e % 2 == 1); };
  team.each(columns, [&](int i) { pair[i] = sample(i); });
  team.each(4, [&](int e) { ends.is_within_body[e / 2][e % 2] = is_within_body(end(e)); });
  team.each(columns, [&](int i) {
    const Complex w = weight(i);
    pair[i] = {pair[i].re * w.re, pair[i].im * w.im};
  });
  team.each(4, [&](int e) { ends.edges[e / 2][e % 2] = water_edge(end(e), filter.spacing_mm); });
  team.each(filter.length - columns, [&](int i) {
    const auto at = [&](int side, int step) {
      return Complex{ends.edges[0][side].beyond(step, filter.spacing_mm),
                     ends.edges[1][side].beyond(step, filter.spacing_mm)};
    };
    if (i < beyond)
      pair[-1 - i] = at(0, i);
    else
      pair[columns + i - beyond] = i < 2 * beyond ? at(1, i - beyond) : Complex{};
  });
  convolve(team, values, filter.length, filter.response, filter.roots);
  team.each(columns, [&](int i) { put(i, pair[i]); });
}

}  // namespace angio::reconstruction::detail
