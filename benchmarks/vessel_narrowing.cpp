#include "benchmarks/vessel_narrowing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/parallel.hpp"

namespace angio::benchmarks {
namespace {

double nearest(const std::vector<Vec3>& places, const Vec3& place) {
  double least = std::numeric_limits<double>::max();
  for (const Vec3& other : places) least = std::min(least, distance(other, place));
  return least;
}

struct Place {
  std::size_t path = 0, point = 0;
  double weight = 0.0;  ///< diameters of vessel that it stands for
};

bool is_blanked(const CenterlinePath& path, std::size_t point) {
  return std::any_of(path.tracts.begin(), path.tracts.end(), [&](const CenterlineTract& tract) {
    return tract.blanking && tract.first_point <= int(point) && int(point) <= tract.last_point;
  });
}

/// Whether the vessel is about as wide within a reach [diameters] of a point, all around or where
/// it is not a branching.
bool is_even(const CenterlinePath& path, std::size_t point, double reach, bool but_branchings) {
  constexpr double kUneven = 1.25;
  const std::vector<double>&s = path.abscissa, &radius = measured_radius(path);
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (std::abs(s[i] - s[point]) >= 2.0 * reach * radius[point]) continue;
    const double ratio = radius[i] / radius[point];
    if ((ratio > kUneven || ratio < 1.0 / kUneven) && !(but_branchings && is_blanked(path, i)))
      return false;
  }
  return true;
}

/// Distance from a point to the nearest branching [diameters].
double from_branching(const CenterlinePath& path, std::size_t point) {
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < path.points.size(); ++i)
    if (is_blanked(path, i))
      least = std::min(least, std::abs(path.abscissa[i] - path.abscissa[point]));
  return 0.5 * least / measured_radius(path)[point];
}

bool is_fit(const CenterlinePath& path, std::size_t point, Site site,
            const std::vector<Vec3>& taken) {
  constexpr double kLeast = 1.5;                                             // mm
  constexpr double kEven = 2.0, kBranch = 1.0, kEnd = 3.0, kBeside = 0.125;  // diameters
  const std::vector<double>&s = path.abscissa, &radius = measured_radius(path);
  const double diameter = 2.0 * radius[point];
  if (diameter < kLeast || std::min(s[point], s.back() - s[point]) < kEnd * diameter) return false;
  if (nearest(taken, path.points[point]) < kEnd * diameter) return false;
  const double away = from_branching(path, point);
  if (site == Site::even) return away >= kBranch && is_even(path, point, kEven, false);
  return kBeside <= away && away < kBranch && is_even(path, point, kBranch, true);
}

/// Each fit place once, though several lines run through it.
std::vector<Place> fit_places(const CenterlineTree& lines, Site site,
                              const std::vector<Vec3>& taken) {
  std::vector<Place> places;
  std::vector<Vec3> known;
  for (std::size_t p = 0; p < lines.paths.size(); ++p) {
    const CenterlinePath& path = lines.paths[p];
    for (std::size_t i = 1; i < path.points.size(); ++i) {
      const bool is_known = std::any_of(known.begin(), known.end(),
                                        [&](const Vec3& other) { return other == path.points[i]; });
      if (is_known) continue;
      known.push_back(path.points[i]);
      if (!is_fit(path, i, site, taken)) continue;
      const double step = path.abscissa[i] - path.abscissa[i - 1];
      places.push_back({p, i, 0.5 * step / measured_radius(path)[i]});
    }
  }
  return places;
}

/// The place of the lines that a vertex belongs to: the one whose ball it is nearest to.
struct Owner {
  const CenterlinePath* path = nullptr;
  std::size_t point = 0;
};

std::vector<Owner> owners(const TriangleMesh& surface, const CenterlineTree& lines) {
  std::vector<Owner> result(surface.vertices.size());
  parallel_for(std::ptrdiff_t(result.size()), [&](std::ptrdiff_t at) {
    const auto v = std::size_t(at);
    double least = std::numeric_limits<double>::max();
    for (const CenterlinePath& path : lines.paths)
      for (std::size_t i = 0; i < path.points.size(); ++i) {
        const double off = distance(surface.vertices[v], path.points[i]) - path.inscribed_radius[i];
        if (off >= least) continue;
        least = off;
        result[v] = {&path, i};
      }
  });
  return result;
}

/// Draws the sections around a place together, by 1 - percent cos^2; false, and the surface is as
/// it was, if a part of them is another line's or too few vertices are there to show a throat.
bool narrow(TriangleMesh& surface, const std::vector<Owner>& owner, const CenterlineTree& lines,
            const Place& place, const Narrowing& narrowing, double angle) {
  const CenterlinePath& path = lines.paths[place.path];
  const double middle = path.abscissa[place.point], half = 0.5 * narrowing.length_mm;
  const Vec3 tangent = sample(path, middle).tangent;
  const Vec3 across = any_perpendicular(tangent), other = cross(tangent, across);
  const Vec3 aside = std::cos(angle) * across + std::sin(angle) * other;
  constexpr double kTight = 0.75;  // of the depth: where the throat is,
  constexpr int kSeen = 24;        // and how many vertices show it
  int seen = 0;
  TriangleMesh narrowed = surface;
  for (std::size_t v = 0; v < narrowed.vertices.size(); ++v) {
    Vec3& vertex = narrowed.vertices[v];
    if (distance(vertex, path.points[place.point]) > half + 2.0 * narrowing.diameter_mm) continue;
    const double s = project(path, vertex);
    if (std::abs(s - middle) >= half) continue;
    const CenterlineSample on_line = sample(path, s);
    const double away = distance(vertex, on_line.point);
    if (away > 2.0 * on_line.inscribed_radius) continue;
    const auto& [owning, point] = owner[v];  // lines share their points from the inlet on
    if (point >= path.points.size() || !(owning->points[point] == path.points[point])) return false;
    const double c = std::cos(0.5 * std::numbers::pi * (s - middle) / half);
    const double depth = 0.01 * narrowing.percent * c * c;
    const Vec3 towards = on_line.point + narrowing.eccentricity * on_line.inscribed_radius * aside;
    vertex = vertex + depth * (towards - vertex);
    if (c * c > kTight) ++seen;
  }
  if (seen < kSeen) return false;
  surface = narrowed;
  return true;
}

struct Random {
  std::mt19937_64 engine;
  double uniform(double low, double high) {  // the same with any library
    return low + (high - low) * (double(engine() >> 11U) + 0.5) * 0x1p-53;
  }
};

}  // namespace

std::vector<Narrowing> narrow_vessels(TriangleMesh& surface, const CenterlineTree& lines,
                                      const std::vector<Vec3>& taken, Site site,
                                      std::mt19937_64 random) {
  Random draw{random};
  constexpr int kMost = 3, kTries = 30;
  constexpr double kApart = 8.0;   // diameters
  constexpr double kThroat = 0.5;  // mm: what a balloon crosses, and a scan might show
  const std::vector<Place> places = fit_places(lines, site, taken);
  if (places.empty()) return {};
  const std::vector<Owner> owner = owners(surface, lines);
  double whole = 0.0;
  for (const Place& place : places) whole += place.weight;
  std::vector<Narrowing> put;
  for (int n = 0; n < kTries && int(put.size()) < kMost; ++n) {
    double at = draw.uniform(0.0, whole);
    std::size_t k = 0;
    while (k + 1 < places.size() && (at -= places[k].weight) > 0.0) ++k;
    const CenterlinePath& path = lines.paths[places[k].path];
    Narrowing narrowing;
    narrowing.place = path.points[places[k].point];
    narrowing.diameter_mm = 2.0 * measured_radius(path)[places[k].point];
    narrowing.percent =
        draw.uniform(40.0, std::min(90.0, 100.0 * (1.0 - kThroat / narrowing.diameter_mm)));
    narrowing.length_mm = narrowing.diameter_mm *
                          (site == Site::even ? draw.uniform(2.0, 5.0) : draw.uniform(0.75, 2.0));
    narrowing.eccentricity = draw.uniform(0.0, 1.0);
    const double angle = draw.uniform(0.0, 2.0 * std::numbers::pi);
    const bool is_apart = std::all_of(put.begin(), put.end(), [&](const Narrowing& other) {
      return distance(other.place, narrowing.place) >
             kApart * std::max(other.diameter_mm, narrowing.diameter_mm);
    });
    if (is_apart && narrow(surface, owner, lines, places[k], narrowing, angle))
      put.push_back(narrowing);
  }
  return put;
}

}  // namespace angio::benchmarks
