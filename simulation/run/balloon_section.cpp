#include "simulation/run/balloon_section.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

// A curve that a plane cuts out of a closed surface.
struct Curve {
  Vec3 middle;
  double area = 0.0;
};

struct Piece {
  std::array<int, 2> edge_from, edge_to;  // of the mesh
  Vec3 from, to;
};

std::vector<Piece> pieces_in(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                             const Vec3& point, const Vec3& normal) {
  std::vector<Piece> pieces;
  for (const Triangle& t : triangles) {
    Piece piece;
    bool has_from = false, has_to = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3];
      const Vec3 p = x[std::size_t(i)] - point, q = x[std::size_t(j)] - point;
      const double a = dot(normal, p), b = dot(normal, q);
      if ((a >= 0.0) == (b >= 0.0)) continue;
      (a < 0.0 ? piece.from : piece.to) = p + (a / (a - b)) * (q - p);
      (a < 0.0 ? piece.edge_from : piece.edge_to) =
          std::array<int, 2>{std::min(i, j), std::max(i, j)};
      (a < 0.0 ? has_from : has_to) = true;
    }
    if (has_from && has_to) pieces.push_back(piece);
  }
  return pieces;
}

// Which curve each piece is of: the least piece of it.
std::vector<std::size_t> curves_of(const std::vector<Piece>& pieces) {
  std::map<std::array<int, 2>, std::size_t> begins;
  for (std::size_t i = 0; i < pieces.size(); ++i) begins[pieces[i].edge_from] = i;
  std::vector<std::size_t> curve(pieces.size(), pieces.size());
  for (std::size_t first = 0; first < pieces.size(); ++first)
    for (std::size_t i = first; curve[i] == pieces.size();) {
      curve[i] = first;
      const auto next = begins.find(pieces[i].edge_to);
      if (next == begins.end()) break;
      i = next->second;
    }
  return curve;
}

std::optional<Curve> nearest_curve(const std::vector<Triangle>& triangles,
                                   const std::vector<Vec3>& x, const Vec3& point,
                                   const Vec3& normal) {
  const std::vector<Piece> pieces = pieces_in(triangles, x, point, normal);
  const std::vector<std::size_t> curve = curves_of(pieces);
  std::vector<Vec3> sum(pieces.size()), doubled(pieces.size());
  std::vector<double> length(pieces.size(), 0.0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    const double step = distance(piece.from, piece.to);
    sum[curve[i]] += 0.5 * step * (piece.from + piece.to);
    length[curve[i]] += step;
    doubled[curve[i]] += cross(piece.from, piece.to);
  }
  std::optional<Curve> nearest;
  for (std::size_t c = 0; c < pieces.size(); ++c) {
    if (!(length[c] > 0.0)) continue;
    const Vec3 middle = sum[c] / length[c];  // from the point
    if (nearest && norm(middle) >= distance(nearest->middle, point)) continue;
    nearest = Curve{point + middle, 0.5 * std::abs(dot(doubled[c], normal))};
  }
  return nearest;
}

}  // namespace

double diameter_across(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x,
                       const Vec3& point, const Vec3& guess) {
  constexpr int kIterations = 8;
  constexpr double kStep = 0.5;    // between sections, in radii
  constexpr double kStill = 1e-6;  // turn of the axis
  Vec3 axis = guess;
  std::optional<Curve> at = nearest_curve(triangles, x, point, axis);
  if (!at) return 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const Vec3 step = kStep * std::sqrt(at->area / units::kPi) * axis;
    const auto before = nearest_curve(triangles, x, at->middle - step, axis);
    const auto behind = nearest_curve(triangles, x, at->middle + step, axis);
    if (!before || !behind || !(distance(before->middle, behind->middle) > 0.0)) break;
    const Vec3 next = normalized(behind->middle - before->middle);
    const auto section = nearest_curve(triangles, x, point, next);
    if (!section) break;
    const double turn = distance(next, axis);
    axis = next;
    at = section;
    if (turn < kStill) break;
  }
  return 2.0 * std::sqrt(at->area / units::kPi);
}

}  // namespace angio::simulation::detail
