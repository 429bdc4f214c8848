#include "segmentation/detail/gaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/take_out.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kLongest = 5.0;        ///< [mm]
constexpr double kMostDiameters = 1.5;  ///< of the thinner vessel
constexpr double kLeastReach = 6.0;     ///< [voxels] around a tip
constexpr double kWider = 1.5;          ///< the next reach, where the vessel is too wide for one
constexpr double kFarthest = 45.0;      ///< [mm] the last reach
constexpr double kAhead = 0.1;          ///< of the reach: what is farther ahead,
constexpr double kMostAhead = 0.05;     ///< of all around a tip, at most
constexpr double kInLine = 0.77;        ///< cosine of the angle to the gap, between two ends,
constexpr double kAtFlank = 0.35;       ///< and where one may end at the flank of the other
constexpr double kMostWider = 2.0;      ///< than the other one

/// The voxels of two pieces that are nearest to each other.
struct Gap {
  std::size_t one = 0, other = 0;
  double length_mm = 0.0;
};

/// By the labels of the two pieces, the lesser first.
using Gaps = std::map<std::pair<std::int32_t, std::int32_t>, Gap>;

/// Voxels of a piece.
struct Part {
  std::vector<Vec3> places;
  Vec3 sum;
  void add(const Vec3& x) {
    places.push_back(x);
    sum += x;
  }
  [[nodiscard]] Vec3 middle() const { return sum / double(places.size()); }
  /// Of the disk across an axis that has their second moment [mm]: sqrt(2 <rho^2>).
  [[nodiscard]] double radius_across(const Vec3& axis) const {
    double squares = 0.0;
    for (const Vec3& x : places) {
      const Vec3 off = x - middle();
      squares += norm_squared(off - dot(off, axis) * axis);
    }
    return places.empty() ? 0.0 : std::sqrt(2.0 * squares / double(places.size()));
  }
};

/// Calls body(voxel) for the six voxels beside one.
template <class Body>
void for_each_beside(const VolumeGeometry& grid, std::size_t v, const Body& body) {
  const auto at = voxel_of(grid, v);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      auto there = at;
      there[axis] += side;
      if (grid.contains(there[0], there[1], there[2]))
        body(grid.offset(there[0], there[1], there[2]));
    }
}

class GapSearch {
 public:
  GapSearch(const VolumeGeometry& grid, Components pieces, double least_mm3)
      : grid_(grid), label_(std::move(pieces.label)) {
    for (const std::size_t count : pieces.voxel_count)
      is_large_.push_back(double(count) * voxel_volume(grid) >= least_mm3);
    is_large_.front() = false;
  }

  /// The shortest between each two large pieces, no longer than kLongest.
  [[nodiscard]] Gaps find_gaps() {
    std::vector<std::size_t> front;
    for (std::size_t v = 0; v < label_.size(); ++v)
      if (is_large(v) && is_at_border(v)) front.push_back(v);
    Gaps gaps;
    while (!front.empty()) {
      std::vector<std::size_t> next;
      for (const std::size_t v : front)
        for_each_beside(grid_, v, [&](std::size_t w) {
          if (label_[w] == 0) {
            const std::size_t source = source_of(v);
            if (2.0 * apart(source, w) > kLongest) return;
            label_[w] = -std::int32_t(source) - 1;
            next.push_back(w);
          } else if (label_[w] < 0 || is_large(w)) {
            keep_shortest(source_of(v), source_of(w), gaps);
          }
        });
      front = std::move(next);
    }
    return gaps;
  }

  /// The radius [mm] of a piece that ends at a voxel of its own towards a place, if it does.
  /// @param in_line  the least cosine between it and the way
  [[nodiscard]] std::optional<double> end_towards(std::size_t tip, const Vec3& place,
                                                  double in_line) const {
    const Vec3 at = place_of_voxel(grid_, tip);
    const Vec3 way = normalized(place - at);
    const double least = kLeastReach * mean_spacing(grid_);
    for (double reach = std::max(kLongest, least); reach < kFarthest; reach *= kWider) {
      const double slab = 0.5 * reach;
      Part front, behind;
      std::size_t ahead = 0, all = 0;
      for (const Vec3& x : places_around(tip, reach)) {
        const double depth = dot(at - x, way);
        ++all;
        ahead += depth < -kAhead * reach;
        if (depth >= -kAhead * reach && depth < slab)
          front.add(x);
        else if (depth >= slab)
          behind.add(x);
      }
      if (behind.places.empty() || double(ahead) > kMostAhead * double(all)) continue;
      const double radius = behind.radius_across(way);
      if (front.radius_across(way) > slab || radius > slab) continue;
      const bool is_in_line = dot(normalized(at - behind.middle()), way) >= in_line;
      return is_in_line ? std::optional(radius) : std::nullopt;
    }
    return {};
  }

 private:
  [[nodiscard]] bool is_large(std::size_t v) const {
    return label_[v] > 0 && is_large_[std::size_t(label_[v])];
  }
  /// The voxel of a piece from which another was reached.
  [[nodiscard]] std::size_t source_of(std::size_t v) const {
    return label_[v] < 0 ? std::size_t(-(label_[v] + 1)) : v;
  }
  [[nodiscard]] bool is_at_border(std::size_t v) const {
    bool is_border = false;
    for_each_beside(grid_, v, [&](std::size_t w) { is_border = is_border || label_[w] == 0; });
    return is_border;
  }
  [[nodiscard]] double apart(std::size_t v, std::size_t w) const {
    return distance(place_of_voxel(grid_, v), place_of_voxel(grid_, w));
  }
  void keep_shortest(std::size_t v, std::size_t w, Gaps& gaps) const {
    if (label_[v] > label_[w]) std::swap(v, w);
    const double length = apart(v, w);
    if (label_[v] == label_[w] || length > kLongest) return;
    const auto [entry, is_new] = gaps.try_emplace({label_[v], label_[w]}, Gap{v, w, length});
    if (!is_new && length < entry->second.length_mm) entry->second = {v, w, length};
  }
  /// The voxels of the piece of a voxel within a reach of it.
  [[nodiscard]] std::vector<Vec3> places_around(std::size_t tip, double reach) const {
    const Vec3 middle = place_of_voxel(grid_, tip);
    const auto at = voxel_of(grid_, tip);
    std::array<int, 3> low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      const int steps = int(std::ceil(reach / grid_.spacing[int(a)]));
      low[a] = std::max(0, at[a] - steps);
      high[a] = std::min(grid_.size[a] - 1, at[a] + steps);
    }
    std::vector<Vec3> places;
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const std::size_t v = grid_.offset(i, j, k);
          if (label_[v] != label_[tip]) continue;
          const Vec3 place = place_of_voxel(grid_, v);
          if (distance(place, middle) <= reach) places.push_back(place);
        }
    return places;
  }

  const VolumeGeometry& grid_;
  /// Of pieces, 0 outside; where a search has come, minus one less the voxel that it came from.
  std::vector<std::int32_t> label_;
  std::vector<bool> is_large_;  ///< shape [piece_count + 1]
};

/// Sets the voxels along a straight way, each beside the next.
void draw_way(Volume<std::uint8_t>& mask, const Gap& gap, std::uint8_t way) {
  auto at = voxel_of(mask.geometry, gap.one);
  const auto last = voxel_of(mask.geometry, gap.other);
  const Vec3 from = place_of_voxel(mask.geometry, gap.one);
  const Vec3 along = normalized(place_of_voxel(mask.geometry, gap.other) - from);
  while (at != last) {
    // Of the steps that lead on, the one that stays nearest to the straight line.
    auto best = at;
    double least = 1e30;
    for (std::size_t a = 0; a < 3; ++a) {
      if (at[a] == last[a]) continue;
      auto there = at;
      there[a] += last[a] > at[a] ? 1 : -1;
      const Vec3 off =
          place_of_voxel(mask.geometry, mask.geometry.offset(there[0], there[1], there[2])) - from;
      const double aside = norm(off - dot(off, along) * along);
      if (aside < least) {
        least = aside;
        best = there;
      }
    }
    at = best;
    std::uint8_t& value = mask.at(at[0], at[1], at[2]);
    if (value == 0) value = way;
  }
}

}  // namespace

void part_passing_vessels(Volume<std::uint8_t>& mask, std::uint8_t way, double least_mm3) {
  const VolumeGeometry& grid = mask.geometry;
  Volume<std::uint8_t> vessels(grid), ways(grid);
  for (std::size_t v = 0; v < mask.values.size(); ++v) {
    ways.values[v] = mask.values[v] == way;
    vessels.values[v] = mask.values[v] != 0 && mask.values[v] != way;
  }
  const Components pieces = label_components(vessels, Connectivity::faces);
  GapSearch search(grid, pieces, least_mm3);
  std::set<std::pair<std::int32_t, std::int32_t>> passing;
  for (const auto& [pair, gap] : search.find_gaps()) {
    const Vec3 one = place_of_voxel(grid, gap.one), other = place_of_voxel(grid, gap.other);
    if (!search.end_towards(gap.one, other, kAtFlank) &&
        !search.end_towards(gap.other, one, kAtFlank))
      passing.insert(pair);
  }
  if (passing.empty()) return;
  // Ways between two of them, and no third one.
  const Components links = label_components(ways, Connectivity::faces);
  std::vector<std::set<std::int32_t>> linked(links.voxel_count.size());
  for (std::size_t v = 0; v < mask.values.size(); ++v)
    if (links.label[v] > 0)
      for_each_beside(grid, v, [&](std::size_t w) {
        if (pieces.label[w] > 0) linked[std::size_t(links.label[v])].insert(pieces.label[w]);
      });
  for (std::size_t v = 0; v < mask.values.size(); ++v) {
    const std::set<std::int32_t>& ends = linked[std::size_t(links.label[v])];
    if (ends.size() == 2 && passing.contains({*ends.begin(), *ends.rbegin()})) mask.values[v] = 0;
  }
}

void join_across_gaps(Volume<std::uint8_t>& mask, std::uint8_t way, double least_mm3) {
  GapSearch search(mask.geometry, label_components(mask, Connectivity::faces), least_mm3);
  for (const auto& [pieces, gap] : search.find_gaps()) {
    const auto one = search.end_towards(gap.one, place_of_voxel(mask.geometry, gap.other), kInLine);
    if (!one) continue;
    const auto other =
        search.end_towards(gap.other, place_of_voxel(mask.geometry, gap.one), kInLine);
    if (!other) continue;
    const auto [thin, wide] = std::minmax(*one, *other);
    if (wide > kMostWider * thin || gap.length_mm > kMostDiameters * 2.0 * thin) continue;
    draw_way(mask, gap, way);
  }
}

}  // namespace angio::segmentation::detail
