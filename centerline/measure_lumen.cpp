#include <algorithm>
#include <cmath>

#include "centerline/centerline.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/section.hpp"
#include "centerline/detail/surface_wall.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {

LumenProfile measure_lumen(const TriangleMesh& surface, const CenterlinePath& path,
                           double first_abscissa, double last_abscissa) {
  if (path.points.size() < 2)
    throw InputError("the path has fewer than two points, so it has no sections. Run centerline");
  const SurfaceWall wall(close_surface(surface));
  const Polyline line{path.points, path.inscribed_radius};
  const auto begin = std::lower_bound(path.abscissa.begin(), path.abscissa.end(), first_abscissa);
  const auto end = std::upper_bound(begin, path.abscissa.end(), last_abscissa);
  const auto first = std::size_t(begin - path.abscissa.begin());
  std::vector<Section> sections(std::size_t(end - begin));
  parallel_for_uneven(std::ptrdiff_t(sections.size()), [&](std::ptrdiff_t index) {
    const std::size_t i = first + std::size_t(index);
    SectionOptions options;
    options.ray_count = 64;
    options.refinements = 2;
    // The wall may have moved outward to several times the radius of the path.
    options.expected = 3.0 * path.inscribed_radius[i];
    sections[std::size_t(index)] = measure_section(
        wall, line.points[i], tangent_at(line, path.abscissa, i, line.radius[i]), options);
  });
  LumenProfile profile;
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (!sections[k].valid) continue;  // the plane misses the lumen: at a rim
    profile.abscissa.push_back(path.abscissa[first + k]);
    profile.inscribed_radius.push_back(sections[k].inscribed_radius);
    profile.section_area.push_back(sections[k].area);
  }
  if (profile.abscissa.empty()) return profile;
  // As far as the triangles are large, and no farther than the vessel's own shape.
  const double sd = std::min(
      2.0 * wall.resolution(),
      0.4 * *std::min_element(profile.inscribed_radius.begin(), profile.inscribed_radius.end()));
  profile.inscribed_radius = smooth_along(profile.abscissa, profile.inscribed_radius, 0, sd);
  profile.section_area = smooth_along(profile.abscissa, profile.section_area, 0, sd);
  return profile;
}

}  // namespace angio::centerline
