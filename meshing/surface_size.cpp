#include "meshing/surface_size.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "core/parallel.hpp"
#include "meshing/detail/hollow.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing {
namespace {

/// Diameters seen from places spread evenly over the area, ascending.
std::vector<double> diameters(const TriangleMesh& mesh, double area, int sample_count) {
  const std::vector<std::size_t> samples = detail::samples_of(mesh, area, sample_count);
  const detail::ClosestPoint wall(mesh);
  std::vector<double> found(samples.size());
  parallel_for_uneven(std::ptrdiff_t(samples.size()), [&](std::ptrdiff_t i) {
    const Triangle& t = mesh.triangles[samples[std::size_t(i)]];
    const Vec3 middle = (mesh.vertices[std::size_t(t[0])] + mesh.vertices[std::size_t(t[1])] +
                         mesh.vertices[std::size_t(t[2])]) /
                        3.0;
    found[std::size_t(i)] = detail::touching_ball(
        wall, middle, -normalized(area_vector_doubled(mesh, t)), int(samples[std::size_t(i)]));
  });
  std::erase(found, 0.0);
  std::sort(found.begin(), found.end());
  return found;
}

double volume_inside(const TriangleMesh& mesh, const std::vector<SurfaceRim>& rims) {
  double six_volumes = 6.0 * enclosed_volume(mesh);
  for (const SurfaceRim& rim : rims)
    for (std::size_t i = 0; i < rim.loop.size(); ++i)
      six_volumes +=
          dot(mesh.vertices[std::size_t(rim.loop[i])],
              cross(mesh.vertices[std::size_t(rim.loop[(i + 1) % rim.loop.size()])], rim.centre));
  return six_volumes / 6.0;
}

}  // namespace

TriangleMesh lumen_of_wall(const TriangleMesh& wall) { return detail::hollow_of(wall); }

bool is_wall(const SurfaceSize& size) { return size.hollow_share > detail::kWallShare; }

void SurfaceSize::scale(double factor) {
  for (Vec3* corner : {&low, &high}) *corner *= factor;
  for (double* length : {&extent, &thin, &median, &wide}) *length *= factor;
  area *= factor * factor;
  volume *= factor * factor * factor;
  for (SurfaceRim& rim : rims) {
    rim.centre *= factor;
    rim.diameter_mm *= factor;
    rim.unevenness_mm *= factor;
  }
}

SurfaceSize measure_surface(const TriangleMesh& surface) {
  SurfaceSize size;
  if (surface.triangles.empty()) return size;
  size.low = size.high = surface.vertices[std::size_t(surface.triangles.front()[0])];
  for (const Triangle& t : surface.triangles)
    for (const int v : t)
      for (int axis = 0; axis < 3; ++axis) {
        const double x = surface.vertices[std::size_t(v)][axis];
        size.low[axis] = std::min(size.low[axis], x);
        size.high[axis] = std::max(size.high[axis], x);
      }
  const Vec3 sides = size.high - size.low;
  size.extent = std::max({sides.x, sides.y, sides.z});
  size.area = surface_area(surface);
  size.rims = surface_rims(surface);
  size.volume = volume_inside(surface, size.rims);
  if (size.area <= 0.0) return size;
  constexpr int kSamples = 2000;
  const std::vector<double> seen = diameters(surface, size.area, kSamples);
  const auto at_share = [&](double share) {
    return seen.empty() ? 0.0 : seen[std::size_t(share * double(seen.size() - 1))];
  };
  size.thin = at_share(0.05);
  size.median = at_share(0.5);
  size.wide = at_share(0.98);
  size.hollow_share = detail::hollow_share_of(surface, size.area);
  return size;
}

double median_diameter(const TriangleMesh& surface) {
  constexpr int kSamples = 300;
  const double area = surface_area(surface);
  if (area <= 0.0) return 0.0;
  const std::vector<double> seen = diameters(surface, area, kSamples);
  return seen.empty() ? 0.0 : seen[seen.size() / 2];
}

namespace {

struct Range {
  double least, most;
  [[nodiscard]] bool holds(double x) const { return x >= least && x <= most; }
};
struct VesselSizes {  // [mm]; the header says why
  Range wide, median, extent;
  [[nodiscard]] bool hold(const SurfaceSize& size, LengthUnit unit) const {
    const double mm = kMillimetresOf[int(unit)];
    return wide.holds(mm * size.wide) && median.holds(mm * size.median) &&
           extent.holds(mm * size.extent);
  }
};
constexpr VesselSizes kPossible{{1.0, 80.0}, {0.8, 60.0}, {4.0, 1200.0}};
constexpr VesselSizes kUsual{{2.5, 60.0}, {1.2, 35.0}, {4.0, 600.0}};
constexpr double kField = 500.0;  // [mm] of a scanner
constexpr LengthUnit kGuessed[] = {LengthUnit::mm, LengthUnit::cm, LengthUnit::m};

/// How far the surface reaches from the origin across the table.
double reach_across(const SurfaceSize& size) {
  return std::max(
      {std::abs(size.low.x), std::abs(size.high.x), std::abs(size.low.y), std::abs(size.high.y)});
}

bool in_field(const SurfaceSize& size, LengthUnit unit) {
  return unit == LengthUnit::mm || kMillimetresOf[int(unit)] * reach_across(size) <= kField;
}

}  // namespace

std::string size_in_words(const SurfaceSize& size, LengthUnit unit) {
  const double mm = kMillimetresOf[int(unit)];
  char text[128];
  std::snprintf(text, sizeof text, "%.3g mm wide at most, %.3g mm in the median, %.3g mm long",
                mm * size.wide, mm * size.median, mm * size.extent);
  return text;
}

bool is_possible(const SurfaceSize& size, LengthUnit unit) {
  return in_field(size, unit) && kPossible.hold(size, unit);
}

UnitGuess guess_unit(const SurfaceSize& size) {
  UnitGuess guess;
  const auto fitting_units = [&](const VesselSizes& sizes, bool must_be_in_field) {
    std::vector<LengthUnit> fitting;
    for (const LengthUnit unit : kGuessed)
      if (sizes.hold(size, unit) && (!must_be_in_field || in_field(size, unit)))
        fitting.push_back(unit);
    return fitting;
  };
  for (const VesselSizes& sizes : {kUsual, kPossible}) {
    std::vector<LengthUnit> fitting = fitting_units(sizes, true);
    if (fitting.empty()) continue;
    if (!guess.is_vessel) guess.unit = fitting.front();
    guess.is_vessel = true;
    std::erase(fitting, guess.unit);
    guess.others = fitting;
    // Where mm is as usual as can be, what else is merely possible is not worth a word.
    if (guess.unit == LengthUnit::mm) break;
  }
  if (guess.is_vessel) return guess;
  // Not where a scanner would have put it: moved, but still a vessel by its size.
  std::vector<LengthUnit> moved = fitting_units(kUsual, false);
  if (moved.empty()) return guess;
  guess.is_vessel = true;
  guess.unit = moved.front();
  guess.others.assign(moved.begin() + 1, moved.end());
  return guess;
}

}  // namespace angio::meshing
