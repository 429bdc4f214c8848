#include "core/surface_section.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
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

std::pair<Vec3, Vec3> axes_across(const Vec3& normal) {
  const Vec3 aside = std::abs(normal.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 right = normalized(cross(normal, aside));
  return {right, cross(normal, right)};
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
                         {}};
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (curve[i] == nearest)
      section.pieces.push_back({point + pieces[i].from, point + pieces[i].to});
  return section;
}

double inscribed_radius(const SurfaceSection& section, const Vec3& from) {
  constexpr int kDirections = 8;
  constexpr double kFirstStep = 0.25, kLastStep = 1e-3;  // of the radius
  const auto nearest = [&](const Vec3& place) {
    double least = std::numeric_limits<double>::max();
    for (const auto& [a, b] : section.pieces) {
      const Vec3 along = b - a, to = place - a;
      const double length = dot(along, along);
      const double t = length > 0.0 ? std::clamp(dot(to, along) / length, 0.0, 1.0) : 0.0;
      least = std::min(least, distance(to, t * along));
    }
    return least;
  };
  if (section.pieces.empty()) return 0.0;
  const auto [right, up] = axes_across(section.normal);
  Vec3 center = from - dot(from - section.middle, section.normal) * section.normal;
  double radius = nearest(center);
  for (double share = kFirstStep; share > kLastStep;) {
    const double step = share * radius;
    Vec3 best = center;
    double widest = radius;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2.0 * units::kPi * k / kDirections;
      const Vec3 place = center + step * (std::cos(angle) * right + std::sin(angle) * up);
      if (const double there = nearest(place); there > widest) {
        widest = there;
        best = place;
      }
    }
    if (widest > radius) {
      radius = widest;
      center = best;
    } else {
      share *= 0.5;
    }
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
