#include "centerline/detail/blood.hpp"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/statistics.hpp"

namespace angio::centerline {
namespace {

struct Brightness {
  double middle, spread;  ///< median, and between the quartiles
  double contrast;        ///< the median above what lies around
};

/// Of the lumen between two abscissas [mm]; nothing where it is too thin to tell.
std::optional<Brightness> brightness_between(const CenterlinePath& path, double first, double last,
                                             const std::function<double(const Vec3&)>& intensity,
                                             double voxel_mm) {
  constexpr double kLeastVoxels = 2.0, kAround = 2.0;  // of the radius; in radii
  constexpr std::size_t kLeastPlaces = 5;
  std::vector<double> inside, around;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const double radius = path.inscribed_radius[i];
    if (path.abscissa[i] < first || path.abscissa[i] > last || radius < kLeastVoxels * voxel_mm)
      continue;
    inside.push_back(intensity(path.points[i]));
    const double away = kAround * radius;
    for (const Vec3& side : {Vec3{away, 0.0, 0.0}, Vec3{0.0, away, 0.0}, Vec3{0.0, 0.0, away}}) {
      around.push_back(intensity(path.points[i] + side));
      around.push_back(intensity(path.points[i] - side));
    }
  }
  if (inside.size() < kLeastPlaces) return std::nullopt;
  const double middle = quantile(inside, 0.5);
  return Brightness{middle, quantile(inside, 0.75) - quantile(inside, 0.25),
                    middle - quantile(around, 0.25)};
}

/// Whether values scatter too much for blood; also where nothing is brighter than its surroundings.
bool is_uneven(const std::optional<Brightness>& side) {
  constexpr double kMostSpread = 0.25;
  return side && side->spread > kMostSpread * side->contrast;
}

}  // namespace

bool is_other_blood(const CenterlinePath& path, const Lesion& lesion,
                    const std::function<double(const Vec3&)>& intensity, double voxel_mm) {
  constexpr double kReach = 3.0, kMostRise = 0.2, kMostFall = 0.5;
  const double reach = kReach * lesion.reference_diameter_mm;
  const auto before =
      brightness_between(path, lesion.proximal_mm - reach, lesion.proximal_mm, intensity, voxel_mm);
  const auto behind =
      brightness_between(path, lesion.distal_mm, lesion.distal_mm + reach, intensity, voxel_mm);
  if (is_uneven(before) || is_uneven(behind)) return true;
  if (!before || !behind) return false;
  const double rise = behind->middle - before->middle,
               contrast = 0.5 * (before->contrast + behind->contrast);
  return rise > kMostRise * contrast || -rise > kMostFall * contrast;
}

}  // namespace angio::centerline
