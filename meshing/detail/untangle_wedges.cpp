#include "meshing/detail/untangle_wedges.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {
namespace {

constexpr int kAttempts = 200;
constexpr int kCrossingChecks = 40;
constexpr int kAttemptsPerRing = 20;  // then the neighbourhood that is relaxed grows by a ring
constexpr double kShrink = 0.98;      // a step
constexpr double kLeastRise = 0.2;    // sine of the angle between a way and the triangles it leaves

class Untangler {
 public:
  Untangler(WallLayers& wall, const TriangleMesh& lumen, double least_shape)
      : wall_(wall),
        neighbors_(vertex_neighbors(lumen)),
        count_(lumen.vertices.size()),
        least_shape_(least_shape) {
    normals_around_.resize(count_);
    for (const Triangle& t : lumen.triangles)
      for (const int v : t)
        normals_around_[std::size_t(v)].push_back(normalized(area_vector_doubled(lumen, t)));
  }

  int run() {
    int checks = 0;
    std::vector<char> wrong;
    for (int attempt = 0; attempt < kAttempts && checks < kCrossingChecks; ++attempt) {
      wrong = corners_of_wrong_wedges();
      if (!any(wrong)) {  // crossings are worth a search only where all wedges are right
        wrong = corners_of_crossings();
        if (!any(wrong)) return 0;
        ++checks;
      }
      for (int ring = 0; ring <= attempt / kAttemptsPerRing; ++ring) wrong = widen(wrong);
      relax_around(wrong);
    }
    wrong = corners_of_wrong_wedges();
    if (!any(wrong)) wrong = corners_of_crossings();
    return int(std::count(wrong.begin(), wrong.end(), 1));
  }

 private:
  static bool any(const std::vector<char>& marked) {
    return std::find(marked.begin(), marked.end(), 1) != marked.end();
  }

  /// By the sharpest of its six corners: the determinant over the product of the three edges.
  [[nodiscard]] bool is_wrong(const std::array<int, 6>& wedge) const {
    const auto at = [&](std::size_t c) { return wall_.vertices[std::size_t(wedge[c])]; };
    for (std::size_t side = 0; side < 6; side += 3)
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 next = at(side + (c + 1) % 3) - at(side + c);
        const Vec3 last = at(side + (c + 2) % 3) - at(side + c);
        const Vec3 up = at(3 + c) - at(c);
        if (dot(cross(next, last), up) <= least_shape_ * norm(next) * norm(last) * norm(up))
          return true;
      }
    return false;
  }

  [[nodiscard]] std::vector<char> corners_of_wrong_wedges() const {
    std::vector<char> is_bad(wall_.wedges.size(), 0);
    parallel_for(std::ptrdiff_t(is_bad.size()), [&](std::ptrdiff_t w) {
      is_bad[std::size_t(w)] = is_wrong(wall_.wedges[std::size_t(w)]) ? 1 : 0;
    });
    std::vector<char> wrong(count_, 0);
    for (std::size_t w = 0; w < is_bad.size(); ++w)
      if (is_bad[w])
        for (const int v : wall_.wedges[w]) wrong[std::size_t(v) % count_] = 1;
    return wrong;
  }

  [[nodiscard]] std::vector<char> corners_of_crossings() const {
    std::vector<char> wrong(count_, 0);
    const TriangleMesh outside{wall_.vertices, wall_.outer_triangles};
    for (const auto& pair : self_intersections(outside))
      for (const int t : pair)
        for (const int v : wall_.outer_triangles[std::size_t(t)])
          wrong[std::size_t(v) % count_] = 1;
    return wrong;
  }

  [[nodiscard]] std::vector<char> widen(const std::vector<char>& marked) const {
    std::vector<char> wide = marked;
    for (std::size_t v = 0; v < count_; ++v)
      if (marked[v])
        for (const int n : neighbors_[v]) wide[std::size_t(n)] = 1;
    return wide;
  }

  /// Every level's way from the lumen becomes half the mean of its neighbours'.
  void relax_around(const std::vector<char>& marked) {
    const std::vector<Vec3> before = wall_.vertices;
    const std::size_t levels = before.size() / count_;
    for (std::size_t v = 0; v < count_; ++v) {
      if (!marked[v] || neighbors_[v].empty()) continue;
      for (std::size_t level = 1; level < levels; ++level) {
        const auto way = [&](std::size_t u) { return before[level * count_ + u] - before[u]; };
        Vec3 mean;
        for (const int n : neighbors_[v]) mean += way(std::size_t(n));
        mean = mean / double(neighbors_[v].size());
        const Vec3 relaxed = (0.5 * kShrink) * (way(v) + mean);
        wall_.vertices[level * count_ + v] = before[v] + turned_away(v, relaxed);
      }
    }
  }

  /// A way that leaves every triangle around its vertex, as nearly as it can be.
  [[nodiscard]] Vec3 turned_away(std::size_t v, Vec3 way) const {
    for (const Vec3& normal : normals_around_[v]) {
      const double lack = kLeastRise * norm(way) - dot(normal, way);
      if (lack > 0.0) way += lack * normal;
    }
    return way;
  }

  WallLayers& wall_;
  std::vector<std::vector<int>> neighbors_;
  std::size_t count_;
  std::vector<std::vector<Vec3>> normals_around_;  ///< of the lumen's triangles at each vertex
  double least_shape_;
};

}  // namespace

int untangle(WallLayers& wall, const TriangleMesh& lumen, double least_shape) {
  return Untangler(wall, lumen, least_shape).run();
}

}  // namespace angio::meshing::detail
