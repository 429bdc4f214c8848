#include "reconstruction/detail/plane_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace angio::reconstruction::detail {
namespace {

using angiogram::ConeBeamFrame;
using angiogram::ConeBeamView;

/// Where the ray through a pixel meets the frame's plane.
struct PlanePoint {
  double u = 0.0, v = 0.0;
};
PlanePoint on_plane(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                    double column, double row) {
  const Vec3 ray = frame.place(column, row) - frame.source;
  const Vec3 to_source = orbit.to_source(index);
  const double way = -orbit.radius[index] / dot(ray, to_source);
  const Vec3 met = frame.source + way * ray - orbit.isocentre;
  return {dot(met, orbit.across(index)), dot(met, orbit.axis)};
}

std::array<PlanePoint, 4> corners(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                                  const OpenField& open) {
  const auto corner = [&](int column, int row) {
    return on_plane(frame, orbit, index, column, row);
  };
  return {corner(open.first_column, open.first_row), corner(open.last_column, open.first_row),
          corner(open.first_column, open.last_row), corner(open.last_column, open.last_row)};
}

/// What a frame sees whole along a coordinate of its plane, whichever way the picture is turned:
/// between the inner two corners.
SeenRange seen_range(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                     const OpenField& open, double PlanePoint::*coordinate) {
  std::array<double, 4> along{};
  const auto met = corners(frame, orbit, index, open);
  std::transform(met.begin(), met.end(), along.begin(),
                 [&](const PlanePoint& corner) { return corner.*coordinate; });
  std::sort(along.begin(), along.end());
  return {along[1], along[2]};
}

}  // namespace

PlaneGrid plane_grid(const std::vector<ConeBeamFrame>& frames, const Orbit& orbit) {
  std::vector<double> sizes;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto corner = corners(frames[f], orbit, f, whole_field(frames[f]));
    const double width = std::hypot(corner[1].u - corner[0].u, corner[1].v - corner[0].v);
    sizes.push_back(width / std::max(1, frames[f].columns - 1));
  }
  std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2), sizes.end());
  PlaneGrid grid;
  grid.sample_mm = sizes[sizes.size() / 2];
  const auto corner = corners(frames.front(), orbit, 0, whole_field(frames.front()));
  const auto count = [&](double length) { return int(std::lround(length / grid.sample_mm)) + 1; };
  const auto [least_u, most_u] = std::minmax({corner[0].u, corner[1].u, corner[2].u, corner[3].u});
  const auto [least_v, most_v] = std::minmax({corner[0].v, corner[1].v, corner[2].v, corner[3].v});
  grid.u_count = count(most_u - least_u);
  grid.v_count = count(most_v - least_v);
  return grid;
}

PlaneFrame place_on_plane(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                          const PlaneGrid& grid) {
  const Vec3 to_source = orbit.to_source(index), across = orbit.across(index);
  PlaneFrame place;
  place.source_x = float(dot(to_source, orbit.first_direction));
  place.source_y = float(dot(to_source, orbit.second_direction));
  place.across_x = float(dot(across, orbit.first_direction));
  place.across_y = float(dot(across, orbit.second_direction));
  place.radius = float(orbit.radius[index]);
  place.height = float(orbit.height[index]);
  const PlanePoint middle =
      on_plane(frame, orbit, index, 0.5 * (frame.columns - 1), 0.5 * (frame.rows - 1));
  place.first_u = float(middle.u - 0.5 * (grid.u_count - 1) * grid.sample_mm);
  place.first_v = float(middle.v - 0.5 * (grid.v_count - 1) * grid.sample_mm);
  place.per_mm = float(1.0 / grid.sample_mm);
  return place;
}

double seen_half_width(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                       const OpenField& open) {
  const SeenRange across = seen_range(frame, orbit, index, open, &PlanePoint::u);
  return std::min(-across.low, across.high);
}

SeenRange seen_height(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                      const OpenField& open) {
  return seen_range(frame, orbit, index, open, &PlanePoint::v);
}

std::vector<double> across_mm(const PlaneFrame& place, const PlaneGrid& grid) {
  std::vector<double> across;
  for (int i = 0; i < grid.u_count; ++i)
    across.push_back(double(place.first_u) + i * grid.sample_mm);
  return across;
}

PlaneMap plane_map(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                   const PlaneGrid& grid) {
  const PlaneFrame place = place_on_plane(frame, orbit, index, grid);
  const auto matrix = ConeBeamView(frame).matrix();
  const auto seen = [&](const Vec3& x, double one) {
    Vec3 result;
    for (int row = 0; row < 3; ++row) {
      const auto& m = matrix[std::size_t(row)];
      result[row] = m[0] * x.x + m[1] * x.y + m[2] * x.z + m[3] * one;
    }
    return result;
  };
  const Vec3 across = orbit.across(index);
  PlaneMap map;
  map.at = seen(
      orbit.isocentre + double(place.first_u) * across + double(place.first_v) * orbit.axis, 1.0);
  map.di = seen(grid.sample_mm * across, 0.0);
  map.dj = seen(grid.sample_mm * orbit.axis, 0.0);
  map.columns = frame.columns;
  map.rows = frame.rows;
  // A detector that stands as it should has its pixels on the samples already.
  constexpr double kOnAPixel = 1e-3;
  const auto is_whole = [](double at) { return std::abs(at - std::round(at)) < kOnAPixel; };
  map.is_exact = true;
  for (const int i : {0, grid.u_count - 1})
    for (const int j : {0, grid.v_count - 1}) {
      const PicturePlace at = place_of(map, i, j);
      map.is_exact = map.is_exact && is_whole(at.column) && is_whole(at.row);
    }
  return map;
}

std::vector<float> bring_onto_plane(const float* pixels, const PlaneMap& map,
                                    const PlaneGrid& grid) {
  std::vector<float> values(std::size_t(grid.u_count) * std::size_t(grid.v_count));
  for (int j = 0; j < grid.v_count; ++j)
    for (int i = 0; i < grid.u_count; ++i)
      values[std::size_t(j) * std::size_t(grid.u_count) + std::size_t(i)] =
          sample_picture(pixels, map, i, j);
  return values;
}

}  // namespace angio::reconstruction::detail
