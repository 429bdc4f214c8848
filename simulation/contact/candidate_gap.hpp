#pragma once

#include "simulation/step/parting_plane.hpp"

/// What makes two primitives a candidate, the same for every backend. `Points` gives vertices by
/// x[std::size_t], in double precision [mm].
namespace angio::simulation::detail {

/// Contact of a surface with itself acts below this share of the gap that a pair starts with: so it
/// pushes nothing in the start shape, however near its layers, and however fine the mesh. A smooth
/// membrane's neighbours keep about their start gap, and never meet.
inline constexpr double kShareOfStartGap = 0.9;

inline constexpr double kFloatRounding = 1.2e-7;  // relative

/// Distance of a candidate's two primitives, less its radius [mm].
template <class Points>
ANGIO_HOST_DEVICE inline double gap_at(const Points& x, const Candidate& c) {
  const Vec3 p[4] = {x[std::size_t(c.vertex[0])], x[std::size_t(c.vertex[1])],
                     x[std::size_t(c.vertex[2])], x[std::size_t(c.vertex[3])]};
  const GapWeights<double> weights = closest_points(c, p);
  Vec3 gap;
  for (int i = 0; i < 4; ++i) gap += weights.w[i] * p[i];
  return norm(gap) - double(c.radius);
}

/// Sets a candidate's gap if it is less than `radius`. @return is it?
template <class Points>
ANGIO_HOST_DEVICE inline bool take_gap(const Points& x, double radius, Candidate& candidate) {
  const double gap = gap_at(x, candidate);
  if (!(gap < radius)) return false;
  candidate.gap = float(gap - kFloatRounding * std::abs(gap));  // not rounded up
  return true;
}

/// The shaft keeps the space that the folded or slender balloon has left it, so that it touches
/// nothing at the start; within a contact distance of each other the two are tied.
///
/// @param start  of the scene. @return are they no such pair?
template <class Points>
ANGIO_HOST_DEVICE inline bool take_radius(const Points& start, double rod_radius,
                                          double contact_distance, Candidate& candidate) {
  const double gap = gap_at(start, candidate) - contact_distance;
  candidate.shaft = true;
  candidate.radius = float(gap < rod_radius ? gap : rod_radius);
  return gap > 0.0;
}

/// Sets the gap below which a pair of one surface acts.
///
/// @param start  of the scene
template <class Points>
ANGIO_HOST_DEVICE inline void take_self_distance(const Points& start, double self_distance,
                                                 Candidate& candidate) {
  const double share = kShareOfStartGap * gap_at(start, candidate);
  candidate.self = true;
  candidate.distance = float(share < self_distance ? share : self_distance);
}

/// The order of a vertex's candidates: by ascending gap, then by vertices.
ANGIO_HOST_DEVICE inline bool comes_before(const Candidate& a, const Candidate& b) {
  if (a.gap != b.gap) return a.gap < b.gap;
  if (a.edges != b.edges) return b.edges;
  for (int i = 1; i < 3; ++i)
    if (a.vertex[i] != b.vertex[i]) return a.vertex[i] < b.vertex[i];
  return a.vertex[3] < b.vertex[3];
}

}  // namespace angio::simulation::detail
