#pragma once

#include <utility>
#include <vector>

#include "core/vec3.hpp"

/// The lumen as a union of balls, which makes its distance and its inscribed radii exact.
namespace angio::datasets::detail {

/// One vessel: balls along a smooth centre line, densely sampled. Where a stenosis narrows it from
/// two sides, the balls also slide by +- half_width, which gives a stadium-shaped section.
struct Branch {
  double step_mm = 0.1;            ///< between samples, along the axis of the healthy vessel
  std::vector<Vec3> center;        ///< ball centres, LPS [mm], shape [sample_count]
  std::vector<double> radius;      ///< ball radii = inscribed radii [mm]
  std::vector<Vec3> half_width;    ///< [mm]; zero but in a two-sided stenosis
  std::vector<double> healthy_mm;  ///< radius without the stenosis [mm]

  int first_sample = 0;  ///< the vessel is [first_sample, last_sample]; what lies beyond continues
  int last_sample = 0;   ///< it past its cut ends
  bool cut_at_start = false;  ///< flat end at first_sample; a side branch begins in its parent
  bool cut_at_end = true;     ///< flat end at last_sample; false: the dome of an aneurysm's sac
  int parent = -1;            ///< branch it leaves, or -1
  int parent_sample = 0;      ///< where

  double blend_mm = 0.0;  ///< width of the smooth union with the branches before it, >= 0

  /// Unit tangent of the centre line at a sample.
  [[nodiscard]] Vec3 tangent(int sample) const;
};

/// The nearest place of the lumen's boundary.
struct NearestWall {
  double distance = 0.0;   ///< signed [mm], negative inside
  Vec3 normal;             ///< unit, outward
  double radius = 0.0;     ///< of the ball that it belongs to [mm]
  double curvature = 0.0;  ///< of the wall across the vessel [1/mm]; 0 on flat parts
};

/// A flat end of a vessel.
struct FlatEnd {
  Vec3 point;           ///< in its middle
  Vec3 outward;         ///< unit
  double radius = 0.0;  ///< of the vessel there [mm]
  double reach = 0.0;   ///< it cuts the vessel within this distance of its middle [mm]
};

/// Union of tapered curved tubes.
///
///     f(x) = min_s ( |x - m(s)| - r(s) )
///
/// for one branch; between samples m and r are quadratic. Branches are joined by the polynomial
/// smooth minimum of Quilez (iquilezles.org/articles/smin) whose width is blend (1 - n_a . n_b) /
/// 2: it rounds the carina and vanishes where both walls agree, so inscribed radii stay r(s). Flat
/// ends are half-spaces near the ends.
class LumenShape {
 public:
  /// Flat ends, or as if the vessel went on.
  enum class Ends { cut, continued };

  explicit LumenShape(std::vector<Branch> branches);

  [[nodiscard]] const std::vector<Branch>& branches() const { return branches_; }

  /// f is at most 1-Lipschitz up to margin_mm(), exact near the wall but on flat ends' rims.
  [[nodiscard]] NearestWall nearest_wall(const Vec3& x, Ends ends = Ends::cut) const;
  [[nodiscard]] double signed_distance(const Vec3& x, Ends ends = Ends::cut) const {
    return nearest_wall(x, ends).distance;
  }

  [[nodiscard]] std::vector<FlatEnd> flat_ends() const;

  /// How far the smooth union can lower the distance [mm].
  [[nodiscard]] double margin_mm() const { return margin_mm_; }
  [[nodiscard]] double least_radius_mm() const { return least_radius_mm_; }
  [[nodiscard]] const Vec3& lower_corner() const { return lower_corner_; }
  [[nodiscard]] const Vec3& upper_corner() const { return upper_corner_; }

  /// Least and greatest coordinate along a unit direction [mm].
  [[nodiscard]] std::pair<double, double> extent_along(const Vec3& direction) const;

 private:
  /// Consecutive samples within one bounding ball.
  struct Chunk {
    int first = 0;
    int last = 0;
    Vec3 center;
    double reach = 0.0;
  };
  struct Prepared {
    std::vector<Chunk> chunks;
    std::vector<FlatEnd> ends;
  };

  [[nodiscard]] static Prepared prepare(const Branch& branch);
  void measure_extent();
  /// @param farthest  [mm]: a branch that is farther away need not be looked at, and gets this
  [[nodiscard]] NearestWall nearest_wall_of_branch(std::size_t branch, const Vec3& x, Ends ends,
                                                   double farthest) const;

  std::vector<Branch> branches_;
  std::vector<Prepared> prepared_;
  double margin_mm_ = 0.0;
  double least_radius_mm_ = 0.0;
  Vec3 lower_corner_;
  Vec3 upper_corner_;
};

}  // namespace angio::datasets::detail
