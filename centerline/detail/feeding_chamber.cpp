#include "centerline/detail/feeding_chamber.hpp"

#include <algorithm>
#include <cstddef>

namespace angio::centerline {
namespace {

/// A vessel that leaves the chamber.
struct Stem {
  Vec3 mouth;     ///< where it leaves
  double radius;  ///< median depth beyond [mm]
};

double median_depth(const LumenVoxels& lumen, const int* first, const int* last) {
  std::vector<float> depth;
  for (; first != last; ++first) depth.push_back(lumen.depth[std::size_t(*first)]);
  const auto middle = depth.begin() + std::ptrdiff_t(depth.size() / 2);
  std::nth_element(depth.begin(), middle, depth.end());
  return double(*middle);
}

/// Both ends of a path that runs through the chamber, or the one of a path beside it.
void add_stems(const LumenVoxels& lumen, const std::vector<int>& path, const Vec3& middle,
               double reach, std::vector<Stem>& stems) {
  const auto is_inside = [&](int v) { return distance(lumen.position(v), middle) <= reach; };
  const auto first = std::find_if(path.begin(), path.end(), is_inside);
  if (first == path.end()) return;
  auto last = path.end();
  while (!is_inside(*(last - 1))) --last;
  const auto add = [&](auto begin, auto end, int mouth) {
    if (begin == end) return;
    const Vec3 place = lumen.position(mouth);
    const double radius = median_depth(lumen, &*begin, &*begin + (end - begin));
    for (Stem& stem : stems)
      if (distance(stem.mouth, place) < 2.0 * std::max(stem.radius, radius)) {
        stem.radius = std::max(stem.radius, radius);
        return;
      }
    stems.push_back({place, radius});
  };
  add(path.begin(), first, *first);
  add(last, path.end(), *(last - 1));
}

}  // namespace

std::optional<int> find_feeding_chamber(const LumenVoxels& lumen,
                                        const std::vector<std::vector<int>>& paths) {
  constexpr double kWider = 8.0, kChamber = 1.5;
  const auto deepest =
      std::size_t(std::max_element(lumen.depth.begin(), lumen.depth.end()) - lumen.depth.begin());
  const auto radius = double(lumen.depth[deepest]);
  const Vec3 middle = lumen.position(int(deepest));
  std::vector<Stem> stems;
  for (const std::vector<int>& path : paths)
    add_stems(lumen, path, middle, kChamber * radius, stems);
  if (stems.size() < 2) return std::nullopt;
  Vec3 mouths;
  for (const Stem& stem : stems) {
    if (radius < kWider * stem.radius) return std::nullopt;
    mouths += stem.mouth / double(stems.size());
  }
  // First where no vessel reaches, by its depth; then on to the wall.
  const auto farthest_from_mouths = [&](const Vec3& around, double reach, double least_depth) {
    int farthest = -1;
    for (int v = 0; v < lumen.count(); ++v) {
      const Vec3 at = lumen.position(v);
      if (double(lumen.depth[std::size_t(v)]) < least_depth || distance(at, around) > reach)
        continue;
      if (farthest < 0 || distance(at, mouths) > distance(lumen.position(farthest), mouths))
        farthest = v;
    }
    return farthest;
  };
  const double inner = 2.0 * radius / kWider;
  const int inside = farthest_from_mouths(middle, 2.0 * kChamber * radius, inner);
  return farthest_from_mouths(lumen.position(inside), 2.0 * inner, 0.0);
}

}  // namespace angio::centerline
