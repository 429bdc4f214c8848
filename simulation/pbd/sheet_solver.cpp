#include "simulation/pbd/sheet_solver.hpp"

#include <algorithm>
#include <limits>

#include "simulation/bodies/numbering.hpp"
#include "simulation/materials/symmetric3.hpp"

namespace angio::simulation::detail {
namespace {

using Batch = SheetSolver::Batch;
using Corners = SheetSolver::Corners;
using View = SheetSolver::View;
constexpr int kBatch = SheetSolver::kBatch;

// Of its shortest edge: farther no vertex goes at once, so that no triangle turns over.
constexpr double kReach = 0.25;
constexpr float kShift = 1e-6F;  // where the membrane has no stiffness at all

/// membrane_term of all triangles at some vertices of a batch; of the Hessian the upper half.
template <int kWidth>
VertexTerm<Pack<float, kWidth>> skin_term(const View& s, const Batch& batch, int lane,
                                          const Vec3T<Pack<float, kWidth>>& x) {
  using Lanes = Pack<float, kWidth>;
  const MooneyRivlin<Lanes> law{Lanes(s.law.c1), Lanes(s.law.c2)};
  VertexTerm<Lanes> sum;
  for (int c = batch.corner_begin; c < batch.corner_end; ++c) {
    const Corners& corner = s.corners[c];
    const auto n = load_points<kWidth>([&](int i) { return s.points[corner.next[lane + i]]; });
    const auto m = load_points<kWidth>([&](int i) { return s.points[corner.last[lane + i]]; });
    CornerMetric<Lanes> metric;
    metric.k11 = Lanes::load(corner.k11 + lane);
    metric.k12 = Lanes::load(corner.k12 + lane);
    metric.k22 = Lanes::load(corner.k22 + lane);
    metric.inverse_det = Lanes::load(corner.inverse_det + lane);
    metric.volume = Lanes::load(corner.volume + lane);
    const Vec3T<Lanes> e1 = x - n, e2 = m - n;
    const Invariants<Lanes> i = invariants(metric, e1, e2);
    const VertexTerm<Lanes> term = membrane_term(metric, plain_energy(law, i.i1, i.i3), e1, e2);
    sum.gradient += term.gradient;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) sum.hessian(a, b) += term.hessian(a, b);
  }
  return sum;
}

/// A Newton step of some vertices of a batch, each in its own block.
template <int kWidth>
void move_vertices(const View& s, const Batch& batch, int lane) {
  using Lanes = Pack<float, kWidth>;
  const int first = batch.first + lane;
  const auto x = load_points<kWidth>([&](int i) { return s.points[first + i]; });
  const auto inertial = load_points<kWidth>([&](int i) { return s.inertial[first + i]; });
  VertexTerm<Lanes> term = skin_term<kWidth>(s, batch, lane, x);
  const Lanes inertia = Lanes(s.per_time_squared) * Lanes::load(s.mass + first);
  for (int a = 0; a < 3; ++a) {
    term.hessian(a, a) += inertia;
    for (int b = 0; b < a; ++b) term.hessian(a, b) = term.hessian(b, a);
  }
  const Vec3T<Lanes> force = inertia * (inertial - x) - term.gradient;
  const Vec3T<Lanes> move =
      Lanes(s.relaxation) * (inverse_block(term.hessian, Lanes(kShift)) * force);
  const Lanes length = norm(move), reach = Lanes::load(s.reach + first);
  const Lanes share = select(length > reach, reach / length, Lanes(1.0F));
  store_points(x + share * move, s.points + first);
}

template <int kWidth>
void sweep(const View& s) {
  for (int b = 0; b < s.batch_count; ++b)
    for (int lane = 0; lane < kBatch; lane += kWidth) move_vertices<kWidth>(s, s.batches[b], lane);
}

using Sweep = void (*)(const View&);

[[gnu::flatten]] void sweep_plain(const View& s) { sweep<8>(s); }
#if defined(__x86_64__)
[[gnu::flatten, gnu::target("avx2")]] void sweep_avx2(const View& s) { sweep<8>(s); }
[[gnu::flatten, gnu::target("avx512f,avx512dq,avx512vl")]] void sweep_avx512(const View& s) {
  sweep<16>(s);
}
#endif

Sweep choose_sweep(int lanes) {
#if defined(__x86_64__)
  const bool is_wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                       __builtin_cpu_supports("avx512vl");
  if (is_wide && lanes != 8) return &sweep_avx512;
  if (__builtin_cpu_supports("avx2")) return &sweep_avx2;
#endif
  return &sweep_plain;
}

PackedPoint packed(const Vec3& p) { return {float(p.x), float(p.y), float(p.z)}; }

}  // namespace

struct SheetSolver::Ring {
  struct Corner {
    int next = 0, last = 0;  // vertices
    CornerMetric<double> metric;
  };
  std::vector<Corner> corners;
  double shortest_edge = std::numeric_limits<double>::max();  // [mm]
};

SheetSolver::SheetSolver(const TriangleMesh& rest, const MooneyRivlin<double>& law,
                         double thickness, double density, const std::vector<char>& fixed)
    : law_{float(law.c1), float(law.c2)}, place_(rest.vertices.size()) {
  for (const Vec3& x : rest.vertices) origin_ += (1.0 / double(rest.vertices.size())) * x;
  const std::vector<Ring> around = rings(rest, thickness);
  const std::vector<int> vertex_at = place_vertices(rest, around, fixed);
  add_corners(vertex_at, around);
  const std::vector<double> areas = vertex_areas(rest);
  for (const int v : vertex_at) {
    const auto i = std::size_t(v);
    points_.push_back(packed(rest.vertices[i] - origin_));
    mass_.push_back(float(density * thickness * areas[i]));
    reach_.push_back(float(kReach * around[i].shortest_edge));
  }
  before_ = inertial_ = points_;
  velocities_.assign(points_.size(), {});
}

std::vector<SheetSolver::Ring> SheetSolver::rings(const TriangleMesh& rest, double thickness) {
  std::vector<Ring> all(rest.vertices.size());
  for (const Triangle& t : rest.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int n = t[(k + 1) % 3], m = t[(k + 2) % 3];
      const Vec3 &v = rest.vertices[std::size_t(t[k])], &next = rest.vertices[std::size_t(n)],
                 &last = rest.vertices[std::size_t(m)];
      Ring& ring = all[std::size_t(t[k])];
      ring.corners.push_back({n, m, corner_metric(v, next, last, thickness)});
      ring.shortest_edge = std::min({ring.shortest_edge, distance(v, next), distance(v, last)});
    }
  return all;
}

/// Colour by colour in whole batches, then what does not move. @return the vertex at each place
std::vector<int> SheetSolver::place_vertices(const TriangleMesh& rest,
                                             const std::vector<Ring>& rings,
                                             std::vector<char> fixed) {
  fixed.resize(rest.vertices.size(), 0);
  for (std::size_t v = 0; v < fixed.size(); ++v)
    if (rings[v].corners.empty()) fixed[v] = 1;
  Numbering numbering = number_vertices(rest, fixed);
  color_count_ = int(numbering.begin.size()) - 1;
  std::vector<int> vertex_at;
  for (int color = 0; color < color_count_; ++color) {
    const auto begin = numbering.order.begin() + numbering.begin[std::size_t(color)],
               end = numbering.order.begin() + numbering.begin[std::size_t(color) + 1];
    // With vertices of as many triangles a batch has no idle lanes.
    std::stable_sort(begin, end, [&](int a, int b) {
      return rings[std::size_t(a)].corners.size() > rings[std::size_t(b)].corners.size();
    });
    for (auto v = begin; v < end; v += std::min<std::ptrdiff_t>(kBatch, end - v)) {
      batches_.push_back({int(vertex_at.size()), 0, 0});
      for (std::ptrdiff_t lane = 0; lane < kBatch; ++lane)
        vertex_at.push_back(v[std::min(lane, end - v - 1)]);
    }
  }
  moving_ = int(vertex_at.size());
  vertex_at.insert(vertex_at.end(), numbering.order.begin() + numbering.begin.back(),
                   numbering.order.end());
  // Backwards, so that a vertex's place is not that of its copies.
  for (std::size_t p = vertex_at.size(); p-- > 0;) place_[std::size_t(vertex_at[p])] = int(p);
  return vertex_at;
}

void SheetSolver::add_corners(const std::vector<int>& vertex_at, const std::vector<Ring>& rings) {
  const auto ring_at = [&](int place) -> const std::vector<Ring::Corner>& {
    return rings[std::size_t(vertex_at[std::size_t(place)])].corners;
  };
  for (Batch& batch : batches_) {
    batch.corner_begin = int(corners_.size());
    const std::size_t most = ring_at(batch.first).size();
    for (std::size_t c = 0; c < most; ++c) {
      Corners& corners = corners_.emplace_back();
      for (int lane = 0; lane < kBatch; ++lane) {
        const auto& ring = ring_at(batch.first + lane);
        const Ring::Corner& corner = ring[std::min(c, ring.size() - 1)];
        corners.next[lane] = place_[std::size_t(corner.next)];
        corners.last[lane] = place_[std::size_t(corner.last)];
        corners.k11[lane] = float(corner.metric.k11);
        corners.k12[lane] = float(corner.metric.k12);
        corners.k22[lane] = float(corner.metric.k22);
        corners.inverse_det[lane] = float(corner.metric.inverse_det);
        corners.volume[lane] = c < ring.size() ? float(corner.metric.volume) : 0.0F;
      }
    }
    batch.corner_end = int(corners_.size());
  }
}

void SheetSolver::set_position(int vertex, const Vec3& position) {
  points_[std::size_t(place_[std::size_t(vertex)])] = packed(position - origin_);
}

void SheetSolver::predict(float dt) {
  before_ = points_;
  for (std::size_t p = 0; p < std::size_t(moving_); ++p) {
    const PackedPoint& u = velocities_[p];
    points_[p].x += dt * u.x;
    points_[p].y += dt * u.y;
    points_[p].z += dt * u.z;
  }
  inertial_ = points_;
}

void SheetSolver::step(const SheetStep& options) {
  const float dt = float(options.dt);
  const bool has_inertia = dt > 0.0F;
  if (has_inertia) predict(dt);
  View view;
  view.law = law_;
  view.batches = batches_.data();
  view.batch_count = int(batches_.size());
  view.corners = corners_.data();
  view.points = points_.data();
  view.inertial = inertial_.data();
  view.mass = mass_.data();
  view.reach = reach_.data();
  view.per_time_squared = has_inertia ? 1.0F / (dt * dt) : 0.0F;
  view.relaxation = float(options.relaxation);
  const Sweep sweep_all = choose_sweep(options.lanes);
  for (int i = 0; i < options.sweeps; ++i) sweep_all(view);
  if (!has_inertia) return;
  for (std::size_t p = 0; p < std::size_t(moving_); ++p) {
    const PackedPoint &x = points_[p], &y = before_[p];
    velocities_[p] = {(x.x - y.x) / dt, (x.y - y.y) / dt, (x.z - y.z) / dt};
  }
}

std::vector<Vec3> SheetSolver::positions() const {
  std::vector<Vec3> x;
  for (const int place : place_) {
    const PackedPoint& p = points_[std::size_t(place)];
    x.push_back(origin_ + Vec3{p.x, p.y, p.z});
  }
  return x;
}

}  // namespace angio::simulation::detail
