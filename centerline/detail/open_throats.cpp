#include "centerline/detail/open_throats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <unordered_map>
#include <vector>

#include "centerline/detail/lumen_voxels.hpp"

namespace angio::centerline {
namespace {

using Index = std::array<int, 3>;

Index nearest_voxel(const VolumeGeometry& grid, const Vec3& place) {
  const Vec3 at = grid.index_from_lps(place);
  return {int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
}

bool is_within(const VolumeGeometry& grid, const Index& at) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (at[axis] < 1 || at[axis] >= grid.size[axis] - 1) return false;
  return true;
}

Vec3 centre(const VolumeGeometry& grid, const Index& at) {
  return grid.lps_from_index({double(at[0]), double(at[1]), double(at[2])});
}

Index beside(const Index& at, std::size_t n) {
  const auto& offset = kNeighborOffsets[n];
  return {at[0] + offset[0], at[1] + offset[1], at[2] + offset[2]};
}

/// Voxels outside the level set that hold the middle of a ray across the lumen, with the middle.
using MiddleOf = std::map<Index, Vec3>;

/// Places of a triangle, in rows along its longest side, at most `apart` from each other.
template <class Use>
void for_each_place(const TriangleMesh& mesh, const Triangle& corners, double apart, Use&& use) {
  std::array<Vec3, 3> p;
  for (std::size_t c = 0; c < 3; ++c) p[c] = mesh.vertices[std::size_t(corners[c])];
  for (int turn = 0; turn < 2; ++turn)  // the longest side from p[0] to p[1]
    if (distance(p[0], p[1]) < std::max(distance(p[1], p[2]), distance(p[2], p[0])))
      std::rotate(p.begin(), p.begin() + 1, p.end());
  const double side = distance(p[0], p[1]);
  const auto parts_of = [&](double length) { return std::max(1, int(std::ceil(length / apart))); };
  const int rows = parts_of(norm(area_vector_doubled(mesh, corners)) / side);
  for (int r = 0; r < rows; ++r) {
    const double up = (r + 0.5) / rows;
    const int count = parts_of((1.0 - up) * side);
    for (int i = 0; i < count; ++i)
      use(p[0] + up * (p[2] - p[0]) + ((1.0 - up) * (i + 0.5) / count) * (p[1] - p[0]));
  }
}

/// Whether a wall that turns its inside to a place lies all around it. Beside a wall that is torn
/// or turned inside out, none does.
bool is_enclosed(const SurfaceWall& wall, const Vec3& place, double farthest) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Vec3 direction;
      direction[axis] = sign;
      const double away = wall.ray(place, direction, farthest);
      if (away <= 0.0 || away >= farthest) return false;
    }
  return true;
}

MiddleOf find_middles(const Volume<float>& level_set, const SurfaceWall& wall, double least_mm) {
  constexpr double kThin = 2.5, kSlit = 0.25, kApart = 0.5;  // voxels
  const VolumeGeometry& grid = level_set.geometry;
  const double voxel = grid.spacing.x;
  const TriangleMesh& mesh = wall.mesh();
  const double farthest = voxel * (grid.size[0] + grid.size[1] + grid.size[2]);
  MiddleOf middles;
  for (const Triangle& corners : mesh.triangles) {
    const Vec3 area = area_vector_doubled(mesh, corners);
    if (norm_squared(area) == 0.0) continue;
    const Vec3 inward = -normalized(area);
    for_each_place(mesh, corners, kApart * voxel, [&](const Vec3& place) {
      // Where the lumen is wide its voxels are there.
      const Index inside = nearest_voxel(grid, place + voxel * inward);
      if (!is_within(grid, inside) || level_set.at(inside[0], inside[1], inside[2]) < 0.0F) return;
      const Vec3 from = place + 1e-6 * voxel * inward;
      const double across = wall.ray(from, inward, kThin * voxel);
      if (across <= std::max(kSlit * voxel, least_mm) || across >= kThin * voxel) return;
      const Vec3 middle = from + 0.5 * across * inward;
      const Index at = nearest_voxel(grid, middle);
      if (is_within(grid, at) && level_set.at(at[0], at[1], at[2]) >= 0.0F &&
          middles.count(at) == 0 && is_enclosed(wall, middle, farthest))
        middles.emplace(at, middle);
    });
  }
  return middles;
}

/// The part of the lumen that each of its voxels belongs to, by links, found as it is asked for.
class Parts {
 public:
  static constexpr int kCrumb = -1;  ///< too small a part to be one

  explicit Parts(const Volume<float>& level_set) : level_set_(level_set) {}

  int of(const Index& at) {
    constexpr std::size_t kLeast = 30;  // voxels
    if (const auto known = part_.find(key(at)); known != part_.end()) return known->second;
    const int part = count_++;
    std::vector<Index> all{at};
    part_[key(at)] = part;
    for (std::size_t n = 0; n < all.size(); ++n) {
      const std::uint32_t links = find_links(level_set_, all[n]);
      for (std::size_t k = 0; k < kNeighborOffsets.size(); ++k)
        if ((links >> k & 1U) != 0 && part_.emplace(key(beside(all[n], k)), part).second)
          all.push_back(beside(all[n], k));
    }
    if (all.size() >= kLeast) return part;
    for (const Index& crumb : all) part_[key(crumb)] = kCrumb;
    return kCrumb;
  }

 private:
  [[nodiscard]] std::int64_t key(const Index& at) const {
    const auto& size = level_set_.geometry.size;
    return (std::int64_t(at[2]) * size[1] + at[1]) * size[0] + at[0];
  }
  const Volume<float>& level_set_;
  std::unordered_map<std::int64_t, int> part_;
  int count_ = 0;
};

/// Whether the straight way between two places of the lumen stays in it.
bool is_open(const SurfaceWall& wall, const Vec3& from, const Vec3& to) {
  const double length = distance(from, to);
  return length == 0.0 || wall.ray(from, (1.0 / length) * (to - from), length) >= length;
}

/// What hangs together of middles and of crumbs between them, and the parts of the lumen that it
/// leads to.
struct Passage {
  std::vector<Index> voxels;        ///< to take in, with those between them over their faces
  std::set<int> parts;              ///< that an open way leads to,
  std::set<int> parts_behind_wall;  ///< and that its voxels would be linked to through a wall

  /// Whether it joins parts, and only those that it leads to.
  [[nodiscard]] bool is_wanted() const {
    return parts.size() > 1 && std::includes(parts.begin(), parts.end(), parts_behind_wall.begin(),
                                             parts_behind_wall.end());
  }
};

class PassageFinder {
 public:
  PassageFinder(const Volume<float>& level_set, const SurfaceWall& wall, double least_mm)
      : level_set_(level_set),
        wall_(wall),
        middles_(find_middles(level_set, wall, least_mm)),
        parts_(level_set) {}

  std::vector<Passage> find() {
    std::vector<Passage> passages;
    for (const auto& [voxel, middle] : middles_) {
      if (seen_.count(voxel) > 0) continue;
      Passage passage = follow(voxel);
      if (passage.is_wanted()) passages.push_back(std::move(passage));
    }
    return passages;
  }

 private:
  [[nodiscard]] bool is_in_lumen(const Index& at) const {
    return level_set_.at(at[0], at[1], at[2]) < 0.0F;
  }
  [[nodiscard]] Vec3 place(const Index& at) const {
    const auto middle = middles_.find(at);
    return middle == middles_.end() ? centre(level_set_.geometry, at) : middle->second;
  }

  Passage follow(const Index& first) {
    Passage passage;
    std::vector<Index> open{first};
    seen_.insert(first);
    while (!open.empty()) {
      const Index from = open.back();
      open.pop_back();
      if (!is_in_lumen(from)) take(from, place(from), passage);
      for (std::size_t n = 0; n < kNeighborOffsets.size(); ++n) {
        const Index to = beside(from, n);
        if (!is_within(level_set_.geometry, to)) continue;
        if (!is_in_lumen(to) && middles_.count(to) == 0) continue;
        if (!is_open(wall_, place(from), place(to))) continue;
        const int part = is_in_lumen(to) ? parts_.of(to) : Parts::kCrumb;
        take_between(from, to, passage);
        if (part != Parts::kCrumb)
          passage.parts.insert(part);
        else if (seen_.insert(to).second)
          open.push_back(to);
      }
    }
    return passage;
  }

  /// The voxels between two neighbours, so that all are linked over their faces.
  void take_between(const Index& from, const Index& to, Passage& passage) {
    Index at = from;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] == to[axis]) continue;
      at[axis] = to[axis];
      if (at != to && !is_in_lumen(at)) take(at, 0.5 * (place(from) + place(to)), passage);
    }
  }

  /// Takes a voxel that stands for a place in, and looks what it will be linked to.
  void take(const Index& voxel, const Vec3& place_in_it, Passage& passage) {
    passage.voxels.push_back(voxel);
    for (std::size_t n = 0; n < kNeighborOffsets.size(); ++n) {
      const Index to = beside(voxel, n);
      if (!is_within(level_set_.geometry, to) || !is_in_lumen(to)) continue;
      const int part = parts_.of(to);
      if (part != Parts::kCrumb && !is_open(wall_, place_in_it, place(to)))
        passage.parts_behind_wall.insert(part);
    }
  }

  const Volume<float>& level_set_;
  const SurfaceWall& wall_;
  MiddleOf middles_;
  Parts parts_;
  std::set<Index> seen_;
};

}  // namespace

int open_throats(Volume<float>& level_set, const SurfaceWall& wall, double least_mm) {
  const float depth = float(-0.25 * level_set.geometry.spacing.x);
  int count = 0;
  for (const Passage& passage : PassageFinder(level_set, wall, least_mm).find())
    for (const Index& at : passage.voxels) {
      float& value = level_set.at(at[0], at[1], at[2]);
      if (value < 0.0F) continue;
      value = depth;
      ++count;
    }
  return count;
}

}  // namespace angio::centerline
