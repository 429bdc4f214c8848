#include "simulation/newton/initial_capsule.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

void add_ring(Capsule& capsule, double radius, double z) {
  for (int k = 0; k < capsule.around; ++k) {
    const double angle = 2.0 * units::kPi * k / capsule.around;
    capsule.mesh.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
}

void add_triangles(Capsule& capsule, int ring_count) {
  auto& triangles = capsule.mesh.triangles;
  const int n = capsule.around;
  for (int r = 0; r + 1 < ring_count; ++r)
    for (int k = 0; k < n; ++k) {
      const int a = r * n + k, b = r * n + (k + 1) % n;
      const int c = a + n, d = b + n;
      if ((r - capsule.middle_ring) % 2 == 0) {
        triangles.push_back({a, b, c});
        triangles.push_back({b, d, c});
      } else {
        triangles.push_back({a, d, c});
        triangles.push_back({a, b, d});
      }
    }
  capsule.membrane = triangles;
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n, last = (ring_count - 1) * n;
    triangles.push_back({capsule.low_pole, next, k});
    triangles.push_back({capsule.high_pole, last + k, last + next});
  }
}

// The rings of the cylinder, with those of the caps where there are any, and the poles.
void add_rings(Capsule& capsule, double radius, int half, int cap) {
  capsule.first_ring = std::max(0, cap - 1);
  capsule.middle_ring = capsule.first_ring + half;
  capsule.last_ring = capsule.middle_ring + half;
  const int ring_count = capsule.last_ring + std::max(1, cap);
  capsule.circle_factor = 1.0 / std::cos(units::kPi / capsule.around);
  const double circle = radius * capsule.circle_factor;
  for (int r = 0; r < ring_count; ++r) {
    const int from_middle = std::abs(r - capsule.middle_ring);
    const double up = cap > 0 ? 0.5 * units::kPi * std::max(0, from_middle - half) / cap : 0.0;
    const double z =
        0.5 * capsule.length * std::min(from_middle, half) / half + radius * std::sin(up);
    add_ring(capsule, circle * std::cos(up), r < capsule.middle_ring ? -z : z);
  }
  const double pole = 0.5 * capsule.length + (cap > 0 ? radius : 0.0);
  capsule.low_pole = int(capsule.mesh.vertices.size());
  capsule.high_pole = capsule.low_pole + 1;
  capsule.mesh.vertices.push_back({0, 0, -pole});
  capsule.mesh.vertices.push_back({0, 0, pole});
  add_triangles(capsule, ring_count);
}

// Between rings of squares, halved.
double ring_spacing(double radius, int around) {
  return 2.0 * radius * std::tan(units::kPi / around);
}

}  // namespace

Capsule make_capsule(double radius, double length, int around) {
  Capsule capsule;
  capsule.around = around;
  capsule.length = length;
  const double spacing = ring_spacing(radius, around);
  const int half = std::max(2, int(std::lround(0.5 * length / spacing)));
  const int cap = std::max(2, int(std::lround(0.5 * units::kPi * radius / spacing)));
  add_rings(capsule, radius, half, cap);
  capsule.membrane = capsule.mesh.triangles;
  return capsule;
}

Capsule make_tube_piece(double radius, int around) {
  Capsule piece;
  piece.around = around;
  piece.length = 4.0 * ring_spacing(radius, around);
  add_rings(piece, radius, 2, 0);
  return piece;
}

PlaneTerm::PlaneTerm(const Capsule& capsule, double stiffness)
    : pole_(capsule.high_pole),
      begin_(capsule.last_ring * capsule.around),
      end_(begin_ + capsule.around),
      stiffness_(stiffness) {}

double PlaneTerm::value(const std::vector<Vec3>& x) const {
  double sum = 0.0;
  for (int v = begin_; v < end_; ++v) {
    const double off = x[std::size_t(v)].z - x[std::size_t(pole_)].z;
    sum += 0.5 * stiffness_ * off * off;
  }
  return sum;
}

void PlaneTerm::add(const std::vector<Vec3>& x, bool, Assembly& out) const {
  Mat3 block;
  block(2, 2) = stiffness_;
  for (int v = begin_; v < end_; ++v) {
    const Vec3 slope{0, 0, stiffness_ * (x[std::size_t(v)].z - x[std::size_t(pole_)].z)};
    out.add_gradient(v, slope);
    out.add_gradient(pole_, -slope);
    out.add_block(v, v, block);
    out.add_block(v, pole_, -1.0 * block);
    out.add_block(pole_, pole_, block);
  }
}

std::vector<char> without_rigid_motion(const Capsule& capsule) {
  std::vector<char> fixed(capsule.mesh.vertices.size(), 0);
  fixed[std::size_t(capsule.low_pole)] = fixed[std::size_t(capsule.high_pole)] =
      char(kFixedX | kFixedY);
  // On the x axis: y is around, z is along.
  fixed[std::size_t(capsule.middle_ring * capsule.around)] = char(kFixedY | kFixedZ);
  return fixed;
}

}  // namespace angio::simulation::detail
