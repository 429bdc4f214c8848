#include "air_mesh/build/distances_ahead.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/parallel.hpp"

namespace angio::air_mesh {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// The distance along a unit direction to a triangle, after Moeller and Trumbore (1997).
double distance_to(const Vec3& from, const Vec3& direction, const Vec3& a, const Vec3& b,
                   const Vec3& c) {
  constexpr double kRim = 1e-9;  // a ray through an edge meets one of its triangles at least
  const Vec3 ab = b - a, ac = c - a, to = from - a;
  const Vec3 p = cross(direction, ac), q = cross(to, ab);
  const double determinant = dot(ab, p);
  if (determinant == 0.0) return kNone;
  const double u = dot(to, p) / determinant, v = dot(direction, q) / determinant;
  if (u < -kRim || v < -kRim || u + v > 1.0 + kRim) return kNone;
  const double ahead = dot(ac, q) / determinant;
  return ahead > 0.0 ? ahead : kNone;
}

/// Triangles in the order of their least x, to be looked through from a place on.
class Sweep {
 public:
  explicit Sweep(const TriangleMesh& surface) : order_(surface.triangles.size()) {
    std::vector<double> low;
    for (const Triangle& t : surface.triangles) {
      const auto x = [&](int v) { return surface.vertices[std::size_t(v)].x; };
      low.push_back(std::min({x(t[0]), x(t[1]), x(t[2])}));
      widest_ = std::max(widest_, std::max({x(t[0]), x(t[1]), x(t[2])}) - low.back());
    }
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](int a, int b) { return low[std::size_t(a)] < low[std::size_t(b)]; });
    for (const int t : order_) low_.push_back(low[std::size_t(t)]);
  }

  template <class Visit>
  void between(double first, double last, const Visit& visit) const {
    auto i =
        std::size_t(std::lower_bound(low_.begin(), low_.end(), first - widest_) - low_.begin());
    for (; i < low_.size() && low_[i] <= last; ++i) visit(order_[i]);
  }

 private:
  std::vector<int> order_;
  std::vector<double> low_;
  double widest_ = 0.0;
};

}  // namespace

std::vector<double> distances_ahead(const TriangleMesh& surface,
                                    const std::vector<Vec3>& directions,
                                    const std::vector<double>& reach, Side side) {
  const Sweep sweep(surface);
  const double facing = side == Side::outside ? -1.0 : 1.0;
  std::vector<double> ahead(surface.vertices.size(), kNone);
  parallel_for_uneven(std::ptrdiff_t(ahead.size()), [&](std::ptrdiff_t index) {
    const auto v = std::size_t(index);
    const Vec3 from = surface.vertices[v], to = from + reach[v] * directions[v];
    sweep.between(std::min(from.x, to.x), std::max(from.x, to.x), [&](int t) {
      const Triangle& corner = surface.triangles[std::size_t(t)];
      if (std::find(corner.begin(), corner.end(), int(v)) != corner.end()) return;
      if (facing * dot(area_vector_doubled(surface, corner), directions[v]) <= 0.0) return;
      const auto at = [&](std::size_t c) { return surface.vertices[std::size_t(corner[c])]; };
      const double found = distance_to(from, directions[v], at(0), at(1), at(2));
      if (found <= reach[v]) ahead[v] = std::min(ahead[v], found);
    });
  });
  return ahead;
}

}  // namespace angio::air_mesh
