#include "segmentation/detail/bodies.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace angio::segmentation::detail {
namespace {

/// Sets that can be united.
class Sets {
 public:
  std::int32_t add() {
    parent_.push_back(std::int32_t(parent_.size()));
    return parent_.back();
  }
  std::int32_t root(std::int32_t n) {
    while (parent_[std::size_t(n)] != n)
      n = parent_[std::size_t(n)] = parent_[std::size_t(parent_[std::size_t(n)])];
    return n;
  }
  void hang(std::int32_t below, std::int32_t above) { parent_[std::size_t(below)] = above; }
  [[nodiscard]] std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::int32_t> parent_;
};

/// Voxels of the mask, deepest first.
std::vector<std::uint32_t> by_depth(const Volume<float>& depth) {
  std::vector<std::uint32_t> order;
  for (std::size_t v = 0; v < depth.values.size(); ++v)
    if (depth.values[v] > 0.0f) order.push_back(std::uint32_t(v));
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return depth.values[a] != depth.values[b] ? depth.values[a] > depth.values[b] : a < b;
  });
  return order;
}

}  // namespace

Bodies part_into_bodies(const Volume<float>& depth, double least_depth_mm, double neck_share) {
  const VolumeGeometry& grid = depth.geometry;
  const auto ni = std::size_t(grid.size[0]), nj = std::size_t(grid.size[1]);
  Bodies bodies;
  bodies.label.assign(depth.values.size(), 0);
  Sets sets;
  sets.add();  // 0 is outside
  std::vector<float> peak{0.0f};
  std::vector<Bodies::Neck> necks;
  for (const std::uint32_t v : by_depth(depth)) {
    const std::array<int, 3> at{int(v % ni), int(v / ni % nj), int(v / ni / nj)};
    std::array<std::int32_t, 26> beside{};
    std::size_t count = 0;
    std::int32_t uphill = 0;  // the body of the deepest voxel beside this one
    float deepest = 0.0f;
    for (int dk = -1; dk <= 1; ++dk)
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          if (!grid.contains(at[0] + di, at[1] + dj, at[2] + dk)) continue;
          const std::size_t w = grid.offset(at[0] + di, at[1] + dj, at[2] + dk);
          if (bodies.label[w] == 0) continue;
          const std::int32_t root = sets.root(bodies.label[w]);
          if (depth.values[w] > deepest) {
            deepest = depth.values[w];
            uphill = root;
          }
          if (std::find(beside.begin(), beside.begin() + count, root) == beside.begin() + count)
            beside[count++] = root;
        }
    const float here = depth.values[v];
    if (count == 0) {
      bodies.label[v] = sets.add();
      peak.push_back(here);
      continue;
    }
    bodies.label[v] = uphill;
    for (std::size_t n = 0; n < count; ++n) {
      std::int32_t less = sets.root(beside[n]), more = sets.root(uphill);
      if (less == more) continue;
      if (peak[std::size_t(less)] > peak[std::size_t(more)]) std::swap(less, more);
      if (const float lower = peak[std::size_t(less)];
          lower >= float(least_depth_mm) && here >= float(neck_share) * lower)
        sets.hang(less, more);
      else
        necks.push_back({less, more, here});
    }
  }

  std::vector<std::int32_t> number(sets.size(), 0);
  bodies.depth_mm.push_back(0.0f);
  for (std::size_t n = 1; n < number.size(); ++n)
    if (sets.root(std::int32_t(n)) == std::int32_t(n)) {
      number[n] = std::int32_t(bodies.depth_mm.size());
      bodies.depth_mm.push_back(peak[n]);
    }
  for (std::int32_t& label : bodies.label) label = number[std::size_t(sets.root(label))];
  // The deepest neck of each pair alone is wanted; pairs come deepest first.
  for (Bodies::Neck& neck : necks) {
    neck.one = number[std::size_t(sets.root(neck.one))];
    neck.other = number[std::size_t(sets.root(neck.other))];
    if (neck.one > neck.other) std::swap(neck.one, neck.other);
  }
  std::stable_sort(necks.begin(), necks.end(), [](const auto& a, const auto& b) {
    return std::pair(a.one, a.other) < std::pair(b.one, b.other);
  });
  for (std::size_t n = 0; n < necks.size(); ++n)
    if (necks[n].one != necks[n].other &&
        (n == 0 || necks[n].one != necks[n - 1].one || necks[n].other != necks[n - 1].other))
      bodies.necks.push_back(necks[n]);
  std::stable_sort(bodies.necks.begin(), bodies.necks.end(),
                   [](const auto& a, const auto& b) { return a.depth_mm > b.depth_mm; });
  return bodies;
}

void spread(const Bodies& bodies, std::vector<Tissue>& tissues) {
  Sets sets;
  std::vector<Tissue> of_set(tissues);
  for (std::size_t n = 0; n < tissues.size(); ++n) sets.add();
  for (const Bodies::Neck& neck : bodies.necks) {
    const std::int32_t a = sets.root(neck.one), b = sets.root(neck.other);
    Tissue& of_a = of_set[std::size_t(a)];
    const Tissue of_b = of_set[std::size_t(b)];
    if (a == b || (of_a != Tissue::unknown && of_b != Tissue::unknown && of_a != of_b)) continue;
    sets.hang(b, a);
    if (of_a == Tissue::unknown) of_a = of_b;
  }
  for (std::size_t n = 1; n < tissues.size(); ++n)
    tissues[n] = of_set[std::size_t(sets.root(std::int32_t(n)))];
}

}  // namespace angio::segmentation::detail
