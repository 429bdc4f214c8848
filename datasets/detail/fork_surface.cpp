#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "datasets/detail/lumen_surface.hpp"
#include "datasets/detail/section.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kAboveCarina = 1.0;  // [daughter radii] the fork's middle
constexpr double kTurnLength = 3.0;   // [radii] within which rows become upright
constexpr int kSpreadSteps = 30;

double smoothstep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Directions in the plane of the fork, by their angle from the line between the daughters towards
/// daughter 0.
struct ForkPlane {
  Vec3 down;    ///< between the daughters
  Vec3 toward;  ///< daughter 0
  Vec3 front;   ///< out of the plane

  [[nodiscard]] double angle(const Vec3& d) const {
    return std::atan2(dot(d, toward), dot(d, down));
  }
  [[nodiscard]] Vec3 direction(double angle) const {
    return std::cos(angle) * down + std::sin(angle) * toward;
  }
};

/// One of the three tubes: it leaves the fork's middle along a branch.
struct Tube {
  const Branch* branch = nullptr;
  int nearest = 0;                     ///< sample of the branch nearest to the fork's middle
  int end = 0;                         ///< sample of the open end
  std::array<double, 2> fork_angle{};  ///< of both half-planes of its innermost ring [radian]
  std::array<double, 2> side{};        ///< of the branch on which they lie, +1 or -1

  [[nodiscard]] double length() const { return std::abs(end - nearest) * branch->step_mm; }
};

struct Fork {
  ForkPlane plane;
  Vec3 middle;
  std::array<Tube, 3> tubes;  ///< trunk, daughter 0, daughter 1
};

int nearest_sample(const Branch& branch, const Vec3& point, int first, int last) {
  int best = first;
  for (int s = first; s <= last; ++s)
    if (distance(branch.center[std::size_t(s)], point) <
        distance(branch.center[std::size_t(best)], point))
      best = s;
  return best;
}

Fork find_fork(const LumenShape& shape) {
  ANGIO_EXPECT(shape.branches().size() == 2 && shape.branches()[1].parent == 0);
  const Branch& main = shape.branches()[0];
  const Branch& side = shape.branches()[1];
  const Vec3 daughter[2] = {main.tangent(main.last_sample), side.tangent(side.last_sample)};
  Fork fork;
  ForkPlane& plane = fork.plane;
  plane.down = normalized(daughter[0] + daughter[1]);
  plane.toward = normalized(daughter[0] - dot(daughter[0], plane.down) * plane.down);
  plane.front = cross(plane.down, plane.toward);
  const Vec3 start = main.center[std::size_t(side.parent_sample)];
  const double radius = side.healthy_mm[std::size_t(side.last_sample)];
  fork.middle =
      start + (distance_to_wall(shape, start, plane.down) - kAboveCarina * radius) * plane.down;

  const double pi = units::kPi;
  const double angle[2] = {plane.angle(daughter[0]), plane.angle(daughter[1])};
  // Halfway between what is upright in the trunk and in the daughter.
  const double outer[2] = {0.5 * pi + 0.5 * angle[0], -0.5 * pi + 0.5 * angle[1]};
  const int below = nearest_sample(main, fork.middle, side.parent_sample, main.last_sample);
  fork.tubes[0] = {&main, below, main.first_sample, {outer[0], outer[1]}, {1.0, -1.0}};
  fork.tubes[1] = {&main, below, main.last_sample, {0.0, outer[0]}, {-1.0, 1.0}};
  const int beside = nearest_sample(side, fork.middle, side.first_sample, side.last_sample);
  fork.tubes[2] = {&side, beside, side.last_sample, {outer[1], 0.0}, {-1.0, 1.0}};
  return fork;
}

/// The middle of a ring, and the angles of its half-planes.
struct Station {
  Vec3 center;
  std::array<double, 2> angle{};
};

Station station_at(const Fork& fork, const Tube& tube, double share) {
  const Branch& branch = *tube.branch;
  const double exact = tube.nearest + share * (tube.end - tube.nearest);
  const int below = std::clamp(int(std::floor(exact)), 0, int(branch.center.size()) - 2);
  const double t = exact - below;
  const auto at = [&](int sample) { return branch.center[std::size_t(sample)]; };
  const double radius = branch.healthy_mm[std::size_t(tube.nearest)];
  const double turned = smoothstep(share * tube.length() / (kTurnLength * radius));
  Station station;
  station.center =
      (1.0 - t) * at(below) + t * at(below + 1) + (1.0 - turned) * (fork.middle - at(tube.nearest));
  const double along = fork.plane.angle(branch.tangent(int(std::lround(exact))));
  for (std::size_t half = 0; half < 2; ++half) {
    const double upright = along + 0.5 * units::kPi * tube.side[half];
    station.angle[half] = tube.fork_angle[half] + turned * (upright - tube.fork_angle[half]);
  }
  return station;
}

class ForkMesher {
 public:
  ForkMesher(const LumenShape& shape, int vertices_per_ring)
      : shape_(shape), fork_(find_fork(shape)), n_(vertices_per_ring) {}

  TriangleMesh make(int row_count) {
    const std::array<int, 3> rows = share_rows(row_count);
    add_arcs();
    for (std::size_t tube = 0; tube < 3; ++tube) add_tube(tube, rows[tube]);
    turn_outward();
    spread_on_wall(shape_, mesh_, held_, kSpreadSteps);
    return std::move(mesh_);
  }

 private:
  [[nodiscard]] std::array<int, 3> share_rows(int row_count) const {
    double total = 0.0;
    for (const Tube& tube : fork_.tubes) total += tube.length();
    std::array<int, 3> rows{};
    for (std::size_t d = 1; d < 3; ++d)
      rows[d] = int(std::lround(row_count * fork_.tubes[d].length() / total));
    rows[0] = row_count - rows[1] - rows[2];
    ANGIO_EXPECT(rows[0] >= 2 && rows[1] >= 2 && rows[2] >= 2);
    return rows;
  }

  /// @param turn  from the front (0) through the half-plane to behind (1)
  int add_vertex(const Vec3& center, double angle, double turn) {
    const Vec3 ray = std::cos(turn * units::kPi) * fork_.plane.front +
                     std::sin(turn * units::kPi) * fork_.plane.direction(angle);
    mesh_.vertices.push_back(center + distance_to_wall(shape_, center, ray) * ray);
    return int(mesh_.vertices.size()) - 1;
  }

  /// The vertices of the three arcs in the fork, all from the point in front to that behind.
  void add_arcs() {
    const int front = add_vertex(fork_.middle, 0.0, 0.0);
    const int behind = add_vertex(fork_.middle, 0.0, 1.0);
    const double angles[3] = {0.0, fork_.tubes[1].fork_angle[1], fork_.tubes[2].fork_angle[0]};
    for (std::size_t arc = 0; arc < 3; ++arc) {
      arcs_[arc].push_back(front);
      for (int k = 1; k < n_ / 2; ++k)
        arcs_[arc].push_back(add_vertex(fork_.middle, angles[arc], 2.0 * k / n_));
      arcs_[arc].push_back(behind);
    }
  }

  /// A ring runs along the tube's first half-plane from the front to behind, and back along the
  /// second.
  void add_tube(std::size_t index, int row_count) {
    constexpr std::array<std::array<std::size_t, 2>, 3> kArcsOfTube{{{1, 2}, {0, 1}, {2, 0}}};
    const Tube& tube = fork_.tubes[index];
    std::vector<int> ring;
    const auto& there = arcs_[kArcsOfTube[index][0]];
    const auto& back = arcs_[kArcsOfTube[index][1]];
    ring.assign(there.begin(), there.end() - 1);
    ring.insert(ring.end(), back.rbegin(), back.rend() - 1);
    for (int row = 1; row <= row_count; ++row) {
      const Station station = station_at(fork_, tube, double(row) / row_count);
      std::vector<int> next;
      for (int k = 0; k < n_; ++k)
        next.push_back(add_vertex(station.center, station.angle[k < n_ / 2 ? 0 : 1],
                                  k < n_ / 2 ? 2.0 * k / n_ : 2.0 - 2.0 * k / n_));
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const std::size_t l = (k + 1) % ring.size();
        mesh_.triangles.push_back({ring[k], ring[l], next[l]});
        mesh_.triangles.push_back({ring[k], next[l], next[k]});
      }
      ring = next;
    }
    held_.resize(mesh_.vertices.size(), 0);
    for (const int v : ring) held_[std::size_t(v)] = 1;
  }

  /// All tubes turn the same way around the front.
  void turn_outward() {
    double outward = 0.0;
    for (const Triangle& t : mesh_.triangles)
      outward +=
          dot(area_vector_doubled(mesh_, t),
              shape_.nearest_wall(mesh_.vertices[std::size_t(t[0])], LumenShape::Ends::continued)
                  .normal);
    if (outward >= 0.0) return;
    for (Triangle& t : mesh_.triangles) std::swap(t[1], t[2]);
  }

  const LumenShape& shape_;
  Fork fork_;
  int n_;
  TriangleMesh mesh_;
  std::vector<char> held_;
  std::array<std::vector<int>, 3> arcs_;  ///< between the daughters, beside 0, beside 1
};

}  // namespace

TriangleMesh fork_wall(const LumenShape& shape, int vertices_per_ring, int row_count) {
  ANGIO_EXPECT(vertices_per_ring >= 8 && vertices_per_ring % 2 == 0 && row_count >= 12);
  return ForkMesher(shape, vertices_per_ring).make(row_count);
}

}  // namespace angio::datasets::detail
