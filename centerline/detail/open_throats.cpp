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
using Middles = std::map<Index, Vec3>;

/// Places of a triangle, at most `apart` from each other.
template <class Use>
void for_each_place(const TriangleMesh& mesh, const Triangle& corners, double apart, Use&& use) {
  const auto corner = [&](std::size_t c) { return mesh.vertices[std::size_t(corners[c])]; };
  const Vec3 a = corner(0), ab = corner(1) - a, ac = corner(2) - a;
  const double longest = std::max({norm(ab), norm(ac), distance(corner(1), corner(2))});
  const int parts = std::max(1, int(std::ceil(longest / apart)));
  for (int i = 0; i < parts; ++i)
    for (int j = 0; i + j < parts; ++j)
      use(a + ((i + 1.0 / 3.0) / parts) * ab + ((j + 1.0 / 3.0) / parts) * ac);
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

Middles find_middles(const Volume<float>& level_set, const SurfaceWall& wall) {
  constexpr double kThin = 2.5, kSlit = 0.25, kApart = 0.5;  // voxels
  const VolumeGeometry& grid = level_set.geometry;
  const double voxel = grid.spacing.x;
  const TriangleMesh& mesh = wall.mesh();
  const double farthest = voxel * (grid.size[0] + grid.size[1] + grid.size[2]);
  Middles middles;
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
      if (across <= kSlit * voxel || across >= kThin * voxel) return;
      const Vec3 middle = from + 0.5 * across * inward;
      const Index at = nearest_voxel(grid, middle);
      if (is_within(grid, at) && level_set.at(at[0], at[1], at[2]) >= 0.0F &&
          middles.count(at) == 0 && is_enclosed(wall, middle, farthest))
        middles.emplace(at, middle);
    });
  }
  return middles;
}

/// The part of the lumen that each of its voxels belongs to, by faces, filled as it is asked for.
/// Crumbs are none.
class Parts {
 public:
  explicit Parts(const Volume<float>& level_set) : level_set_(level_set) {}

  static constexpr int kNone = -1;

  int of(const Index& at) {
    if (const auto known = part_.find(key(at)); known != part_.end()) return known->second;
    constexpr std::size_t kCrumb = 30;  // voxels
    const int part = count_++;
    std::vector<Index> open{at}, all{at};
    part_[key(at)] = part;
    while (!open.empty()) {
      const Index from = open.back();
      open.pop_back();
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1}) {
          Index to = from;
          to[axis] += step;
          if (!is_within(level_set_.geometry, to) || level_set_.at(to[0], to[1], to[2]) >= 0.0F)
            continue;
          if (!part_.emplace(key(to), part).second) continue;
          open.push_back(to);
          if (all.size() < kCrumb) all.push_back(to);
        }
    }
    if (all.size() >= kCrumb) return part;
    for (const Index& crumb : all) part_[key(crumb)] = kNone;
    return kNone;
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

/// A group of middles that hang together, the ways between them and into the lumen, and the parts
/// of the lumen that they lead to.
struct Passage {
  std::vector<Index> voxels;
  std::vector<std::array<Index, 2>> ways;
  std::set<int> parts;
};

Passage follow(const Index& first, const Volume<float>& level_set, const SurfaceWall& wall,
               const Middles& middles, Parts& parts, std::set<Index>& seen) {
  const VolumeGeometry& grid = level_set.geometry;
  Passage passage;
  std::vector<Index> open{first};
  seen.insert(first);
  while (!open.empty()) {
    const Index from = open.back();
    open.pop_back();
    passage.voxels.push_back(from);
    for (std::size_t n = 0; n < kNeighborOffsets.size(); ++n) {
      const Index to = beside(from, n);
      if (!is_within(grid, to)) continue;
      const bool in_lumen = level_set.at(to[0], to[1], to[2]) < 0.0F;
      const auto middle = middles.find(to);
      if (!in_lumen && middle == middles.end()) continue;
      if (!is_open(wall, middles.at(from), in_lumen ? centre(grid, to) : middle->second)) continue;
      passage.ways.push_back({from, to});
      if (in_lumen) {
        if (const int part = parts.of(to); part != Parts::kNone) passage.parts.insert(part);
      } else if (seen.insert(to).second) {
        open.push_back(to);
      }
    }
  }
  return passage;
}

/// Takes a passage into the lumen, voxel by voxel over their faces, so that all are linked.
int take_in(const Passage& passage, Volume<float>& level_set) {
  const float depth = float(-0.25 * level_set.geometry.spacing.x);
  int count = 0;
  const auto take = [&](const Index& at) {
    float& value = level_set.at(at[0], at[1], at[2]);
    if (value < 0.0F) return;
    value = depth;
    ++count;
  };
  for (const Index& voxel : passage.voxels) take(voxel);
  for (const auto& [from, to] : passage.ways) {
    Index at = from;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = to[axis];
      take(at);
    }
  }
  return count;
}

}  // namespace

int open_throats(Volume<float>& level_set, const SurfaceWall& wall) {
  const Middles middles = find_middles(level_set, wall);
  Parts parts(level_set);
  std::set<Index> seen;
  std::vector<Passage> passages;
  for (const auto& [voxel, middle] : middles) {
    if (seen.count(voxel) > 0) continue;
    Passage passage = follow(voxel, level_set, wall, middles, parts, seen);
    if (passage.parts.size() > 1) passages.push_back(std::move(passage));
  }
  int count = 0;
  for (const Passage& passage : passages) count += take_in(passage, level_set);
  return count;
}

}  // namespace angio::centerline
