#include "meshing/detail/widening.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace angio::meshing::detail {
namespace {

// From the line, in radii of the lumen there: what lies further off is another vessel's. The wall
// of a lumen whose line is well in the middle is at 1, that of an oval of 1:2 at 2.
constexpr double kReachBeside = 2.0;
constexpr double kLeastShare = 0.4;    // that lengths count: triangles keep their angles
constexpr double kTangentReach = 0.5;  // radii over which a line's direction is taken

/// The points of a path on a stretch.
CenterlinePath part_of(const CenterlinePath& path, const WidenedStretch& stretch) {
  CenterlinePath part;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (path.abscissa[i] < stretch.proximal_mm || path.abscissa[i] > stretch.distal_mm) continue;
    part.points.push_back(path.points[i]);
    part.abscissa.push_back(path.abscissa[i]);
    part.inscribed_radius.push_back(path.inscribed_radius[i]);
    part.equivalent_radius.push_back(path.equivalent_radius[i]);
  }
  return part;
}

}  // namespace

Widening::Widening(const CenterlineTree& tree, const std::vector<WidenedStretch>& stretches) {
  for (const WidenedStretch& stretch : stretches)
    for (const CenterlinePath& path : tree.paths) {
      if (path.id != stretch.path_id) continue;
      Line line{part_of(path, stretch), 0.5 * stretch.diameter_mm};
      if (line.path.points.size() > 1) lines_.push_back(std::move(line));
    }
}

Vec3 Widening::at(const Vec3& point) const {
  Vec3 most;
  for (const auto& [path, radius] : lines_) {
    const double abscissa = project(path, point);
    if (abscissa <= path.abscissa.front() || abscissa >= path.abscissa.back()) continue;
    const CenterlineSample place = sample(path, abscissa);
    const double own = place.inscribed_radius;
    if (!(own < radius) || distance(point, place.point) > kReachBeside * own) continue;
    const double reach = kTangentReach * own;
    const Vec3 along =
        normalized(sample(path, abscissa + reach).point - sample(path, abscissa - reach).point);
    const Vec3 w = std::sqrt(1.0 - std::max(std::sqrt(own / radius), kLeastShare)) * along;
    if (norm_squared(w) > norm_squared(most)) most = w;
  }
  return most;
}

std::vector<Vec3> Widening::at(const std::vector<Vec3>& points) const {
  std::vector<Vec3> result(points.size());
  if (is_none()) return result;
  parallel_for(std::ptrdiff_t(points.size()),
               [&](std::ptrdiff_t i) { result[std::size_t(i)] = at(points[std::size_t(i)]); });
  return result;
}

}  // namespace angio::meshing::detail
