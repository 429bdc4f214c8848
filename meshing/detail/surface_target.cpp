#include "meshing/detail/surface_target.hpp"

#include <algorithm>
#include <cmath>

namespace angio::meshing::detail {
namespace {

constexpr int kNewtonSteps = 4;

constexpr double kTolerance = 1e-3;  // of the step limit

/// Weights of four samples at -1, 0, 1, 2 for the value and the slope at t in [0, 1].
struct CubicWeights {
  double value[4], slope[4];
};
CubicWeights cubic_weights(double t) {
  const double t2 = t * t;
  const double t3 = t2 * t;
  return {{0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
           0.5 * (-3.0 * t3 + 4.0 * t2 + t), 0.5 * (t3 - t2)},
          {0.5 * (-3.0 * t2 + 4.0 * t - 1.0), 0.5 * (9.0 * t2 - 10.0 * t),
           0.5 * (-9.0 * t2 + 8.0 * t + 1.0), 0.5 * (3.0 * t2 - 2.0 * t)}};
}

}  // namespace

SurfaceTarget::Place SurfaceTarget::project(Vec3 point, double step_limit, double level) const {
  for (int step = 0; step < kNewtonSteps; ++step) {
    const TargetSample here = evaluate(point);
    const double off = here.signed_distance - level;
    if (std::abs(off) < kTolerance * step_limit) return {point, here.normal};
    point -= std::clamp(off, -step_limit, step_limit) * here.normal;
  }
  return {point, evaluate(point).normal};
}

SurfaceTarget::Place SurfaceTarget::project_in_plane(Vec3 point, const Vec3& plane_normal,
                                                     double step_limit, double level) const {
  for (int step = 0; step < kNewtonSteps; ++step) {
    const TargetSample here = evaluate(point);
    const double off = here.signed_distance - level;
    const Vec3 in_plane = here.normal - dot(here.normal, plane_normal) * plane_normal;
    const double sine = norm(in_plane);
    if (std::abs(off) < kTolerance * step_limit || sine < 0.3) return {point, here.normal};
    point -= std::clamp(off / sine, -step_limit, step_limit) * normalized(in_plane);
  }
  return {point, evaluate(point).normal};
}

TargetSample LevelSetTarget::evaluate(const Vec3& point) const {
  const VolumeGeometry& grid = level_set_.geometry;
  const Vec3 index = grid.index_from_lps(point);
  CubicWeights weights[3];
  int first[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int last = grid.size[std::size_t(axis)] - 1;
    const double u = std::clamp(index[axis], 0.0, double(last));
    const int base = std::min(int(u), last - 1);
    weights[axis] = cubic_weights(u - base);
    first[axis] = base - 1;
  }
  const auto at = [&](int axis, int step) {
    return std::clamp(first[axis] + step, 0, grid.size[std::size_t(axis)] - 1);
  };
  double value = 0.0;
  Vec3 slope;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j) {
      double row = 0.0;
      double row_slope = 0.0;
      const std::size_t offset = grid.offset(0, at(1, j), at(2, k));
      for (int i = 0; i < 4; ++i) {
        const double v = double(level_set_.values[offset + std::size_t(at(0, i))]);
        row += weights[0].value[i] * v;
        row_slope += weights[0].slope[i] * v;
      }
      value += weights[2].value[k] * weights[1].value[j] * row;
      slope.x += weights[2].value[k] * weights[1].value[j] * row_slope;
      slope.y += weights[2].value[k] * weights[1].slope[j] * row;
      slope.z += weights[2].slope[k] * weights[1].value[j] * row;
    }
  const Vec3 gradient = grid.direction * Vec3{slope.x / grid.spacing.x, slope.y / grid.spacing.y,
                                              slope.z / grid.spacing.z};
  // A level set need not be an exact distance; its slope makes it one to first order.
  return {value / std::clamp(norm(gradient), 0.3, 3.0), normalized(gradient)};
}

MeshTarget::MeshTarget(const TriangleMesh& mesh)
    : mesh_(mesh), vertex_normals_(angio::vertex_normals(mesh)), closest_(mesh) {}

Vec3 MeshTarget::normal_at(const ClosestPoint::Result& place) const {
  const Triangle& t = mesh_.triangles[std::size_t(place.triangle)];
  const Vec3 n = area_vector_doubled(mesh_, t);
  const double area_squared = norm_squared(n);
  if (!(area_squared > 0.0)) return vertex_normals_[std::size_t(t[0])];
  Vec3 sum;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3& a = mesh_.vertices[std::size_t(t[(c + 1) % 3])];
    const Vec3& b = mesh_.vertices[std::size_t(t[(c + 2) % 3])];
    const double weight = dot(cross(a - place.point, b - place.point), n) / area_squared;
    sum += weight * vertex_normals_[std::size_t(t[c])];
  }
  return normalized(sum);
}

TargetSample MeshTarget::evaluate(const Vec3& point) const {
  const ClosestPoint::Result place = closest_.find(point);
  const Vec3 normal = normal_at(place);
  const bool inside = dot(point - place.point, normal) < 0.0;
  return {inside ? -place.distance : place.distance, normal};
}

}  // namespace angio::meshing::detail
