#include <algorithm>
#include <utility>

#include "centerline/centerline.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/surface_wall.hpp"
#include "centerline/detail/tube_model.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {

namespace {

/// The section at a point of a line that was found before the wall moved: from where the wall is
/// now, once more from the section's new middle.
TubeSection measure_at(const WallPoints& points, const Polyline& line,
                       const std::vector<double>& abscissa, std::size_t i) {
  // The wall may have moved outward to several times the radius of the path.
  constexpr double kMostGrowth = 4.0;
  LocalCurve curve = fit_curve(line, abscissa, i, std::max(line.extent[i], 1.2 * line.radius[i]));
  const double radius = look_for_wall(points, curve, kMostGrowth * line.radius[i]);
  if (radius <= 0.0) return {};
  const TubeSection rough = fit_tube(points, curve, radius, nullptr, TubeEffort::center);
  if (!rough.valid) return rough;
  curve.origin = rough.center;
  return fit_tube(points, curve, rough.inscribed_radius, nullptr, TubeEffort::measure);
}

}  // namespace

LumenProfile measure_lumen(const TriangleMesh& surface, const CenterlinePath& path,
                           double first_abscissa, double last_abscissa) {
  if (path.points.size() < 2)
    throw InputError("the path has fewer than two points, so it has no sections. Run centerline");
  ClosedSurface closed = close_surface(surface);
  closed.mesh.vertices.resize(std::size_t(closed.wall_vertex_count));
  const WallPoints points(std::move(closed.mesh.vertices));
  const Polyline line{path.points, path.inscribed_radius, path.equivalent_radius};
  const auto begin = std::lower_bound(path.abscissa.begin(), path.abscissa.end(), first_abscissa);
  const auto end = std::upper_bound(begin, path.abscissa.end(), last_abscissa);
  const auto first = std::size_t(begin - path.abscissa.begin());
  std::vector<TubeSection> sections(std::size_t(end - begin));
  parallel_for_uneven(std::ptrdiff_t(sections.size()), [&](std::ptrdiff_t index) {
    const std::size_t i = first + std::size_t(index);
    sections[std::size_t(index)] = measure_at(points, line, path.abscissa, i);
  });
  LumenProfile profile;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (!sections[k].valid) continue;  // the plane misses the lumen: at a rim
    profile.abscissa.push_back(path.abscissa[first + k]);
    profile.inscribed_radius.push_back(sections[k].inscribed_radius);
    profile.section_area.push_back(sections[k].area);
  }
  return profile;
}

}  // namespace angio::centerline
