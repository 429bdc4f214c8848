#include "simulation/bodies/element_colors.hpp"

#include <algorithm>
#include <numeric>

namespace angio::simulation::detail {

ElementColors color_elements(const std::vector<int>& vertices, int corners, int vertex_count) {
  const auto width = std::size_t(corners), count = vertices.size() / width;
  std::vector<std::vector<char>> met(std::size_t(vertex_count), std::vector<char>{});
  std::vector<int> color(count, 0);
  int color_count = 0;
  for (std::size_t e = 0; e < count; ++e) {
    const auto begin = vertices.begin() + std::ptrdiff_t(width * e), end = begin + corners;
    const auto taken = [&](int c) {
      return std::any_of(begin, end, [&](int v) {
        const std::vector<char>& of_vertex = met[std::size_t(v)];
        return std::size_t(c) < of_vertex.size() && of_vertex[std::size_t(c)] != 0;
      });
    };
    while (taken(color[e])) ++color[e];
    color_count = std::max(color_count, color[e] + 1);
    for (auto v = begin; v != end; ++v) {
      std::vector<char>& of_vertex = met[std::size_t(*v)];
      of_vertex.resize(std::max(of_vertex.size(), std::size_t(color[e]) + 1), 0);
      of_vertex[std::size_t(color[e])] = 1;
    }
  }
  ElementColors result;
  result.order.resize(count);
  std::iota(result.order.begin(), result.order.end(), 0);
  std::stable_sort(result.order.begin(), result.order.end(),
                   [&](int a, int b) { return color[std::size_t(a)] < color[std::size_t(b)]; });
  result.begin.assign(std::size_t(color_count) + 1, 0);
  for (const int c : color) ++result.begin[std::size_t(c) + 1];
  std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
  return result;
}

}  // namespace angio::simulation::detail
