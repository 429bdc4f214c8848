#include "pipeline/case/throat_sd.hpp"

#include <algorithm>
#include <limits>

#include "formats/case_file.hpp"
#include "formats/checked_arrays.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;

std::optional<double> fitted_diameter_sd(const formats::PolylineData& fitted, const Vec3& throat) {
  const formats::CheckedArrays at_points(fitted.point_arrays, fitted.points.size(),
                                         "the fitted lines");
  constexpr double kMost = 1e4;  // [mm]
  const auto radius = at_points.numbers("TubeRadius", 0.0, kMost),
             sd = at_points.numbers("RadiusStandardDeviation", 0.0, kMost);
  double nearest = std::numeric_limits<double>::infinity();
  std::optional<double> found;
  for (const std::vector<int>& line : fitted.lines)
    for (std::size_t n = 1; n < line.size(); ++n) {
      const auto a = std::size_t(line[n - 1]), b = std::size_t(line[n]);
      const Vec3 way = fitted.points[b] - fitted.points[a];
      const double length = dot(way, way);
      const double part =
          length > 0.0 ? std::clamp(dot(throat - fitted.points[a], way) / length, 0.0, 1.0) : 0.0;
      const double away = distance(fitted.points[a] + part * way, throat);
      if (away >= nearest) continue;
      nearest = away;
      const auto between = [&](const auto& values) {
        return (1.0 - part) * values[a] + part * values[b];
      };
      found = away <= between(radius) ? std::optional(2.0 * between(sd)) : std::nullopt;
    }
  return found;
}

std::optional<double> throat_sd(const StageFiles& files, const Vec3& throat) {
  if (!files.exists(file::kFittedLines) || files.exists(file::kNarrowedLumen)) return std::nullopt;
  return fitted_diameter_sd(formats::read_polylines(files.path(file::kFittedLines)), throat);
}

}  // namespace angio::pipeline
