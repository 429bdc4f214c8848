#include "pipeline/case/throat_sd.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "formats/case_file.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;

std::optional<double> fitted_diameter_sd(const formats::PolylineData& fitted, const Vec3& throat) {
  const auto values_of = [&](const char* name) {
    for (const DataArray& array : fitted.point_arrays)
      if (array.name == name && array.values.size() == fitted.points.size()) return array.values;
    return std::vector<double>(fitted.points.size(), std::numeric_limits<double>::quiet_NaN());
  };
  const std::vector<double> radius = values_of("TubeRadius"),
                            sd = values_of("RadiusStandardDeviation");
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
      const double diameter_sd = 2.0 * between(sd);
      found = away <= between(radius) && std::isfinite(diameter_sd) && diameter_sd >= 0.0
                  ? std::optional(diameter_sd)
                  : std::nullopt;
    }
  return found;
}

std::optional<double> throat_sd(const StageFiles& files, const Vec3& throat) {
  if (!files.exists(file::kFittedLines) || files.exists(file::kNarrowedLumen)) return std::nullopt;
  return fitted_diameter_sd(formats::read_polylines(files.path(file::kFittedLines)), throat);
}

}  // namespace angio::pipeline
