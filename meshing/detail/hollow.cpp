#include "meshing/detail/hollow.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/parallel.hpp"

namespace angio::meshing::detail {
namespace {

Vec3 middle_of(const TriangleMesh& mesh, const Triangle& t) {
  return (mesh.vertices[std::size_t(t[0])] + mesh.vertices[std::size_t(t[1])] +
          mesh.vertices[std::size_t(t[2])]) /
         3.0;
}

/// Is a place closed around by a wall that is nearer than some distance?
bool is_closed_around(const ClosestPoint& wall, const Vec3& place, double near, int own) {
  constexpr int kLeast = 11;  // of 14
  int met = 0;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) {
        const int length = std::abs(i) + std::abs(j) + std::abs(k);
        if (length != 1 && length != 3) continue;
        met += wall.ahead(place, normalized(Vec3{double(i), double(j), double(k)}), own) <= near;
      }
  return met >= kLeast;
}

/// What most of the triangles around each one are.
std::vector<char> smoothed(const std::vector<char>& marks,
                           const std::vector<std::array<int, 3>>& neighbors,
                           const std::vector<double>& area) {
  constexpr int kRounds = 8;
  std::vector<double> share(marks.begin(), marks.end()), next(marks.size());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t t = 0; t < marks.size(); ++t) {
      double sum = area[t] * share[t], weight = area[t];
      for (const int n : neighbors[t]) {
        if (n < 0) continue;
        sum += area[std::size_t(n)] * share[std::size_t(n)];
        weight += area[std::size_t(n)];
      }
      next[t] = weight > 0.0 ? sum / weight : share[t];
    }
    std::swap(share, next);
  }
  std::vector<char> result(marks.size());
  for (std::size_t t = 0; t < marks.size(); ++t) result[t] = share[t] > 0.5;
  return result;
}

/// Turns the marks of pieces with less than a share of the area that is marked so; an unmarked one
/// only where marked ones border on it.
void turn_small_pieces(std::vector<char>& marks, char mark,
                       const std::vector<std::array<int, 3>>& neighbors,
                       const std::vector<double>& area, double least_share) {
  double whole = 0.0;
  for (std::size_t t = 0; t < marks.size(); ++t) whole += marks[t] == mark ? area[t] : 0.0;
  std::vector<char> seen(marks.size(), 0);
  for (std::size_t start = 0; start < marks.size(); ++start) {
    if (marks[start] != mark || seen[start] != 0) continue;
    std::vector<int> piece{int(start)};
    seen[start] = 1;
    double sum = 0.0;
    bool is_bordered = false;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      sum += area[std::size_t(piece[i])];
      for (const int n : neighbors[std::size_t(piece[i])]) {
        is_bordered = is_bordered || (n >= 0 && marks[std::size_t(n)] != mark);
        if (n >= 0 && marks[std::size_t(n)] == mark && seen[std::size_t(n)] == 0) {
          seen[std::size_t(n)] = 1;
          piece.push_back(n);
        }
      }
    }
    if ((mark == 1 || is_bordered) && sum < least_share * whole)
      for (const int t : piece) marks[std::size_t(t)] = char(1 - mark);
  }
}

}  // namespace

double touching_ball(const ClosestPoint& wall, const Vec3& at, const Vec3& inward, int triangle) {
  constexpr int kSteps = 30;
  constexpr double kRough = 0.5;  // cosine of the least angle between the two touches
  constexpr double kSame = 1e-6;
  double radius = 0.5 * wall.ahead(at, inward, triangle);  // the wall across bounds the ball
  if (!std::isfinite(radius)) return 0.0;
  for (int step = 0; step < kSteps; ++step) {
    const auto touch = wall.find(at + radius * inward);
    if (touch.distance >= radius * (1.0 - kSame)) break;
    const Vec3 to = at - touch.point;
    const double lean = -dot(to, inward);
    const double next = lean > 0.0 ? 0.5 * norm_squared(to) / lean : radius;
    const Vec3 centre = at + next * inward;
    if (next >= radius * (1.0 - kSame) ||
        dot(normalized(at - centre), normalized(touch.point - centre)) > kRough)
      break;
    radius = next;
  }
  return 2.0 * radius;
}

std::vector<char> face_a_hollow(const TriangleMesh& mesh, const std::vector<std::size_t>& samples) {
  constexpr double kNear = 3.0;  // times the width of the hollow
  const ClosestPoint wall(mesh);
  std::vector<char> result(samples.size(), 0);
  parallel_for_uneven(std::ptrdiff_t(samples.size()), [&](std::ptrdiff_t i) {
    const auto t = int(samples[std::size_t(i)]);
    const Triangle& corners = mesh.triangles[std::size_t(t)];
    const Vec3 outward = normalized(area_vector_doubled(mesh, corners));
    const Vec3 at = middle_of(mesh, corners);
    const double width = touching_ball(wall, at, outward, t);
    result[std::size_t(i)] =
        width > 0.0 && is_closed_around(wall, at + 0.5 * width * outward, kNear * width, t);
  });
  return result;
}

double hollow_share_of(const TriangleMesh& mesh, double area) {
  constexpr int kSamples = 400;
  const std::vector<char> hollow = face_a_hollow(mesh, samples_of(mesh, area, kSamples));
  return hollow.empty()
             ? 0.0
             : double(std::count(hollow.begin(), hollow.end(), char(1))) / double(hollow.size());
}

TriangleMesh hollow_of(const TriangleMesh& mesh) {
  constexpr double kLeastPiece = 0.05;
  std::vector<std::size_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), std::size_t(0));
  std::vector<double> area;
  for (const Triangle& t : mesh.triangles) area.push_back(0.5 * norm(area_vector_doubled(mesh, t)));
  const auto neighbors = triangle_neighbors(mesh);
  std::vector<char> is_hollow = smoothed(face_a_hollow(mesh, all), neighbors, area);
  turn_small_pieces(is_hollow, 1, neighbors, area, kLeastPiece);
  turn_small_pieces(is_hollow, 0, neighbors, area, kLeastPiece);  // holes in the inner skin
  TriangleMesh hollow;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_hollow[t] == 0) continue;
    Triangle turned = mesh.triangles[t];
    std::swap(turned[1], turned[2]);
    for (int& v : turned) {
      int& known = index[std::size_t(v)];
      if (known < 0) {
        known = int(hollow.vertices.size());
        hollow.vertices.push_back(mesh.vertices[std::size_t(v)]);
      }
      v = known;
    }
    hollow.triangles.push_back(turned);
  }
  return hollow;
}

}  // namespace angio::meshing::detail
