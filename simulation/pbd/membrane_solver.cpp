#include "simulation/pbd/membrane_solver.hpp"

#include <algorithm>

#include "core/simd.hpp"

namespace angio::simulation::detail {
namespace {

using Particle = PbdSolver::Particle;
using Batch = PbdSolver::Batch;
constexpr int kLanes = PbdSolver::kLanes;
using Lanes = Pack<float, kLanes>;

/// Colours in which no two triangles share a vertex.
std::vector<int> color_triangles(const TriangleMesh& mesh) {
  std::vector<std::vector<int>> used(mesh.vertices.size());
  std::vector<int> colors;
  for (const Triangle& t : mesh.triangles) {
    int color = 0;
    const auto taken = [&](int v) {
      const auto& list = used[std::size_t(v)];
      return std::find(list.begin(), list.end(), color) != list.end();
    };
    while (taken(t[0]) || taken(t[1]) || taken(t[2])) ++color;
    for (const int v : t) used[std::size_t(v)].push_back(color);
    colors.push_back(color);
  }
  return colors;
}

struct Corner8 {
  Vec3T<Lanes> position;
  Lanes inverse_mass;
};

Corner8 gather(const Particle* particles, const int* index) {
  Corner8 c;
  for (int lane = 0; lane < kLanes; ++lane) {
    const Particle& p = particles[index[lane]];
    c.position.x.set(lane, p.x);
    c.position.y.set(lane, p.y);
    c.position.z.set(lane, p.z);
    c.inverse_mass.set(lane, p.inverse_mass);
  }
  return c;
}

void scatter(Particle* particles, const int* index, const Vec3T<Lanes>& position) {
  for (int lane = 0; lane < kLanes; ++lane) {
    Particle& p = particles[index[lane]];
    p.x = position.x[lane];
    p.y = position.y[lane];
    p.z = position.z[lane];
  }
}

/// Psi and its derivatives by a = e1.e1, b = e1.e2, c = e2.e2.
template <class Real>
struct MetricEnergy {
  Real value{}, by_a{}, by_b{}, by_c{};
};

/// plain_energy in differences from rest, without cancellation near rest in single precision. With
/// d1 = I1 - 2, d3 = I3 - 1 = d1 + D and D = det(C - I):
///
///     Psi = C1 (d3^2 / I3 - D) + C2 (d3^2 - D) / I3
///     dPsi/dI1 + dPsi/dI3 = (C1 d3 (2 + d3) + C2 (3 d3 + d3^2 - d1)) / I3^2
template <class Real>
MetricEnergy<Real> energy_by_metric(const MooneyRivlin<Real>& law, const CornerMetric<Real>& k,
                                    const Vec3T<Real>& e1, const Vec3T<Real>& e2) {
  const Real a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2);
  const Real s = k.inverse_det;
  const Real da = a - k.k22 / s, db = b + k.k12 / s, dc = c - k.k11 / s;
  const Real d1 = k.k11 * da + Real(2) * k.k12 * db + k.k22 * dc;
  const Real determinant = (da * dc - db * db) * s;
  // Of slivers the cross product gives the area without cancellation.
  const Real i3 = norm_squared(cross(e1, e2)) * s;
  const Real near_one = d1 + determinant;
  const Real d3 = select(near_one * near_one < Real(0.01F), near_one, i3 - Real(1));
  const Real r = Real(1) / i3;
  const Real square = d3 * d3;
  const Real by_i3 = law.c2 - (law.c1 + law.c2 * (Real(2) + d1)) * r * r;
  const Real sum = (law.c1 * d3 * (Real(2) + d3) + law.c2 * (Real(3) * d3 + square - d1)) * r * r;
  MetricEnergy<Real> e;
  e.value = law.c1 * (square * r - determinant) + law.c2 * (square - determinant) * r;
  e.by_a = sum * k.k11 + by_i3 * s * dc;
  e.by_b = Real(2) * (sum * k.k12 - by_i3 * s * db);
  e.by_c = sum * k.k22 + by_i3 * s * da;
  return e;
}

/// dx_i = -k w_i (E / sum_j w_j |dE/dx_j|^2) dE/dx_i on eight triangles. Neither volume nor the
/// scale of the moduli matters to it, so E is the energy density by moduli of sum one.
void project(const MooneyRivlin<Lanes>& law, const Lanes& stiffness, const Batch& batch,
             Particle* particles) {
  CornerMetric<Lanes> metric;
  metric.k11 = Lanes::load(batch.k11);
  metric.k12 = Lanes::load(batch.k12);
  metric.k22 = Lanes::load(batch.k22);
  metric.inverse_det = Lanes::load(batch.inverse_det);
  Corner8 v = gather(particles, batch.corner[0]);
  Corner8 n = gather(particles, batch.corner[1]);
  Corner8 m = gather(particles, batch.corner[2]);
  const Vec3T<Lanes> e1 = v.position - n.position, e2 = m.position - n.position;
  const MetricEnergy<Lanes> psi = energy_by_metric(law, metric, e1, e2);
  const Vec3T<Lanes> gradient_v = Lanes(2) * psi.by_a * e1 + psi.by_b * e2;
  const Vec3T<Lanes> gradient_m = Lanes(2) * psi.by_c * e2 + psi.by_b * e1;
  const Vec3T<Lanes> gradient_n = -(gradient_v + gradient_m);
  const Lanes weight = v.inverse_mass * norm_squared(gradient_v) +
                       n.inverse_mass * norm_squared(gradient_n) +
                       m.inverse_mass * norm_squared(gradient_m);
  // Strains below 1e-6 are single precision's noise; there both E and its gradient vanish.
  const Lanes step = select(psi.value > Lanes(1e-12F), stiffness * psi.value / weight, Lanes(0.0F));
  v.position -= (step * v.inverse_mass) * gradient_v;
  n.position -= (step * n.inverse_mass) * gradient_n;
  m.position -= (step * m.inverse_mass) * gradient_m;
  scatter(particles, batch.corner[0], v.position);
  scatter(particles, batch.corner[1], n.position);
  scatter(particles, batch.corner[2], m.position);
}

struct Batches {
  MooneyRivlin<Lanes> law;
  Lanes stiffness;
  const Batch* first = nullptr;
  std::ptrdiff_t count = 0;
  Particle* particles = nullptr;
};

[[gnu::flatten]] void project_all(const Batches& b) {
  for (std::ptrdiff_t i = 0; i < b.count; ++i) project(b.law, b.stiffness, b.first[i], b.particles);
}
#if defined(__x86_64__)
[[gnu::flatten, gnu::target("avx2")]] void project_all_avx2(const Batches& b) {
  for (std::ptrdiff_t i = 0; i < b.count; ++i) project(b.law, b.stiffness, b.first[i], b.particles);
}
#endif

}  // namespace

PbdSolver::PbdSolver(const TriangleMesh& rest, const MooneyRivlin<double>& law, double thickness,
                     double density, const std::vector<char>& fixed)
    : law_{float(law.c1 / (law.c1 + law.c2)), float(law.c2 / (law.c1 + law.c2))},
      origin_(rest.vertices.front()),
      particles_(rest.vertices.size() + 1),
      velocities_(rest.vertices.size()) {
  const std::vector<double> areas = vertex_areas(rest);
  for (std::size_t v = 0; v < areas.size(); ++v) {
    set_position(int(v), rest.vertices[v]);
    const bool is_free = fixed.empty() || fixed[v] == 0;
    particles_[v].inverse_mass = is_free ? float(1.0 / (density * thickness * areas[v])) : 0.0F;
  }
  add_batches(rest, thickness);
}

void PbdSolver::set_position(int vertex, const Vec3& position) {
  Particle& p = particles_[std::size_t(vertex)];
  p.x = float(position.x - origin_.x);
  p.y = float(position.y - origin_.y);
  p.z = float(position.z - origin_.z);
}

void PbdSolver::add_batches(const TriangleMesh& rest, double thickness) {
  const std::vector<int> colors = color_triangles(rest);
  const int nobody = int(rest.vertices.size());
  color_begin_.push_back(0);
  const int color_count = 1 + *std::max_element(colors.begin(), colors.end());
  for (int color = 0; color < color_count; ++color) {
    int lane = kLanes;
    for (std::size_t t = 0; t < colors.size(); ++t) {
      if (colors[t] != color) continue;
      if (lane == kLanes) {
        Batch empty{};
        for (auto& corner : empty.corner) std::fill_n(corner, kLanes, nobody);
        batches_.push_back(empty);
        lane = 0;
      }
      const Triangle& triangle = rest.triangles[t];
      Batch& batch = batches_.back();
      for (std::size_t k = 0; k < 3; ++k) batch.corner[k][lane] = triangle[k];
      const CornerMetric<double> metric = corner_metric(
          rest.vertices[std::size_t(triangle[0])], rest.vertices[std::size_t(triangle[1])],
          rest.vertices[std::size_t(triangle[2])], thickness);
      batch.k11[lane] = float(metric.k11);
      batch.k12[lane] = float(metric.k12);
      batch.k22[lane] = float(metric.k22);
      batch.inverse_det[lane] = float(metric.inverse_det);
      ++lane;
    }
    color_begin_.push_back(int(batches_.size()));
  }
}

void PbdSolver::step(const PbdStep& options, const std::vector<Vec3>& forces) {
  const std::size_t count = velocities_.size();
  const float time = float(options.dt), kept = float(1.0 - options.damping);
  std::vector<Particle> before(particles_.begin(), particles_.end() - 1);
  for (std::size_t v = 0; v < count; ++v) {
    Particle& p = particles_[v];
    Vec3T<float>& u = velocities_[v];
    u *= kept;
    if (!forces.empty()) {
      const float push = time * p.inverse_mass;
      u += push * Vec3T<float>{float(forces[v].x), float(forces[v].y), float(forces[v].z)};
    }
    if (p.inverse_mass == 0.0F) u = {};
    p.x += time * u.x;
    p.y += time * u.y;
    p.z += time * u.z;
  }
  Batches all;
  all.law = {Lanes(law_.c1), Lanes(law_.c2)};
  all.stiffness = Lanes(float(options.stiffness));
  all.particles = particles_.data();
  all.first = batches_.data();
  all.count = std::ptrdiff_t(batches_.size());
  for (int i = 0; i < options.iterations; ++i) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) {
      project_all_avx2(all);
      continue;
    }
#endif
    project_all(all);
  }
  for (std::size_t v = 0; v < count; ++v) {
    const Particle &p = particles_[v], &q = before[v];
    velocities_[v] = (1.0F / time) * Vec3T<float>{p.x - q.x, p.y - q.y, p.z - q.z};
  }
}

std::vector<Vec3> PbdSolver::positions() const {
  std::vector<Vec3> x;
  for (std::size_t v = 0; v < velocities_.size(); ++v) {
    const Particle& p = particles_[v];
    x.push_back(origin_ + Vec3{p.x, p.y, p.z});
  }
  return x;
}

}  // namespace angio::simulation::detail
