#include "viewer/detail/path_sections.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace angio::viewer::detail {
namespace {

constexpr double kNearMm = 10.0;
constexpr double kShownRadii = 1.7;

using Key = std::pair<long long, long long>;

/// Points of two triangles on their common edge differ by rounding only.
Key key_of(const SectionPoint& point) {
  return {std::llround(point[0] * 1e5), std::llround(point[1] * 1e5)};
}

/// Joins segments that share an end. Each point has two at most, or a line ends there.
std::vector<std::vector<SectionPoint>> chain(
    const std::vector<std::array<SectionPoint, 2>>& segments) {
  std::multimap<Key, std::size_t> by_end;
  for (std::size_t s = 0; s < segments.size(); ++s)
    for (const SectionPoint& end : segments[s]) by_end.emplace(key_of(end), s);
  std::vector<char> is_used(segments.size(), 0);
  const auto follow = [&](std::vector<SectionPoint>& line) {
    for (bool goes_on = true; goes_on;) {
      goes_on = false;
      const auto [first, last] = by_end.equal_range(key_of(line.back()));
      for (auto at = first; at != last && !goes_on; ++at) {
        if (is_used[at->second] != 0) continue;
        const auto& segment = segments[at->second];
        const bool is_turned = key_of(segment[1]) == key_of(line.back());
        is_used[at->second] = 1;
        line.push_back(is_turned ? segment[0] : segment[1]);
        goes_on = true;
      }
    }
  };
  std::vector<std::vector<SectionPoint>> lines;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (is_used[s] != 0) continue;
    is_used[s] = 1;
    std::vector<SectionPoint> line{segments[s][0], segments[s][1]};
    follow(line);
    std::reverse(line.begin(), line.end());
    follow(line);
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

double widest_near(const CenterlinePath& path, double abscissa_mm, double reach_mm) {
  double radius = sample(path, abscissa_mm).equivalent_radius;
  for (std::size_t i = 0; i < path.points.size(); ++i)
    if (std::abs(path.abscissa[i] - abscissa_mm) <= reach_mm)
      radius = std::max({radius, path.inscribed_radius[i], path.equivalent_radius[i]});
  return std::max(radius, 0.1);
}

double shown_reach(const ReportContent& content, const CenterlinePath& path) {
  double reach = 3.0 * widest_near(path, content.lesion_abscissa_mm, kNearMm);
  const auto& measured = content.after.abscissa_mm;
  if (!measured.empty())
    reach = std::max(std::abs(measured.front() - content.lesion_abscissa_mm),
                     std::abs(measured.back() - content.lesion_abscissa_mm));
  return reach;
}

std::vector<double> places_around(const ReportContent& content, const CenterlinePath& path,
                                  double middle_mm, int count) {
  const double reach = shown_reach(content, path);
  const double place = std::clamp(middle_mm, path.abscissa.front(), path.abscissa.back());
  const double first = std::max(path.abscissa.front(), place - reach);
  const double last = std::min(path.abscissa.back(), place + reach);
  std::vector<double> places;
  const int middle = count / 2;
  for (int i = 0; i < count; ++i) {
    const double part = double(i - middle) / middle;  // -1 to 1
    places.push_back(place + part * (part < 0.0 ? place - first : last - place));
  }
  return places;
}

std::vector<double> places_around_lesion(const ReportContent& content, const CenterlinePath& path,
                                         int count) {
  return places_around(content, path, content.lesion_abscissa_mm, count);
}

std::vector<PathSection> path_sections(const ReportContent& content, const CenterlinePath& path,
                                       const std::vector<double>& abscissas) {
  double widest = widest_near(path, content.lesion_abscissa_mm, shown_reach(content, path));
  for (const DiameterProfile* opened : {&content.peak, &content.after})
    for (const double diameter : opened->equivalent_diameter_mm)
      if (std::isfinite(diameter)) widest = std::max(widest, 0.5 * diameter);
  const double half_size = kShownRadii * widest;
  std::vector<PathSection> sections;
  Vec3 right = any_perpendicular(sample(path, abscissas.front()).tangent);
  for (const double abscissa : abscissas) {
    const CenterlineSample place = sample(path, abscissa);
    right = normalized(right - dot(right, place.tangent) * place.tangent);
    sections.push_back({{place.point, right, cross(place.tangent, right), half_size}, abscissa});
  }
  return sections;
}

TriangleMesh near_sections(const TriangleMesh& mesh, const std::vector<PathSection>& sections) {
  Vec3 low = sections.front().window.center, high = low;
  for (const PathSection& section : sections)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], section.window.center[axis]);
      high[axis] = std::max(high[axis], section.window.center[axis]);
    }
  const double room = 2.0 * sections.front().window.half_size_mm;
  const auto is_near = [&](int corner) {
    const Vec3& p = mesh.vertices[std::size_t(corner)];
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] < low[axis] - room || p[axis] > high[axis] + room) return false;
    return true;
  };
  TriangleMesh result;
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (const Triangle& triangle : mesh.triangles) {
    if (std::none_of(triangle.begin(), triangle.end(), is_near)) continue;
    Triangle kept{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& index = new_index[std::size_t(triangle[c])];
      if (index < 0) {
        index = int(result.vertices.size());
        result.vertices.push_back(mesh.vertices[std::size_t(triangle[c])]);
      }
      kept[c] = index;
    }
    result.triangles.push_back(kept);
  }
  return result;
}

std::vector<std::vector<SectionPoint>> section_contours(const TriangleMesh& mesh,
                                                        const PlaneWindow& window) {
  const auto place = [&](const Vec3& point) {
    const Vec3 from = point - window.center;
    return SectionPoint{dot(from, window.right), dot(from, window.down)};
  };
  const auto is_shown = [&](const SectionPoint& p) {
    constexpr double kRoom = 1.5;
    return std::max(std::abs(p[0]), std::abs(p[1])) < kRoom * window.half_size_mm;
  };
  std::vector<std::array<SectionPoint, 2>> segments;
  for (const Segment& segment : cut(mesh, window.center, cross(window.right, window.down))) {
    const std::array<SectionPoint, 2> flat{place(segment[0]), place(segment[1])};
    if (is_shown(flat[0]) && is_shown(flat[1])) segments.push_back(flat);
  }
  return chain(segments);
}

std::optional<std::array<double, 2>> nearest_edges(
    const std::vector<std::vector<SectionPoint>>& contours, std::size_t axis) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::array<double, 2> edges{-kNone, kNone};
  const std::size_t other = 1 - axis;
  for (const auto& line : contours)
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const double a = line[i][other], b = line[i + 1][other];
      if ((a < 0.0) == (b < 0.0)) continue;
      const double at = line[i][axis] + a / (a - b) * (line[i + 1][axis] - line[i][axis]);
      if (at < 0.0)
        edges[0] = std::max(edges[0], at);
      else
        edges[1] = std::min(edges[1], at);
    }
  if (std::isinf(edges[0]) || std::isinf(edges[1])) return std::nullopt;
  return edges;
}

}  // namespace angio::viewer::detail
