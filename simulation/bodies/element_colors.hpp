#pragma once

#include <vector>

namespace angio::simulation::detail {

/// An order of elements in which each colour is one run. No two of a colour share a vertex, so that
/// they can be worked on at once.
struct ElementColors {
  std::vector<int> order;     ///< the caller's element, shape [element]
  std::vector<int> begin{0};  ///< first of a colour in the new order, shape [color_count + 1]
};

/// Each element in turn gets the first colour that none of its vertices has met.
///
/// @param vertices  `corners` an element, below `vertex_count`
ElementColors color_elements(const std::vector<int>& vertices, int corners, int vertex_count);

/// Values of elements, `width` each, in the colours' order.
template <class Value>
std::vector<Value> in_order(const ElementColors& colors, const std::vector<Value>& values,
                            std::size_t width = 1) {
  std::vector<Value> result;
  result.reserve(values.size());
  for (const int e : colors.order)
    for (std::size_t k = 0; k < width; ++k)
      result.push_back(values[width * static_cast<std::size_t>(e) + k]);
  return result;
}

}  // namespace angio::simulation::detail
