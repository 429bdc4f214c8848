#include "testing/meshing/wall_measure.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

namespace angio::benchmarks {
namespace {

double in_degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// The triangles' places in unique_edges, by edge.
std::map<std::array<int, 2>, std::size_t> numbered(const std::vector<std::array<int, 2>>& edges) {
  std::map<std::array<int, 2>, std::size_t> index;
  for (std::size_t e = 0; e < edges.size(); ++e) index[edges[e]] = e;
  return index;
}

using Curve = std::vector<Vec3>;  // from the plane's origin; closed

std::vector<Curve> curves_in(const TriangleMesh& tube, const Vec3& origin, const Vec3& normal) {
  using Edge = std::array<int, 2>;
  struct Step {
    Edge to;
    Vec3 from;
  };
  std::map<Edge, Step> steps;
  for (const Triangle& t : tube.triangles) {
    std::optional<Edge> first, last;
    Vec3 from;
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3];
      const Vec3 p = tube.vertices[std::size_t(i)] - origin,
                 q = tube.vertices[std::size_t(j)] - origin;
      const double a = dot(normal, p), b = dot(normal, q);
      if ((a >= 0.0) == (b >= 0.0)) continue;
      (a < 0.0 ? first : last) = Edge{std::min(i, j), std::max(i, j)};
      if (a < 0.0) from = p + (a / (a - b)) * (q - p);
    }
    if (first && last) steps[*first] = {*last, from};
  }
  std::vector<Curve> curves;
  while (!steps.empty()) {
    const Edge begin = steps.begin()->first;
    Curve curve;
    Edge at = begin;
    for (auto step = steps.find(at); step != steps.end(); step = steps.find(at)) {
      curve.push_back(step->second.from);
      at = step->second.to;
      steps.erase(step);
    }
    if (at == begin) curves.push_back(std::move(curve));
  }
  return curves;
}

TubeSection measured(const Curve& curve, const Vec3& normal) {
  TubeSection section;
  double length = 0.0;
  Vec3 doubled;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec3& next = curve[(i + 1) % curve.size()];
    length += distance(curve[i], next);
    doubled += cross(curve[i], next);
  }
  section.area_mm2 = 0.5 * std::abs(dot(doubled, normal));
  section.roundness = 4.0 * std::numbers::pi * section.area_mm2 / (length * length);
  const Vec3 u = any_perpendicular(normal), v = cross(normal, u);
  section.narrowest_mm = std::numeric_limits<double>::infinity();
  for (int degree = 0; degree < 180; ++degree) {
    const double angle = degree * std::numbers::pi / 180.0;
    const Vec3 across = std::cos(angle) * u + std::sin(angle) * v;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& p : curve) {
      low = std::min(low, dot(p, across));
      high = std::max(high, dot(p, across));
    }
    section.narrowest_mm = std::min(section.narrowest_mm, high - low);
    section.widest_mm = std::max(section.widest_mm, high - low);
  }
  return section;
}

}  // namespace

std::vector<double> edge_bends(const TriangleMesh& mesh) {
  const auto edges = unique_edges(mesh);
  const auto index = numbered(edges);
  const auto neighbors = triangle_neighbors(mesh);
  std::vector<double> bends(edges.size(), 0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const int other = neighbors[t][c];
      if (other < int(t)) continue;
      const int a = mesh.triangles[t][c], b = mesh.triangles[t][(c + 1) % 3];
      const Vec3 n = area_vector_doubled(mesh, mesh.triangles[t]),
                 m = area_vector_doubled(mesh, mesh.triangles[std::size_t(other)]);
      const Vec3 edge = normalized(mesh.vertices[std::size_t(b)] - mesh.vertices[std::size_t(a)]);
      bends[index.at({std::min(a, b), std::max(a, b)})] =
          in_degrees(std::atan2(dot(cross(n, m), edge), dot(n, m)));
    }
  return bends;
}

std::vector<double> triangle_aspects(const TriangleMesh& mesh) {
  std::vector<double> aspects;
  for (const Triangle& t : mesh.triangles) {
    double longest = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      longest = std::max(longest, norm_squared(mesh.vertices[std::size_t(t[c])] -
                                               mesh.vertices[std::size_t(t[(c + 1) % 3])]));
    aspects.push_back(0.5 * std::numbers::sqrt3 * longest / norm(area_vector_doubled(mesh, t)));
  }
  return aspects;
}

Unevenness unevenness(const std::vector<TubePoint>& points) {
  constexpr double kReach = 0.5;  // [mm] along: a few rows of the coarsest meshes in use
  constexpr double kAngle = 0.25 * std::numbers::pi;
  constexpr int kLeastCount = 10;  // of vertices; a quadratic has six coefficients
  Unevenness sum;
  int count = 0;
  for (const TubePoint& at : points) {
    const Vec3 &own = at.point, &along = at.along;
    std::vector<Vec3> near;  // the ring of the tube
    Vec3 middle;
    for (const TubePoint& other : points) {
      if (dot(other.along, along) < std::cos(kAngle) ||
          std::abs(dot(other.point - own, along)) > kReach)
        continue;
      near.push_back(other.point);
      middle += other.point;
    }
    middle = middle / double(near.size());
    const auto across = [&](const Vec3& p) { return p - middle - dot(p - middle, along) * along; };
    const Vec3 radial = normalized(across(own)), aside = cross(along, radial);
    std::vector<std::array<double, 3>> places;  // angle, place along, distance from the middle
    for (const Vec3& p : near) {
      const Vec3 r = across(p);
      const double angle = std::atan2(dot(r, aside), dot(r, radial));
      if (std::abs(angle) < kAngle) places.push_back({angle, dot(p - own, along), norm(r)});
    }
    if (int(places.size()) < kLeastCount) continue;
    Eigen::MatrixXd terms(Eigen::Index(places.size()), 6);
    Eigen::VectorXd radius(Eigen::Index(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto [a, s, r] = places[i];
      terms.row(Eigen::Index(i)) << 1.0, a, s, a * a, a * s, s * s;
      radius(Eigen::Index(i)) = r;
    }
    const Eigen::VectorXd fit = terms.colPivHouseholderQr().solve(radius);
    const double off = norm(across(own)) - fit(0), share = 100.0 * off / fit(0);
    sum.mm += off * off;
    sum.percent += share * share;
    ++count;
  }
  if (count == 0) return {};
  return {std::sqrt(sum.mm / count), std::sqrt(sum.percent / count)};
}

TubeSection section_of(const TriangleMesh& tube, const Vec3& origin, const Vec3& normal) {
  double nearest = std::numeric_limits<double>::infinity();
  TubeSection section;
  for (const Curve& curve : curves_in(tube, origin, normal)) {
    Vec3 middle;
    for (const Vec3& p : curve) middle += p / double(curve.size());
    if (norm(middle) >= nearest) continue;
    nearest = norm(middle);
    section = measured(curve, normal);
  }
  return section;
}

}  // namespace angio::benchmarks
