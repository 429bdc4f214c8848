#include "core/surface_section.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <queue>
#include <set>
#include <utility>

#include "core/units.hpp"

namespace angio {
namespace {

struct Piece {
  std::array<int, 2> edge_from, edge_to;  // of the mesh
  Vec3 from, to;                          // from the point
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

using Flat = std::array<double, 2>;  // in the plane of a section

std::vector<std::array<Flat, 2>> flattened(const SurfaceSection& section, const Vec3& right,
                                           const Vec3& up) {
  std::vector<std::array<Flat, 2>> pieces;
  pieces.reserve(section.pieces.size());
  const auto flat = [&](const Vec3& p) {
    return Flat{dot(p - section.middle, right), dot(p - section.middle, up)};
  };
  for (const auto& [from, to] : section.pieces) pieces.push_back({flat(from), flat(to)});
  return pieces;
}

// How far inside a closed curve a place is: its distance to it, below zero outside.
double depth(const std::vector<std::array<Flat, 2>>& curve, const Flat& place) {
  double least = std::numeric_limits<double>::max();
  bool is_inside = false;
  for (const auto& [a, b] : curve) {
    const double ux = b[0] - a[0], uy = b[1] - a[1], vx = place[0] - a[0], vy = place[1] - a[1],
                 length = ux * ux + uy * uy,
                 t = length > 0.0 ? std::clamp((ux * vx + uy * vy) / length, 0.0, 1.0) : 0.0,
                 dx = vx - t * ux, dy = vy - t * uy;
    least = std::min(least, dx * dx + dy * dy);
    if ((a[1] > place[1]) != (b[1] > place[1]) && vx < ux * vy / uy) is_inside = !is_inside;
  }
  return is_inside ? std::sqrt(least) : -std::sqrt(least);
}

std::pair<Vec3, Vec3> axes_across(const Vec3& normal) {
  const Vec3 aside = std::abs(normal.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 right = normalized(cross(normal, aside));
  return {right, cross(normal, right)};
}

// Whether every piece of a curve begins where another one of it ends.
bool is_closed(const std::vector<Piece>& pieces, const std::vector<std::size_t>& curve,
               std::size_t which) {
  std::set<std::array<int, 2>> ends;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (curve[i] == which) ends.insert(pieces[i].edge_to);
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (curve[i] == which && !ends.contains(pieces[i].edge_from)) return false;
  return true;
}

}  // namespace

std::optional<SurfaceSection> nearest_section(const std::vector<Triangle>& triangles,
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
  std::size_t nearest = pieces.size();
  double away = std::numeric_limits<double>::max();
  for (std::size_t c = 0; c < pieces.size(); ++c)
    if (length[c] > 0.0 && norm(sum[c] / length[c]) < away) {
      nearest = c;
      away = norm(sum[c] / length[c]);
    }
  if (nearest == pieces.size()) return std::nullopt;
  SurfaceSection section{normal,
                         point + sum[nearest] / length[nearest],
                         0.5 * std::abs(dot(doubled[nearest], normal)),
                         is_closed(pieces, curve, nearest),
                         {}};
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (curve[i] == nearest)
      section.pieces.push_back({point + pieces[i].from, point + pieces[i].to});
  return section;
}

double inscribed_radius(const SurfaceSection& section) {
  constexpr double kAccuracy = 2e-3;  // of the radius of a circle of the section's area
  if (!section.is_closed || !(section.area > 0.0)) return 0.0;
  const auto [right, up] = axes_across(section.normal);
  const std::vector<std::array<Flat, 2>> curve = flattened(section, right, up);
  Flat low{1e300, 1e300}, high{-1e300, -1e300};
  for (const auto& [a, b] : curve)
    for (std::size_t k = 0; k < 2; ++k) {
      low[k] = std::min({low[k], a[k], b[k]});
      high[k] = std::max({high[k], a[k], b[k]});
    }
  // The best square first: none of its points is deeper than its middle by more than half a
  // diagonal.
  struct Square {
    double most, x, y, half;
    bool operator<(const Square& other) const { return most < other.most; }
  };
  std::priority_queue<Square> squares;
  double radius = 0.0;
  const auto add = [&](double x, double y, double half) {
    const double here = depth(curve, {x, y});
    radius = std::max(radius, here);
    squares.push({here + std::numbers::sqrt2 * half, x, y, half});
  };
  const double half = 0.5 * std::max(high[0] - low[0], high[1] - low[1]);
  add(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), half);
  const double accuracy = kAccuracy * std::sqrt(section.area / units::kPi);
  while (!squares.empty() && squares.top().most > radius + accuracy) {
    const Square square = squares.top();
    squares.pop();
    const double h = 0.5 * square.half;
    for (const double dx : {-h, h})
      for (const double dy : {-h, h}) add(square.x + dx, square.y + dy, h);
  }
  return radius;
}

std::optional<SectionWidths> section_widths(const SurfaceSection& section) {
  constexpr int kDirections = 90;
  Vec3 centroid;
  double doubled = 0.0;
  for (const auto& [from, to] : section.pieces) {
    const Vec3 p = from - section.middle, q = to - section.middle;
    const double part = dot(section.normal, cross(p, q));
    centroid += (part / 3.0) * (p + q);
    doubled += part;
  }
  if (doubled == 0.0) return std::nullopt;
  centroid = section.middle + centroid / doubled;
  const auto [right, up] = axes_across(section.normal);
  // How far the curve is from the centroid in a direction; negative: it is not there.
  const auto reach = [&](const Vec3& direction) {
    const Vec3 across = cross(section.normal, direction);
    double farthest = -1.0;
    for (const auto& [from, to] : section.pieces) {
      const Vec3 p = from - centroid, q = to - centroid;
      const double a = dot(across, p), b = dot(across, q);
      if ((a >= 0.0) == (b >= 0.0)) continue;
      farthest = std::max(farthest, dot(direction, p + (a / (a - b)) * (q - p)));
    }
    return farthest;
  };
  SectionWidths widths{std::numeric_limits<double>::max(), 0.0};
  for (int k = 0; k < kDirections; ++k) {
    const double angle = units::kPi * k / kDirections;
    const Vec3 direction = std::cos(angle) * right + std::sin(angle) * up;
    const double ahead = reach(direction), behind = reach(-1.0 * direction);
    if (ahead < 0.0 || behind < 0.0) return std::nullopt;
    widths.least = std::min(widths.least, ahead + behind);
    widths.greatest = std::max(widths.greatest, ahead + behind);
  }
  return widths;
}

}  // namespace angio
