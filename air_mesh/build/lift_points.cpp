#include "air_mesh/build/lift_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "air_mesh/build/tet_shape.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {
namespace {

Triangle turned_to_least(const Triangle& t) {
  const auto least = std::min_element(t.begin(), t.end()) - t.begin();
  Triangle result = t;
  std::rotate(result.begin(), result.begin() + least, result.end());
  return result;
}

// The faces of one tet only, turning so that they make a right-handed tet with a point inside.
std::vector<Triangle> outer_faces(const std::vector<Tet>& tets) {
  std::map<Triangle, int> seen;  // once each way round: inner
  for (const Tet& t : tets)
    for (const auto& f : kTetFaces) {
      const Triangle face{t[std::size_t(f[0])], t[std::size_t(f[2])], t[std::size_t(f[1])]};
      const auto other = seen.find(turned_to_least({face[0], face[2], face[1]}));
      if (other == seen.end())
        ++seen[turned_to_least(face)];
      else
        seen.erase(other);
    }
  std::vector<Triangle> faces;
  for (const auto& entry : seen) faces.push_back(entry.first);
  return faces;
}

bool has(const Triangle& t, int v) { return t[0] == v || t[1] == v || t[2] == v; }

class Lift {
 public:
  Lift(TetMesh& mesh, int point, const std::vector<Triangle>& outer)
      : mesh_(mesh), point_(point), at_(mesh.vertices[std::size_t(point)]) {
    for (const Triangle& t : outer)
      if (has(t, point)) fan_.push_back(t);
  }

  // The surface's triangles without the point; none if the surface around it cannot be read.
  std::vector<Triangle> flat_triangles() {
    std::vector<Triangle> triangles;
    if (!chain_link()) return triangles;
    for (const std::vector<int>& polygon : flat_parts()) {
      const std::vector<Triangle> part = fan_over(polygon);
      if (part.empty()) return {};
      triangles.insert(triangles.end(), part.begin(), part.end());
    }
    return triangles;
  }

  // Moves the point to where the worst of its tets is best, and adds the tets under it.
  bool apply(const std::vector<Triangle>& triangles) {
    Vec3 normal;
    for (const Triangle& t : triangles) normal += normalized(area_vector(t));
    std::vector<Tet> star, fresh;
    for (const Tet& t : mesh_.tets)
      if (std::find(t.begin(), t.end(), point_) != t.end()) star.push_back(t);
    for (const Triangle& t : triangles) star.push_back({t[0], t[1], t[2], point_});
    constexpr int kHalvings = 40;
    double height = 0.0;
    for (const int v : link_) height = std::max(height, norm(x(v) - at_));
    Vec3 best_place = at_;
    double best = 0.0;
    for (int i = 0; i < kHalvings; ++i, height *= 0.5) {
      mesh_.vertices[std::size_t(point_)] = at_ + height * normalized(normal);
      const double worst = worst_shape(star);
      if (worst <= best) continue;
      best = worst;
      best_place = mesh_.vertices[std::size_t(point_)];
    }
    mesh_.vertices[std::size_t(point_)] = best_place;
    for (const Triangle& t : triangles) mesh_.tets.push_back({t[0], t[1], t[2], point_});
    return best > 0.0;
  }

 private:
  [[nodiscard]] const Vec3& x(int v) const { return mesh_.vertices[std::size_t(v)]; }
  [[nodiscard]] Vec3 area_vector(const Triangle& t) const {
    return cross(x(t[1]) - x(t[0]), x(t[2]) - x(t[0]));
  }

  // The vertices around the point, in the order of its triangles.
  bool chain_link() {
    std::map<int, int> next;
    for (const Triangle& t : fan_) {
      const auto k = std::size_t(std::find(t.begin(), t.end(), point_) - t.begin());
      if (!next.emplace(t[(k + 1) % 3], t[(k + 2) % 3]).second) return false;
    }
    link_.clear();
    int v = next.begin()->first;
    for (std::size_t i = 0; i < next.size(); ++i) {
      link_.push_back(v);
      const auto step = next.find(v);
      if (step == next.end()) return false;
      v = step->second;
    }
    return v == link_.front() && link_.size() >= 3;
  }

  // The link in one part around a point of a triangle, in two around a point of an edge.
  [[nodiscard]] std::vector<std::vector<int>> flat_parts() const {
    constexpr double kStraight = 1e-8;  // sine of the edge's bend at the point: rounding
    const std::size_t n = link_.size();
    double least = kStraight;
    std::size_t first = n, last = n;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 2; j < n; ++j) {
        const Vec3 a = x(link_[i]) - at_, b = x(link_[j]) - at_;
        const double bend = norm(cross(a, b)) / (norm(a) * norm(b));
        if (dot(a, b) >= 0.0 || bend >= least) continue;
        least = bend;
        first = i;
        last = j;
      }
    if (first == n) return {link_};
    std::vector<std::vector<int>> parts(2);
    for (std::size_t i = first; i <= last; ++i) parts[0].push_back(link_[i]);
    for (std::size_t i = last; i <= first + n; ++i) parts[1].push_back(link_[i % n]);
    return parts;
  }

  // A flat polygon's triangles around that corner which makes the least of them largest.
  [[nodiscard]] std::vector<Triangle> fan_over(const std::vector<int>& polygon) const {
    const std::size_t n = polygon.size();
    Vec3 up;
    for (std::size_t i = 0; i < n; ++i)
      up += cross(x(polygon[i]) - at_, x(polygon[(i + 1) % n]) - at_);
    std::vector<Triangle> best;
    double best_area = 0.0;
    for (std::size_t apex = 0; apex < n; ++apex) {
      std::vector<Triangle> triangles;
      double least = std::numeric_limits<double>::max();
      for (std::size_t k = 1; k + 1 < n; ++k) {
        triangles.push_back({polygon[apex], polygon[(apex + k) % n], polygon[(apex + k + 1) % n]});
        least = std::min(least, dot(area_vector(triangles.back()), up));
      }
      if (least <= best_area) continue;
      best_area = least;
      best = triangles;
    }
    return best;
  }

  [[nodiscard]] double worst_shape(const std::vector<Tet>& tets) const {
    double worst = 1.0;
    for (const Tet& t : tets)
      worst = std::min(worst, least_dihedral_sine(x(t[0]), x(t[1]), x(t[2]), x(t[3])));
    return worst;
  }

  TetMesh& mesh_;
  int point_;
  Vec3 at_;
  std::vector<Triangle> fan_;
  std::vector<int> link_;
};

}  // namespace

bool lift_off_surfaces(TetMesh& mesh, int surface_count) {
  std::vector<Triangle> outer = outer_faces(mesh.tets);
  for (int point = surface_count; point < int(mesh.vertices.size()); ++point) {
    const auto around = [&](const Triangle& t) { return has(t, point); };
    if (std::none_of(outer.begin(), outer.end(), around)) continue;
    Lift lift(mesh, point, outer);
    const std::vector<Triangle> triangles = lift.flat_triangles();
    if (triangles.empty() || !lift.apply(triangles)) return false;
    std::erase_if(outer, around);
    outer.insert(outer.end(), triangles.begin(), triangles.end());
  }
  return true;
}

}  // namespace angio::air_mesh
