#include "meshing/narrow_lumen.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/require.hpp"
#include "core/units.hpp"

namespace angio::meshing {
namespace {

constexpr double kLeastUsualDiameter = 2.25,
                 kMostUsualDiameter = 5.0;  // [mm] of the usual balloons
constexpr double kLengthInDiameters = 3.0;
constexpr double kOwnWall = 1.6, kOtherWall = 3.0;  // [radii] from the line

double smoothstep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// A stretch of a line that one branch owns.
struct Stretch {
  const CenterlinePath* path = nullptr;
  double first = 0.0, last = 0.0;  ///< abscissas [mm]
  double diameter = 0.0;           ///< in its middle

  [[nodiscard]] double middle() const { return 0.5 * (first + last); }
  [[nodiscard]] double length() const { return last - first; }
  [[nodiscard]] bool is_suitable() const {
    return diameter >= kLeastUsualDiameter && diameter <= kMostUsualDiameter &&
           length() >= (kLengthInDiameters + 2.0) * diameter;
  }
};

std::vector<Stretch> stretches(const CenterlineTree& tree, int path_id) {
  std::vector<Stretch> list;
  for (const CenterlinePath& path : tree.paths) {
    if (path_id >= 0 && path.id != path_id) continue;
    for (const CenterlineTract& tract : path.tracts) {
      if (tract.blanking) continue;
      Stretch stretch{&path, path.abscissa[std::size_t(tract.first_point)],
                      path.abscissa[std::size_t(tract.last_point)], 0.0};
      stretch.diameter = 2.0 * sample(path, stretch.middle()).inscribed_radius;
      list.push_back(stretch);
    }
  }
  return list;
}

std::string known_lines(const CenterlineTree& tree) {
  return std::to_string(tree.paths.size()) + " lines, numbered from 0";
}

}  // namespace

void NarrowingOptions::validate() const {
  require(percent == 0.0 || (percent >= 5.0 && percent <= 100.0), "lesion.narrow_percent",
          "0, or 5 to 100");
  require(length_mm == 0.0 || (length_mm >= 1.0 && length_mm <= 100.0), "lesion.narrow_length_mm",
          "0, or 1 to 100");
}

Narrowing choose_narrowing(const CenterlineTree& tree, const NarrowingOptions& options, int path_id,
                           double abscissa_mm) {
  const std::vector<Stretch> list = stretches(tree, path_id);
  if (list.empty())
    throw OptionError("lesion.centerline = " + std::to_string(path_id) +
                      " is not in this case (it has " + known_lines(tree) + ")");
  const auto better = [](const Stretch& a, const Stretch& b) {
    if (a.is_suitable() != b.is_suitable()) return a.is_suitable();
    return a.is_suitable() ? a.length() > b.length() : a.diameter > b.diameter;
  };
  const Stretch* best = &list.front();
  for (const Stretch& stretch : list)
    if (better(stretch, *best)) best = &stretch;
  Narrowing narrowing;
  narrowing.path_id = best->path->id;
  narrowing.abscissa_mm = best->middle();
  const CenterlinePath* path = best->path;
  if (abscissa_mm >= 0.0) {
    path = path_id >= 0 ? list.front().path : &tree.paths.front();
    narrowing.path_id = path->id;
    narrowing.abscissa_mm = abscissa_mm;
    if (abscissa_mm > path->abscissa.back())
      throw OptionError("lesion.abscissa_mm = " + std::to_string(abscissa_mm) +
                        " lies past the end of line " + std::to_string(path->id) + " (" +
                        std::to_string(path->abscissa.back()) + " mm)");
  }
  narrowing.diameter_mm = 2.0 * sample(*path, narrowing.abscissa_mm).inscribed_radius;
  narrowing.length_mm =
      options.length_mm > 0.0 ? options.length_mm : kLengthInDiameters * narrowing.diameter_mm;
  return narrowing;
}

TriangleMesh narrow_lumen(const TriangleMesh& surface, const CenterlinePath& path,
                          const Narrowing& narrowing, double percent) {
  TriangleMesh narrowed = surface;
  parallel_for(std::ptrdiff_t(surface.vertices.size()), [&](std::ptrdiff_t index) {
    Vec3& x = narrowed.vertices[std::size_t(index)];
    const double s = project(path, x);
    const double along = (s - narrowing.abscissa_mm) / narrowing.length_mm;
    if (std::abs(along) >= 0.5) return;
    const CenterlineSample line = sample(path, s);
    const double reach = distance(x, line.point) / line.equivalent_radius;
    const double own = 1.0 - smoothstep((reach - kOwnWall) / (kOtherWall - kOwnWall));
    const double window = 0.5 * (1.0 + std::cos(2.0 * units::kPi * along));
    x = line.point + (1.0 - 0.01 * percent * window * own) * (x - line.point);
  });
  return narrowed;
}

}  // namespace angio::meshing
