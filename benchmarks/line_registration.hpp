#pragma once

#include <Eigen/Dense>
#include <vector>

#include "core/vec3.hpp"

namespace angio::benchmarks {

/// x -> scale turn x + shift; a `turn` of determinant -1 mirrors.
struct Similarity {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  double scale = 1.0;

  [[nodiscard]] Vec3 apply(const Vec3& point) const;
};

/// Distances of places from the nearest of others [mm].
std::vector<double> distances_to(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// Lays points of one tree's lines on another's, rigidly: iterative closest points (Besl, McKay,
/// IEEE Trans. Pattern Anal. Mach. Intell. 14:239, 1992), both ways, of each way the nearest three
/// quarters (one tree may hold what the other lacks; Chetverikov et al., Image Vis. Comput. 23:299,
/// 2005), from forty attitudes of each handedness. The best by the mean distance of what is kept.
///
/// @param from, to  points along lines, evenly spaced [mm]
Similarity register_rigidly(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// The best similarity near a rigid motion: the same, its scale free.
Similarity with_scale(const Similarity& start, const std::vector<Vec3>& from,
                      const std::vector<Vec3>& to);

}  // namespace angio::benchmarks
