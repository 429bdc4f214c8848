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
  Untangler(WallLayers& wall, const TriangleMesh& lumen, double least_share)
      : wall_(wall),
        neighbors_(vertex_neighbors(lumen)),
        count_(lumen.vertices.size()),
        least_share_(least_share) {
    result_.moved.assign(count_, 0);
    normals_around_.resize(count_);
    for (const Triangle& t : lumen.triangles)
      for (const int v : t)
        normals_around_[std::size_t(v)].push_back(normalized(area_vector_doubled(lumen, t)));
  }

  Untangled run() {
    int checks = 0;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      std::vector<char> wrong = corners_of_wrong_wedges();
      if (std::find(wrong.begin(), wrong.end(), 1) == wrong.end()) {
        // Crossings are worth a search only where all wedges are right.
        wrong = corners_of_crossings();
        if (std::find(wrong.begin(), wrong.end(), 1) == wrong.end()) return result_;
        if (++checks == kCrossingChecks) break;
      }
      for (int ring = 0; ring <= attempt / kAttemptsPerRing; ++ring) wrong = widen(wrong);
      relax_around(wrong);
    }
    const auto wrong = corners_of_wrong_wedges();
    result_.left_count = int(std::count(wrong.begin(), wrong.end(), 1));
    if (result_.left_count == 0) {
      const auto crossing = corners_of_crossings();
      result_.left_count = int(std::count(crossing.begin(), crossing.end(), 1));
    }
    return result_;
  }

 private:
  [[nodiscard]] bool is_wrong(const std::array<int, 6>& wedge) const {
    const auto& x = wall_.vertices;
    const auto at = [&](std::size_t c) { return x[std::size_t(wedge[c])]; };
    const double area = norm(cross(at(1) - at(0), at(2) - at(0)));
    const double height =
        (distance(at(0), at(3)) + distance(at(1), at(4)) + distance(at(2), at(5))) / 3.0;
    return least_corner_determinant(x, wedge) <= least_share_ * area * height;
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
      result_.moved[v] = 1;
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
  double least_share_;
  Untangled result_;
};

}  // namespace

Untangled untangle(WallLayers& wall, const TriangleMesh& lumen, double least_share) {
  return Untangler(wall, lumen, least_share).run();
}

}  // namespace angio::meshing::detail
