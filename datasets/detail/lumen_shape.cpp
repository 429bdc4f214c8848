#include "datasets/detail/lumen_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace angio::datasets::detail {
namespace {

constexpr int kChunkSamples = 16;

/// Distance from x to the ball (or row of balls) of one sample.
double distance_to_ball(const Vec3& x, const Vec3& center, double radius, const Vec3& half_width,
                        Vec3* from_center = nullptr) {
  Vec3 q = x - center;
  const double width_squared = norm_squared(half_width);
  if (width_squared > 0.0)
    q -= std::clamp(dot(q, half_width) / width_squared, -1.0, 1.0) * half_width;
  if (from_center) *from_center = q;
  return norm(q) - radius;
}

template <class Value>
Value quadratic(const Value& before, const Value& here, const Value& after, double t) {
  return (0.5 * t * (t - 1.0)) * before + (1.0 - t * t) * here + (0.5 * t * (t + 1.0)) * after;
}

/// The wall between samples i - 1 and i + 1, where sample i is the nearest one.
NearestWall refine(const Branch& branch, int sample, const Vec3& x) {
  const std::size_t i = std::size_t(sample);
  double t = 0.0;
  std::size_t lo = i, hi = i;
  if (i > 0 && i + 1 < branch.center.size()) {
    lo = i - 1;
    hi = i + 1;
    const auto f = [&](std::size_t k) {
      return distance_to_ball(x, branch.center[k], branch.radius[k], branch.half_width[k]);
    };
    const double before = f(lo), here = f(i), after = f(hi);
    const double bend = before - 2.0 * here + after;
    if (bend > 0.0) t = std::clamp(0.5 * (before - after) / bend, -1.0, 1.0);
  }
  const Vec3 center = quadratic(branch.center[lo], branch.center[i], branch.center[hi], t);
  const Vec3 width =
      quadratic(branch.half_width[lo], branch.half_width[i], branch.half_width[hi], t);
  const double radius = quadratic(branch.radius[lo], branch.radius[i], branch.radius[hi], t);
  Vec3 from_center;
  NearestWall wall;
  wall.distance = distance_to_ball(x, center, radius, width, &from_center);
  wall.normal = norm_squared(from_center) > 0.0 ? normalized(from_center)
                                                : any_perpendicular(branch.tangent(sample));
  wall.radius = radius;
  // Between the ends of a row of balls the wall is flat.
  const bool is_in_row =
      norm_squared(width) > 0.0 && std::abs(dot(x - center, width)) < norm_squared(width);
  wall.curvature = is_in_row ? 0.0 : 1.0 / radius;
  return wall;
}

NearestWall smooth_union(const NearestWall& a, const NearestWall& b, double blend_mm) {
  NearestWall nearer = a.distance <= b.distance ? a : b;
  const NearestWall& other = a.distance <= b.distance ? b : a;
  const double width = blend_mm * 0.5 * (1.0 - dot(a.normal, b.normal));
  const double gap = other.distance - nearer.distance;
  if (gap >= width) return nearer;
  const double h = 1.0 - gap / width;
  nearer.distance -= 0.25 * h * h * width;
  nearer.normal = normalized((1.0 - 0.5 * h) * nearer.normal + 0.5 * h * other.normal);
  return nearer;
}

}  // namespace

Vec3 Branch::tangent(int sample) const {
  const int last = int(center.size()) - 1;
  const std::size_t before = std::size_t(std::max(sample - 1, 0));
  const std::size_t after = std::size_t(std::min(sample + 1, last));
  return normalized(center[after] - center[before]);
}

LumenShape::LumenShape(std::vector<Branch> branches) : branches_(std::move(branches)) {
  for (const Branch& branch : branches_) {
    prepared_.push_back(prepare(branch));
    margin_mm_ += 0.25 * branch.blend_mm;
  }
  measure_extent();
}

LumenShape::Prepared LumenShape::prepare(const Branch& branch) {
  Prepared prepared;
  const int count = int(branch.center.size());
  for (int first = 0; first < count; first += kChunkSamples) {
    Chunk chunk;
    chunk.first = first;
    chunk.last = std::min(first + kChunkSamples, count) - 1;
    chunk.center = branch.center[std::size_t((chunk.first + chunk.last) / 2)];
    for (std::size_t i = std::size_t(first); i <= std::size_t(chunk.last); ++i)
      chunk.reach = std::max(chunk.reach, distance(chunk.center, branch.center[i]) +
                                              branch.radius[i] + norm(branch.half_width[i]));
    prepared.chunks.push_back(chunk);
  }
  const auto add_end = [&](int sample, double sign) {
    const std::size_t i = std::size_t(sample);
    prepared.ends.push_back({branch.center[i], sign * branch.tangent(sample), branch.radius[i],
                             2.5 * branch.radius[i]});
  };
  if (branch.cut_at_start) add_end(branch.first_sample, -1.0);
  if (branch.cut_at_end) add_end(branch.last_sample, 1.0);
  return prepared;
}

void LumenShape::measure_extent() {
  least_radius_mm_ = std::numeric_limits<double>::max();
  for (const Branch& branch : branches_)
    for (int s = branch.first_sample; s <= branch.last_sample; ++s)
      least_radius_mm_ = std::min(least_radius_mm_, branch.radius[std::size_t(s)]);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 direction;
    direction[axis] = 1.0;
    std::tie(lower_corner_[axis], upper_corner_[axis]) = extent_along(direction);
  }
}

std::pair<double, double> LumenShape::extent_along(const Vec3& direction) const {
  constexpr double kFar = std::numeric_limits<double>::max();
  double least = kFar, greatest = -kFar;
  for (const Branch& branch : branches_)
    for (int s = branch.first_sample; s <= branch.last_sample; ++s) {
      const std::size_t i = std::size_t(s);
      const double reach = branch.radius[i] + norm(branch.half_width[i]);
      const double middle = dot(branch.center[i], direction);
      least = std::min(least, middle - reach);
      greatest = std::max(greatest, middle + reach);
    }
  return {least, greatest};
}

NearestWall LumenShape::nearest_wall(const Vec3& x, Ends ends) const {
  constexpr double kFar = std::numeric_limits<double>::max();
  NearestWall wall = nearest_wall_of_branch(0, x, ends, kFar);
  for (std::size_t b = 1; b < branches_.size(); ++b) {
    const double blend = branches_[b].blend_mm;
    const double farthest = wall.distance + blend;
    const NearestWall other = nearest_wall_of_branch(b, x, ends, farthest);
    if (other.distance < farthest) wall = smooth_union(wall, other, blend);
  }
  return wall;
}

std::vector<FlatEnd> LumenShape::flat_ends() const {
  std::vector<FlatEnd> ends;
  for (const Prepared& prepared : prepared_)
    ends.insert(ends.end(), prepared.ends.begin(), prepared.ends.end());
  return ends;
}

NearestWall LumenShape::nearest_wall_of_branch(std::size_t b, const Vec3& x, Ends ends,
                                               double farthest) const {
  const Branch& branch = branches_[b];
  const Prepared& prepared = prepared_[b];
  // The most promising chunk goes first, so that most others need not be opened.
  const Chunk* first_chunk = nullptr;
  double least_bound = std::numeric_limits<double>::max();
  for (const Chunk& chunk : prepared.chunks) {
    const double bound = distance(x, chunk.center) - chunk.reach;
    if (bound < least_bound) {
      least_bound = bound;
      first_chunk = &chunk;
    }
  }
  if (least_bound >= farthest) {
    NearestWall far_away;
    far_away.distance = farthest;
    return far_away;
  }
  double best = std::numeric_limits<double>::max();
  int best_sample = 0;
  const auto open_chunk = [&](const Chunk& chunk) {
    for (int s = chunk.first; s <= chunk.last; ++s) {
      const std::size_t i = std::size_t(s);
      const double d =
          distance_to_ball(x, branch.center[i], branch.radius[i], branch.half_width[i]);
      if (d < best) {
        best = d;
        best_sample = s;
      }
    }
  };
  open_chunk(*first_chunk);
  for (const Chunk& chunk : prepared.chunks)
    if (&chunk != first_chunk && distance(x, chunk.center) - chunk.reach < best) open_chunk(chunk);

  NearestWall wall = refine(branch, best_sample, x);
  if (ends == Ends::continued) return wall;
  for (const FlatEnd& end : prepared.ends) {
    const Vec3 from_end = x - end.point;
    const double height = dot(from_end, end.outward);
    if (height > wall.distance && norm(from_end) < end.reach) {
      wall.distance = height;
      wall.normal = end.outward;
      wall.curvature = 0.0;
    }
  }
  return wall;
}

}  // namespace angio::datasets::detail
