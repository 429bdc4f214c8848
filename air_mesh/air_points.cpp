#include "air_mesh/air_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

namespace angio::air_mesh {
namespace {

constexpr double kLeastSeen = 1e-5;  // quality of a tet from a face to a point that sees it

struct Plane {
  Vec3 point, normal;
};

bool contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

bool sees(const std::vector<Vec3>& x, const Triangle& f, const Vec3& point) {
  const Vec3 &a = x[std::size_t(f[0])], &b = x[std::size_t(f[1])], &c = x[std::size_t(f[2])];
  return dot(cross(b - a, c - a), point - a) > 0.0 && tet_quality(a, b, c, point) > kLeastSeen;
}

// The point, moved along a face's normal until it is `height` times the face's size before it.
Vec3 in_front_of(const std::vector<Vec3>& x, const Triangle& f, const Vec3& point, double height) {
  const Vec3& a = x[std::size_t(f[0])];
  const Vec3 normal = cross(x[std::size_t(f[1])] - a, x[std::size_t(f[2])] - a);
  const double area = norm(normal);
  const Vec3 n = normal / area;
  return point + (height * std::sqrt(area) - dot(n, point - a)) * n;
}

}  // namespace

std::vector<int> star_of(const TetTopology& air, int tet, int vertex) {
  std::vector<int> star{tet};
  std::unordered_set<int> seen{tet};
  for (std::size_t i = 0; i < star.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      if (air.tet(star[i])[std::size_t(c)] == vertex) continue;
      const int next = air.across(star[i], c).tet;
      if (next >= 0 && seen.insert(next).second) star.push_back(next);
    }
  return star;
}

std::vector<Triangle> outside_of(const TetTopology& air, const std::vector<int>& tets) {
  std::vector<int> ordered = tets;
  std::sort(ordered.begin(), ordered.end());
  std::vector<Triangle> faces;
  for (const int t : tets)
    for (int c = 0; c < 4; ++c) {
      const int other = air.across(t, c).tet;
      if (other < 0 || !std::binary_search(ordered.begin(), ordered.end(), other))
        faces.push_back(air.face(t, c));
    }
  return faces;
}

InnerPoint find_inner_point(const std::vector<Triangle>& faces, const std::vector<Vec3>& x,
                            const Vec3& guess) {
  constexpr int kSteps = 60;
  std::vector<Plane> planes;
  for (const Triangle& f : faces) {
    const Vec3& a = x[std::size_t(f[0])];
    planes.push_back({a, normalized(cross(x[std::size_t(f[1])] - a, x[std::size_t(f[2])] - a))});
  }
  // The height over the nearest plane, and that plane.
  const auto nearest = [&](const Vec3& p) {
    double least = std::numeric_limits<double>::max();
    std::size_t which = 0;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const double height = dot(planes[i].normal, p - planes[i].point);
      if (height >= least) continue;
      least = height;
      which = i;
    }
    return std::pair{least, which};
  };
  double step = 0.0;
  for (const Plane& plane : planes) step = std::max(step, distance(plane.point, guess));
  step *= 0.25;
  Vec3 at = guess;
  InnerPoint best{guess, -std::numeric_limits<double>::max()};
  for (int i = 0; i < kSteps; ++i, step *= 0.9) {
    const auto [height, which] = nearest(at);
    if (height > best.height) best = {at, height};
    at = (i % 4 == 3 ? best.point : at) + step * planes[which].normal;
  }
  return best;
}

// false, and no tets, if the hollow would be too large; `unseen` if a boundary's face is not seen.
bool HollowSearch::grow(SeenHollow& hollow, int most, TetFace& unseen) {
  ++stamp_;
  hollow.tets = seeds_;
  for (const int t : seeds_) mark_[std::size_t(t)] = stamp_;
  // Faces to tets taken out later are seen to when their turn comes.
  for (std::size_t i = 0; i < hollow.tets.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      const int t = hollow.tets[i], other = air_.across(t, c).tet;
      if (other >= 0 && mark_[std::size_t(other)] == stamp_) continue;
      if (sees(x_, air_.face(t, c), hollow.point)) continue;
      if (other < 0) {
        unseen = {t, c};
        return true;
      }
      if (int(hollow.tets.size()) >= most) return false;
      mark_[std::size_t(other)] = stamp_;
      hollow.tets.push_back(other);
    }
  return true;
}

SeenHollow HollowSearch::find(const Vec3& point, int most) {
  constexpr int kAttempts = 6;
  constexpr double kStep = 0.01;
  SeenHollow hollow{{}, point};
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    TetFace unseen;
    if (!grow(hollow, most, unseen)) break;
    if (unseen.tet < 0) return hollow;
    hollow.point = in_front_of(x_, air_.face(unseen.tet, unseen.corner), hollow.point, kStep);
  }
  return {};
}

std::vector<Vec3> places_around(const TetTopology& air, const std::vector<Vec3>& x,
                                const std::vector<int>& tets) {
  constexpr int kLayers = 2;
  constexpr double kWeights[][3] = {{0.34, 0.33, 0.33}, {0.6, 0.2, 0.2},   {0.2, 0.6, 0.2},
                                    {0.2, 0.2, 0.6},    {0.1, 0.45, 0.45}, {0.45, 0.1, 0.45},
                                    {0.45, 0.45, 0.1}};
  constexpr double kHeights[] = {0.02, 0.005, 0.1};  // of the face's size
  std::vector<int> near = tets;
  for (int layer = 0; layer < kLayers; ++layer)
    for (std::size_t i = 0, count = near.size(); i < count; ++i)
      for (int c = 0; c < 4; ++c) {
        const int next = air.across(near[i], c).tet;
        if (next >= 0 && !contains(near, next)) near.push_back(next);
      }
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < near.size(); ++i) {
    Vec3 middle;
    for (const int v : air.tet(near[i])) middle += 0.25 * x[std::size_t(v)];
    places.push_back(middle);
    for (int c = 0; c < 4 && i < tets.size(); ++c) {
      const Triangle f = air.face(near[i], c);
      for (const double height : kHeights)
        for (const auto& w : kWeights) {
          Vec3 at;
          for (std::size_t k = 0; k < 3; ++k) at += w[k] * x[std::size_t(f[k])];
          places.push_back(in_front_of(x, f, at, height));
        }
    }
  }
  return places;
}

}  // namespace angio::air_mesh
