#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/error.hpp"

/// Order statistics: each is one of the values, so it does not depend on their order.
namespace angio {

/// The value that a share of the others lie below: of n sorted ones, number floor(share (n - 1)).
///
/// @param values  not empty; taken by value, since they are put in another order
/// @param share   in [0, 1]
template <class Number>
Number quantile(std::vector<Number> values, double share) {
  ANGIO_EXPECT(!values.empty() && share >= 0.0 && share <= 1.0);
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The same; of no values `otherwise`.
template <class Number>
Number quantile(std::vector<Number> values, double share, Number otherwise) {
  return values.empty() ? otherwise : quantile(std::move(values), share);
}

/// The least value up to which a share of all weight lies.
///
/// @param weighted  pairs of value and weight, a weight > 0; taken by value, since they are sorted
/// @param share     in [0, 1]
template <class Number>
Number weighted_quantile(std::vector<std::pair<Number, double>> weighted, double share) {
  ANGIO_EXPECT(!weighted.empty() && share >= 0.0 && share <= 1.0);
  std::sort(weighted.begin(), weighted.end());
  double all = 0.0, below = 0.0;
  for (const auto& [value, weight] : weighted) all += weight;
  for (const auto& [value, weight] : weighted) {
    below += weight;
    if (below >= share * all) return value;
  }
  return weighted.back().first;
}

/// The middle value; the upper one of the two where their count is even.
///
/// @param values  not empty
template <class Number>
Number median(std::vector<Number> values) {
  ANGIO_EXPECT(!values.empty());
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace angio
