#include "datasets/detail/cut_ends.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace angio::datasets::detail {
namespace {

constexpr double kSnapOverEdge = 0.3;  ///< nearer vertices are drawn onto the rim
constexpr int kDrawSteps = 12;

enum class Side : signed char { kept = -1, rim = 0, dropped = 1 };

/// The nearest point of the rim, by turns onto the wall and onto the end's plane.
Vec3 draw_onto_rim(const LumenShape& shape, const FlatEnd& end, Vec3 x) {
  for (int i = 0; i < kDrawSteps; ++i) {
    const NearestWall wall = shape.nearest_wall(x, LumenShape::Ends::continued);
    x -= wall.distance * wall.normal;
    x -= dot(x - end.point, end.outward) * end.outward;
  }
  return x;
}

class EndCutter {
 public:
  EndCutter(const LumenShape& shape, const FlatEnd& end, TriangleMesh& mesh)
      : shape_(shape), end_(end), mesh_(mesh) {}

  void cut() {
    choose_sides();
    std::vector<Triangle> kept;
    for (const Triangle& triangle : mesh_.triangles) cut_triangle(triangle, kept);
    mesh_.triangles = std::move(kept);
  }

 private:
  [[nodiscard]] Side side(int v) const { return sides_[std::size_t(v)]; }
  [[nodiscard]] double height(int v) const {
    return dot(mesh_.vertices[std::size_t(v)] - end_.point, end_.outward);
  }

  void choose_sides() {
    std::vector<double> shortest_edge(mesh_.vertices.size(), end_.radius);
    for (const Triangle& t : mesh_.triangles)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t a = std::size_t(t[c]), b = std::size_t(t[(c + 1) % 3]);
        const double length = distance(mesh_.vertices[a], mesh_.vertices[b]);
        shortest_edge[a] = std::min(shortest_edge[a], length);
        shortest_edge[b] = std::min(shortest_edge[b], length);
      }
    sides_.assign(mesh_.vertices.size(), Side::kept);
    for (std::size_t v = 0; v < sides_.size(); ++v) {
      if (distance(mesh_.vertices[v], end_.point) > end_.reach) continue;
      const double h = height(int(v));
      if (std::abs(h) < kSnapOverEdge * shortest_edge[v]) {
        sides_[v] = Side::rim;
        mesh_.vertices[v] = draw_onto_rim(shape_, end_, mesh_.vertices[v]);
      } else if (h > 0.0) {
        sides_[v] = Side::dropped;
      }
    }
  }

  /// The vertex where an edge passes the end's plane.
  int rim_vertex(int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [place, is_new] = rim_of_edge_.emplace(std::pair{a, b}, int(mesh_.vertices.size()));
    if (is_new) {
      const double t = height(a) / (height(a) - height(b));
      const Vec3 from = mesh_.vertices[std::size_t(a)], to = mesh_.vertices[std::size_t(b)];
      mesh_.vertices.push_back(draw_onto_rim(shape_, end_, from + t * (to - from)));
      sides_.push_back(Side::rim);
    }
    return place->second;
  }

  /// The kept part of a triangle is a polygon of three or four corners.
  void cut_triangle(const Triangle& triangle, std::vector<Triangle>& kept) {
    const auto has = [&](Side wanted) {
      return std::any_of(triangle.begin(), triangle.end(),
                         [&](int v) { return side(v) == wanted; });
    };
    if (!has(Side::kept)) return;
    if (!has(Side::dropped)) {
      kept.push_back(triangle);
      return;
    }
    std::vector<int> polygon;
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = triangle[c], b = triangle[(c + 1) % 3];
      if (side(a) != Side::dropped) polygon.push_back(a);
      const bool passes = (side(a) == Side::kept && side(b) == Side::dropped) ||
                          (side(a) == Side::dropped && side(b) == Side::kept);
      if (passes) polygon.push_back(rim_vertex(a, b));
    }
    if (polygon.size() == 3) {
      kept.push_back({polygon[0], polygon[1], polygon[2]});
      return;
    }
    const auto diagonal = [&](std::size_t i, std::size_t j) {
      return distance(mesh_.vertices[std::size_t(polygon[i])],
                      mesh_.vertices[std::size_t(polygon[j])]);
    };
    const std::size_t first = diagonal(0, 2) <= diagonal(1, 3) ? 0 : 1;
    kept.push_back({polygon[first], polygon[first + 1], polygon[first + 2]});
    kept.push_back({polygon[first], polygon[first + 2], polygon[(first + 3) % 4]});
  }

  const LumenShape& shape_;
  const FlatEnd& end_;
  TriangleMesh& mesh_;
  std::vector<Side> sides_;
  std::map<std::pair<int, int>, int> rim_of_edge_;
};

/// Closes every rim by a fan around the middle of its end.
void cap(const std::vector<FlatEnd>& ends, TriangleMesh& mesh) {
  for (const std::vector<int>& rim : boundary_loops(mesh)) {
    Vec3 middle;
    for (int v : rim) middle += mesh.vertices[std::size_t(v)] / double(rim.size());
    const auto nearest =
        std::min_element(ends.begin(), ends.end(), [&](const FlatEnd& a, const FlatEnd& b) {
          return distance(a.point, middle) < distance(b.point, middle);
        });
    const int hub = int(mesh.vertices.size());
    mesh.vertices.push_back(nearest->point);
    for (std::size_t i = 0; i < rim.size(); ++i)
      mesh.triangles.push_back({hub, rim[i], rim[(i + 1) % rim.size()]});
  }
}

TriangleMesh without_loose_vertices(const TriangleMesh& mesh) {
  TriangleMesh compact;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (Triangle triangle : mesh.triangles) {
    for (int& v : triangle) {
      int& new_v = index[std::size_t(v)];
      if (new_v < 0) {
        new_v = int(compact.vertices.size());
        compact.vertices.push_back(mesh.vertices[std::size_t(v)]);
      }
      v = new_v;
    }
    compact.triangles.push_back(triangle);
  }
  return compact;
}

}  // namespace

TriangleMesh cut_ends(const LumenShape& shape, TriangleMesh surface) {
  const std::vector<FlatEnd> ends = shape.flat_ends();
  for (const FlatEnd& end : ends) EndCutter(shape, end, surface).cut();
  cap(ends, surface);
  return without_loose_vertices(surface);
}

}  // namespace angio::datasets::detail
