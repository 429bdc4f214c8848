#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "air_mesh/tet_topology.hpp"
#include "core/units.hpp"
#include "testing/simulation/meshed_gap.hpp"

namespace angio::air_mesh::test {

inline simulation::testing::Gap straight_gap() {
  return simulation::testing::make_gap(
      8.0, 0.5, [](double) { return 1.3; }, 0.8, 15, 12);
}

constexpr double kDegree = units::kPi / 180.0;  ///< [rad]

/// A point turned about the z axis.
inline Vec3 turned(const Vec3& p, double angle) {
  return {p.x * std::cos(angle) - p.y * std::sin(angle),
          p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
}

inline double volume_of(const std::vector<Tet>& tets, const std::vector<Vec3>& x) {
  double sum = 0.0;
  for (const Tet& t : tets)
    sum += tet_volume(x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])],
                      x[std::size_t(t[3])]);
  return sum;
}

inline double quality_of(const Tet& t, const std::vector<Vec3>& x) {
  return tet_quality(x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])],
                     x[std::size_t(t[3])]);
}

inline std::vector<Triangle> outer_faces(const TetTopology& air) {
  std::vector<Triangle> faces;
  for (const TetFace& f : air.boundary()) {
    faces.push_back(air.face(f.tet, f.corner));
    std::sort(faces.back().begin(), faces.back().end());
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

}  // namespace angio::air_mesh::test
