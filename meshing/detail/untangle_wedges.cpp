#include "meshing/detail/untangle_wedges.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "air_mesh/build/surface_crossings.hpp"
#include "core/parallel.hpp"
#include "meshing/detail/outward_cone.hpp"

namespace angio::meshing::detail {
namespace {

constexpr int kAttempts = 400;        // in all
constexpr int kAttemptsPlace = 120;   // at one place, then it is given up
constexpr int kAttemptsPerRing = 30;  // then the neighbourhood that is relaxed grows by a ring
constexpr double kShrink = 0.98;      // a step
constexpr double kLeastRise = 0.2;    // sine of the angle between a way and the triangles it leaves

class Untangler {
 public:
  Untangler(WallLayers& wall, const TriangleMesh& lumen, double good_shape, double least_shape,
            const std::vector<double>& least_length)
      : wall_(wall),
        lumen_(lumen),
        neighbors_(vertex_neighbors(lumen)),
        count_(lumen.vertices.size()),
        normals_(normals_around_vertices(lumen)),
        outward_(count_),
        good_shape_(good_shape),
        least_shape_(least_shape),
        least_length_(least_length) {
    parallel_for(std::ptrdiff_t(count_), [&](std::ptrdiff_t v) {
      outward_[std::size_t(v)] = most_normal(normals_[std::size_t(v)]);
    });
  }

  std::vector<char> run() {
    std::vector<int> attempts(lumen_.triangles.size(), 0);
    std::vector<char> wrong(attempts.size(), 0);
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      wrong = without_given_up(wrong_wedges(good_shape_), attempts);
      // Crossings are worth a search only where all wedges are right.
      if (!any(wrong)) wrong = without_given_up(crossings(), attempts);
      if (!any(wrong)) break;
      std::vector<int> rings(count_, 0);
      for (std::size_t t = 0; t < wrong.size(); ++t)
        if (wrong[t])
          for (const int v : lumen_.triangles[t])
            rings[std::size_t(v)] =
                std::max(rings[std::size_t(v)], 2 + attempts[t]++ / kAttemptsPerRing);
      relax(within_rings(std::move(rings)));
    }
    wrong = wrong_wedges(least_shape_);
    const std::vector<char> crossing = crossings();
    for (std::size_t t = 0; t < wrong.size(); ++t) wrong[t] = char(wrong[t] | crossing[t]);
    return wrong;
  }

 private:
  static bool any(const std::vector<char>& marked) {
    return std::find(marked.begin(), marked.end(), 1) != marked.end();
  }

  /// By the sharpest of its six corners: the determinant over the product of the three edges.
  [[nodiscard]] bool is_wrong(const std::array<int, 6>& wedge, double least_shape) const {
    const auto at = [&](std::size_t c) { return wall_.vertices[std::size_t(wedge[c])]; };
    for (std::size_t side = 0; side < 6; side += 3)
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 next = at(side + (c + 1) % 3) - at(side + c);
        const Vec3 last = at(side + (c + 2) % 3) - at(side + c);
        const Vec3 up = at(3 + c) - at(c);
        if (dot(cross(next, last), up) <= least_shape * norm(next) * norm(last) * norm(up))
          return true;
      }
    return false;
  }

  /// Triangles of the lumen with a wrong wedge over them.
  [[nodiscard]] std::vector<char> wrong_wedges(double least_shape) const {
    std::vector<char> wrong(lumen_.triangles.size(), 0);
    parallel_for(std::ptrdiff_t(wrong.size()), [&](std::ptrdiff_t t) {
      for (std::size_t w = std::size_t(t); w < wall_.wedges.size(); w += wrong.size())
        if (is_wrong(wall_.wedges[w], least_shape)) wrong[std::size_t(t)] = 1;
    });
    return wrong;
  }

  [[nodiscard]] std::vector<char> crossings() const {
    std::vector<char> wrong(lumen_.triangles.size(), 0);
    for (const auto& pair : air_mesh::self_intersections({wall_.vertices, wall_.outer_triangles}))
      for (const int t : pair) wrong[std::size_t(t)] = 1;
    return wrong;
  }

  static std::vector<char> without_given_up(std::vector<char> wrong,
                                            const std::vector<int>& attempts) {
    for (std::size_t t = 0; t < wrong.size(); ++t)
      if (attempts[t] >= kAttemptsPlace) wrong[t] = 0;
    return wrong;
  }

  /// Vertices as many rings around others as those have less one.
  [[nodiscard]] std::vector<char> within_rings(std::vector<int> rings) const {
    const int most = *std::max_element(rings.begin(), rings.end());
    for (int ring = most; ring > 1; --ring)
      for (std::size_t v = 0; v < count_; ++v)
        if (rings[v] == ring)
          for (const int n : neighbors_[v])
            rings[std::size_t(n)] = std::max(rings[std::size_t(n)], ring - 1);
    std::vector<char> marked(count_);
    for (std::size_t v = 0; v < count_; ++v) marked[v] = rings[v] > 0 ? 1 : 0;
    return marked;
  }

  /// Every level's way gets the direction and length between its own and its neighbours' mean, and
  /// is shortened.
  void relax(const std::vector<char>& marked) {
    const std::vector<Vec3> before = wall_.vertices;
    const std::size_t levels = before.size() / count_;
    parallel_for(std::ptrdiff_t(count_), [&](std::ptrdiff_t index) {
      const auto v = std::size_t(index);
      if (!marked[v] || neighbors_[v].empty()) return;
      std::vector<Vec3> ways;
      for (std::size_t level = 1; level < levels; ++level) {
        const auto way = [&](std::size_t u) { return before[level * count_ + u] - before[u]; };
        Vec3 mean;
        double length = 0.0;
        for (const int n : neighbors_[v]) {
          mean += way(std::size_t(n));
          length += norm(way(std::size_t(n)));
        }
        const auto share = 1.0 / double(neighbors_[v].size());
        const Vec3 mix = normalized(way(v) + share * mean);
        ways.push_back(risen(0.5 * (norm(way(v)) + share * length) * mix, normals_[v], outward_[v],
                             kLeastRise));
      }
      const double length = norm(ways.back());
      const double scale =
          length > 0.0 ? std::max(kShrink, std::min(1.0, least_length_[v] / length)) : 1.0;
      for (std::size_t level = 1; level < levels; ++level)
        wall_.vertices[level * count_ + v] = before[v] + scale * ways[level - 1];
    });
  }

  WallLayers& wall_;
  const TriangleMesh& lumen_;
  std::vector<std::vector<int>> neighbors_;
  std::size_t count_;
  std::vector<std::vector<Vec3>> normals_;  ///< of the lumen's triangles at each vertex
  std::vector<Outward> outward_;
  double good_shape_, least_shape_;
  const std::vector<double>& least_length_;
};

}  // namespace

std::vector<char> untangle(WallLayers& wall, const TriangleMesh& lumen, double good_shape,
                           double least_shape, const std::vector<double>& least_length) {
  return Untangler(wall, lumen, good_shape, least_shape, least_length).run();
}

}  // namespace angio::meshing::detail
