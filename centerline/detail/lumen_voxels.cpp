#include "centerline/detail/lumen_voxels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "centerline/detail/monotone_queue.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {

std::array<double, kNeighborCount> neighbor_lengths(const VolumeGeometry& geometry) {
  std::array<double, kNeighborCount> lengths{};
  for (std::size_t n = 0; n < lengths.size(); ++n) {
    const auto& o = kNeighborOffsets[n];
    lengths[n] =
        norm(Vec3{o[0] * geometry.spacing.x, o[1] * geometry.spacing.y, o[2] * geometry.spacing.z});
  }
  return lengths;
}

std::array<int, 3> LumenVoxels::index(int voxel) const {
  const int c = cell[std::size_t(voxel)];
  return {c % size[0], (c / size[0]) % size[1], c / (size[0] * size[1])};
}

Vec3 LumenVoxels::position(int voxel) const {
  const auto i = index(voxel);
  return geometry.lps_from_index(
      {double(i[0] + corner[0]), double(i[1] + corner[1]), double(i[2] + corner[2])});
}

int LumenVoxels::nearest(const Vec3& point_in_lps) const {
  int best = 0;
  double best_squared = std::numeric_limits<double>::max();
  for (int v = 0; v < count(); ++v) {
    const double d = norm_squared(position(v) - point_in_lps);
    if (d < best_squared) {
      best_squared = d;
      best = v;
    }
  }
  return best;
}

double LumenVoxels::depth_at(const Vec3& point_in_lps) const {
  const Vec3 at = geometry.index_from_lps(point_in_lps);
  double sum = 0.0;
  for (int n = 0; n < 8; ++n) {
    int c = 0, stride = 1;
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double u = at[axis] - corner[std::size_t(axis)], low = std::floor(u);
      const int i = int(low) + (n >> axis & 1);
      weight *= (n >> axis & 1) != 0 ? u - low : 1.0 - (u - low);
      if (i < 0 || i >= size[std::size_t(axis)]) weight = 0.0;
      c += i * stride;
      stride *= size[std::size_t(axis)];
    }
    if (weight <= 0.0) continue;
    const int voxel = voxel_of_cell[std::size_t(c)];
    if (voxel >= 0) sum += weight * double(depth[std::size_t(voxel)]);
  }
  return sum;
}

void LumenVoxels::cut(int voxel, int n) {
  const int other = neighbor(voxel, n);
  if (other < 0) return;
  links[std::size_t(voxel)] &= ~(1U << n);
  links[std::size_t(other)] &= ~(1U << (kNeighborCount - 1 - n));
}

namespace {

using Index = std::array<int, 3>;

/// The mean of the level set over the corners between a voxel and its neighbour: the trilinear
/// value half way.
bool inside_half_way(const Volume<float>& level_set, const Index& at, const Index& offset) {
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Index c = at;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if ((corner >> axis & 1) != 0) c[axis] += offset[axis];
    sum += double(level_set.at(c[0], c[1], c[2]));
  }
  return sum < 0.0;
}

/// Whether a voxel and its 26 neighbours are inside: then so is all that lies between them.
bool is_deep(const Volume<float>& level_set, const Index& at) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (at[axis] < 1 || at[axis] + 1 >= level_set.geometry.size[axis]) return false;
  for (int k = at[2] - 1; k <= at[2] + 1; ++k)
    for (int j = at[1] - 1; j <= at[1] + 1; ++j) {
      const float* row = &level_set.at(at[0] - 1, j, k);
      if (!(row[0] < 0.0F && row[1] < 0.0F && row[2] < 0.0F)) return false;
    }
  return true;
}

}  // namespace

std::uint32_t find_links(const Volume<float>& level_set, const Index& at) {
  constexpr std::uint32_t kAll = (1U << kNeighborCount) - 1U;
  if (is_deep(level_set, at)) return kAll;
  std::uint32_t bits = 0;
  for (int n = 0; n < kNeighborCount; ++n) {
    const auto& o = kNeighborOffsets[std::size_t(n)];
    const Index to{at[0] + o[0], at[1] + o[1], at[2] + o[2]};
    if (level_set.geometry.contains(to[0], to[1], to[2]) &&
        level_set.at(to[0], to[1], to[2]) < 0.0F && inside_half_way(level_set, at, o))
      bits |= 1U << n;
  }
  return bits;
}

namespace {

/// A box of voxels; empty while low is above high.
struct Box {
  Index low, high;
  void add(const Index& other_low, const Index& other_high) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], other_low[a]);
      high[a] = std::max(high[a], other_high[a]);
    }
  }
};

/// The box around the inside.
Box box_of_inside(const Volume<float>& level_set) {
  const Index n = level_set.geometry.size;
  std::vector<Box> slices(std::size_t(n[2]), {n, {-1, -1, -1}});
  parallel_for(n[2], [&](std::ptrdiff_t slice) {
    const auto k = int(slice);
    const auto is_inside = [](float d) { return d < 0.0F; };
    for (int j = 0; j < n[1]; ++j) {
      const float* row = &level_set.at(0, j, k);
      const float* first = std::find_if(row, row + n[0], is_inside);
      if (first == row + n[0]) continue;
      const float* last = row + n[0] - 1;
      while (!is_inside(*last)) --last;
      slices[std::size_t(k)].add({int(first - row), j, k}, {int(last - row), j, k});
    }
  });
  Box box{n, {-1, -1, -1}};
  for (const Box& slice : slices) box.add(slice.low, slice.high);
  return box;
}

/// All inside voxels with links, in the box around them.
LumenVoxels collect(const Volume<float>& level_set) {
  LumenVoxels lumen;
  lumen.geometry = level_set.geometry;
  const auto [low, high] = box_of_inside(level_set);
  if (high[0] < 0)
    throw InputError(
        "the level set has no inside (no voxel is negative, so there is no lumen to find a line "
        "in). Check the segmentation");
  lumen.corner = low;
  for (std::size_t a = 0; a < 3; ++a) lumen.size[a] = high[a] - low[a] + 1;
  const auto cells =
      std::size_t(lumen.size[0]) * std::size_t(lumen.size[1]) * std::size_t(lumen.size[2]);
  if (cells > std::size_t(std::numeric_limits<int>::max()))
    throw InputError("the lumen's box has more than 2^31 voxels. Crop or resample the volume");
  lumen.voxel_of_cell.assign(cells, -1);
  for (int k = 0; k < lumen.size[2]; ++k)
    for (int j = 0; j < lumen.size[1]; ++j) {
      const float* row = &level_set.at(low[0], low[1] + j, low[2] + k);
      const int first = (k * lumen.size[1] + j) * lumen.size[0];
      for (int i = 0; i < lumen.size[0]; ++i) {
        if (!(row[i] < 0.0F)) continue;
        lumen.voxel_of_cell[std::size_t(first + i)] = lumen.count();
        lumen.cell.push_back(first + i);
      }
    }
  lumen.links.resize(lumen.cell.size());
  parallel_for(std::ptrdiff_t(lumen.links.size()), [&](std::ptrdiff_t v) {
    Index at = lumen.index(int(v));
    for (std::size_t a = 0; a < 3; ++a) at[a] += lumen.corner[a];
    lumen.links[std::size_t(v)] = find_links(level_set, at);
  });
  return lumen;
}

/// @return the piece each voxel is in, and the voxels in each piece
std::pair<std::vector<int>, std::vector<int>> label_pieces(const LumenVoxels& lumen) {
  std::vector<int> label(std::size_t(lumen.count()), -1), counts, stack;
  for (int seed = 0; seed < lumen.count(); ++seed) {
    if (label[std::size_t(seed)] >= 0) continue;
    const int piece = int(counts.size());
    counts.push_back(0);
    label[std::size_t(seed)] = piece;
    stack.assign(1, seed);
    while (!stack.empty()) {
      const int v = stack.back();
      stack.pop_back();
      ++counts.back();
      for (int n = 0; n < kNeighborCount; ++n) {
        const int w = lumen.neighbor(v, n);
        if (w < 0 || label[std::size_t(w)] >= 0) continue;
        label[std::size_t(w)] = piece;
        stack.push_back(w);
      }
    }
  }
  return {std::move(label), std::move(counts)};
}

/// One piece, in the box around it.
LumenVoxels take_piece(const LumenVoxels& all, const std::vector<int>& label, int piece) {
  Box box{all.size, {-1, -1, -1}};
  for (int v = 0; v < all.count(); ++v)
    if (label[std::size_t(v)] == piece) box.add(all.index(v), all.index(v));
  LumenVoxels lumen;
  lumen.geometry = all.geometry;
  for (std::size_t a = 0; a < 3; ++a) {
    lumen.corner[a] = all.corner[a] + box.low[a];
    lumen.size[a] = box.high[a] - box.low[a] + 1;
  }
  lumen.voxel_of_cell.assign(
      std::size_t(lumen.size[0]) * std::size_t(lumen.size[1]) * std::size_t(lumen.size[2]), -1);
  for (int v = 0; v < all.count(); ++v) {
    if (label[std::size_t(v)] != piece) continue;
    const Index at = all.index(v);
    const int cell = ((at[2] - box.low[2]) * lumen.size[1] + at[1] - box.low[1]) * lumen.size[0] +
                     at[0] - box.low[0];
    lumen.voxel_of_cell[std::size_t(cell)] = lumen.count();
    lumen.cell.push_back(cell);
    lumen.links.push_back(all.links[std::size_t(v)]);
  }
  return lumen;
}

/// The nearest point of the wall [mm, in the voxel's own axes] seen from a voxel at the wall:
/// along the gradient where that is trustworthy, else the nearest crossing along an axis.
bool find_wall_point(const Volume<float>& level_set, const Index& at, Vec3& offset) {
  const double here = double(level_set.at(at[0], at[1], at[2]));
  double nearest = std::numeric_limits<double>::max();
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const double h = level_set.geometry.spacing[axis];
    double value[2] = {here, here};
    int sides = 0;
    for (int side = 0; side < 2; ++side) {
      Index to = at;
      to[std::size_t(axis)] += side == 0 ? -1 : 1;
      if (!level_set.geometry.contains(to[0], to[1], to[2])) continue;
      ++sides;
      value[side] = double(level_set.at(to[0], to[1], to[2]));
      if (value[side] < 0.0) continue;
      const double t = h * here / (here - value[side]);
      if (t >= nearest) continue;
      nearest = t;
      offset = {};
      offset[axis] = side == 0 ? -t : t;
    }
    gradient[axis] = sides == 0 ? 0.0 : (value[1] - value[0]) / (h * sides);
  }
  if (nearest == std::numeric_limits<double>::max()) return false;
  const double slope = norm(gradient);
  if (slope > 0.0 && -here / slope < nearest) offset = (-here / (slope * slope)) * gradient;
  return true;
}

/// Distance to the wall: each voxel inherits the nearest wall point of its neighbours, nearest
/// first (a vector distance transform).
void find_depth(const Volume<float>& level_set, LumenVoxels& lumen) {
  const auto count = std::size_t(lumen.count());
  const double far = std::numeric_limits<double>::max();
  std::vector<Vec3> wall(count);  // in mm along the voxel axes
  std::vector<double> depth(count, far);
  MonotoneQueue queue;
  std::vector<double> key(count, far);  // as it was last queued
  const Vec3 h = level_set.geometry.spacing;
  const auto local = [&](int v) {
    const auto i = lumen.index(v);
    return Vec3{i[0] * h.x, i[1] * h.y, i[2] * h.z};
  };
  for (int v = 0; v < lumen.count(); ++v) {
    const auto i = lumen.index(v);
    const Index at{i[0] + lumen.corner[0], i[1] + lumen.corner[1], i[2] + lumen.corner[2]};
    Vec3 offset;
    if (!find_wall_point(level_set, at, offset)) continue;
    wall[std::size_t(v)] = local(v) + offset;
    depth[std::size_t(v)] = norm(offset);
    key[std::size_t(v)] = depth[std::size_t(v)];
    queue.add(depth[std::size_t(v)], v);
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.take();
    if (d != key[std::size_t(v)]) continue;
    const auto at = lumen.index(v);
    const Vec3 nearest = wall[std::size_t(v)];
    // First all that lies far away in memory, so that the processor waits for it once.
    std::array<int, kNeighborCount> beside;
    std::array<double, kNeighborCount> known;
    for (int n = 0; n < kNeighborCount; ++n) beside[std::size_t(n)] = lumen.neighbor(v, n);
    for (std::size_t n = 0; n < beside.size(); ++n)
      known[n] = beside[n] < 0 ? 0.0 : depth[std::size_t(beside[n])];
    for (std::size_t n = 0; n < beside.size(); ++n) {
      const auto& o = kNeighborOffsets[n];
      const Vec3 place{(at[0] + o[0]) * h.x, (at[1] + o[1]) * h.y, (at[2] + o[2]) * h.z};
      const double candidate = distance(place, nearest);
      if (candidate >= known[n]) continue;  // nor is one taken that is not linked
      const auto w = std::size_t(beside[n]);
      depth[w] = candidate;
      wall[w] = nearest;
      key[w] = std::max(candidate, d);  // nearer than its neighbour: seldom, and then at once
      queue.add(key[w], beside[n]);
    }
  }
  lumen.depth.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    if (depth[v] == far)
      throw InputError(
          "the lumen has no wall inside the volume (it fills all of it). Check the segmentation");
    lumen.depth[v] = float(std::max(depth[v], 0.05 * std::min({h.x, h.y, h.z})));
  }
}

}  // namespace

LumenPieces find_lumen_pieces(const Volume<float>& level_set) {
  constexpr double kLeastTree = 0.05;  // of the largest piece
  LumenPieces result;
  LumenVoxels all = collect(level_set);
  const auto [label, counts] = label_pieces(all);
  result.piece_count = int(counts.size());
  std::vector<int> order(counts.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&, &count = counts](int a, int b) {
    return count[std::size_t(a)] > count[std::size_t(b)];
  });
  const int largest = counts[std::size_t(order.front())];
  for (const int piece : order) {
    const int count = counts[std::size_t(piece)];
    if (count < kLeastTree * largest) break;
    result.voxel_share.push_back(double(count) / double(label.size()));
    result.pieces.push_back(counts.size() > 1 ? take_piece(all, label, piece) : std::move(all));
    find_depth(level_set, result.pieces.back());
  }
  return result;
}

}  // namespace angio::centerline
