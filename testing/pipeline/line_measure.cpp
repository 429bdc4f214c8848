#include "testing/pipeline/line_measure.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "testing/pipeline/wall_probe.hpp"

namespace angio {
namespace {

constexpr double kDegrees = 180.0 / units::kPi;

double angle(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(dot(normalized(a), normalized(b)), -1.0, 1.0)) * kDegrees;
}

std::vector<char> blanked(const CenterlinePath& path) {
  std::vector<char> mark(path.points.size(), 0);
  for (const CenterlineTract& tract : path.tracts)
    if (tract.blanking)
      for (int i = tract.first_point; i <= tract.last_point; ++i) mark[std::size_t(i)] = 1;
  return mark;
}

/// Points whose stretch another, longer path has had already are not counted again.
std::size_t first_own(const CenterlineTree& tree, std::size_t k) {
  std::size_t own = 0;
  const auto& points = tree.paths[k].points;
  for (std::size_t j = 0; j < k; ++j) {
    const auto& other = tree.paths[j].points;
    std::size_t i = 0;
    while (i < points.size() && i < other.size() && points[i] == other[i]) ++i;
    own = std::max(own, i);
  }
  return own;
}

/// Length against that of the line averaged over a radius to each side.
double excess_length(const CenterlinePath& path) {
  const std::size_t n = path.points.size();
  std::vector<Vec3> mean(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double reach = std::min(
        {path.inscribed_radius[i], path.abscissa[i], path.abscissa.back() - path.abscissa[i]});
    Vec3 sum;
    int count = 0;
    for (std::size_t j = 0; j < n; ++j)
      if (std::abs(path.abscissa[j] - path.abscissa[i]) <= reach) {
        sum += path.points[j];
        ++count;
      }
    mean[i] = (1.0 / count) * sum;
  }
  return 100.0 * (path.abscissa.back() / arc_length(mean).back() - 1.0);
}

void judge_path(const CenterlinePath& path, std::size_t own, const WallProbe& wall,
                LineMeasure& q) {
  const std::vector<char> in_branching = blanked(path);
  const std::size_t n = path.points.size();
  const auto segment = [&](std::size_t i) { return path.points[i + 1] - path.points[i]; };
  for (std::size_t i = own; i < n; ++i) {
    ++q.points;
    if (i > 0 && i + 1 < n && !wall.is_inside(path.points[i])) ++q.outside;
    if (i + 1 < n) {
      const double change = path.inscribed_radius[i + 1] / path.inscribed_radius[i];
      if (std::max(change, 1.0 / change) > 1.4) ++q.jumps;
    }
    const double from_end = std::min(path.abscissa[i], path.abscissa.back() - path.abscissa[i]);
    if (in_branching[i] == 0 && from_end > 2.0 * path.inscribed_radius[i]) {
      const double truth = wall.to_wall(path.points[i]);
      const double error = std::abs(path.inscribed_radius[i] / truth - 1.0);
      q.radius_errors.push_back(error);
      if (error > 0.02) ++q.radius_off;
    }
    if (i == 0 || i + 1 >= n || in_branching[i] != 0) continue;
    const double step = angle(segment(i - 1), segment(i));
    q.largest_step = std::max(q.largest_step, step);
    if (step > 25.0) ++q.sharp_steps;
    double turn = 0.0;
    for (std::size_t j = i; j + 1 < n && in_branching[j] == 0 &&
                            path.abscissa[j] - path.abscissa[i] <= path.inscribed_radius[i];
         ++j)
      turn = std::max(turn, angle(segment(i - 1), segment(j)));
    q.largest_radius = std::max(q.largest_radius, turn);
    if (turn > 40.0) ++q.sharp_radii;
  }
  q.too_long = std::max(q.too_long, excess_length(path));
}

}  // namespace

double LineMeasure::inside_percent() const {
  return points == 0 ? 0.0 : 100.0 * (points - outside) / points;
}

double LineMeasure::radius_off_percent() const {
  return 100.0 * radius_off / std::max<double>(1.0, double(radius_errors.size()));
}

LineMeasure measure_lines(const CenterlineTree& tree, const std::filesystem::path& case_folder) {
  const WallProbe wall(case_folder);
  LineMeasure measure;
  for (std::size_t k = 0; k < tree.paths.size(); ++k)
    judge_path(tree.paths[k], first_own(tree, k), wall, measure);
  return measure;
}

}  // namespace angio
