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

std::array<PlanePoint, 4> corners(const ConeBeamFrame& frame, const Orbit& orbit,
                                  std::size_t index) {
  const double c = frame.columns - 1, r = frame.rows - 1;
  return {on_plane(frame, orbit, index, 0, 0), on_plane(frame, orbit, index, c, 0),
          on_plane(frame, orbit, index, 0, r), on_plane(frame, orbit, index, c, r)};
}

std::array<float, 4> cubic_weights(float t) {
  return {t * (-0.5F + t * (1.0F - 0.5F * t)), 1.0F + t * t * (-2.5F + 1.5F * t),
          t * (0.5F + t * (2.0F - 1.5F * t)), t * t * (-0.5F + 0.5F * t)};
}

/// The value at a place between pixels; beyond the edge the edge goes on.
float interpolate(const float* pixels, int columns, int rows, double column, double row) {
  const double x = std::clamp(column, 0.0, columns - 1.0), y = std::clamp(row, 0.0, rows - 1.0);
  const int c0 = int(x), r0 = int(y);
  const auto wx = cubic_weights(float(x - c0)), wy = cubic_weights(float(y - r0));
  float sum = 0.0F;
  for (int b = 0; b < 4; ++b) {
    const float* line =
        pixels + std::size_t(std::clamp(r0 - 1 + b, 0, rows - 1)) * std::size_t(columns);
    float part = 0.0F;
    for (int a = 0; a < 4; ++a)
      part += wx[std::size_t(a)] * line[std::clamp(c0 - 1 + a, 0, columns - 1)];
    sum += wy[std::size_t(b)] * part;
  }
  return sum;
}

/// The place in the frame of sample (i, j) on the plane, as a homography:
/// depth (column, row, 1) = at + i di + j dj.
struct Homography {
  Vec3 at, di, dj;
};
Homography homography(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
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
  return {
      seen(orbit.isocentre + double(place.first_u) * across + double(place.first_v) * orbit.axis,
           1.0),
      seen(grid.sample_mm * across, 0.0), seen(grid.sample_mm * orbit.axis, 0.0)};
}

}  // namespace

PlaneGrid plane_grid(const std::vector<ConeBeamFrame>& frames, const Orbit& orbit) {
  std::vector<double> sizes;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const auto corner = corners(frames[f], orbit, f);
    const double width = std::hypot(corner[1].u - corner[0].u, corner[1].v - corner[0].v);
    sizes.push_back(width / std::max(1, frames[f].columns - 1));
  }
  std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2), sizes.end());
  PlaneGrid grid;
  grid.sample_mm = sizes[sizes.size() / 2];
  const auto corner = corners(frames.front(), orbit, 0);
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

double seen_half_width(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index) {
  const auto c = corners(frame, orbit, index);
  const bool turned = c[0].u > c[1].u;
  const double low = turned ? std::max(c[1].u, c[3].u) : std::max(c[0].u, c[2].u);
  const double high = turned ? std::min(c[0].u, c[2].u) : std::min(c[1].u, c[3].u);
  return std::min(-low, high);
}

SeenHeight seen_height(const ConeBeamFrame& frame, const Orbit& orbit, std::size_t index) {
  const auto c = corners(frame, orbit, index);
  return c[0].v < c[2].v ? SeenHeight{std::max(c[0].v, c[1].v), std::min(c[2].v, c[3].v)}
                         : SeenHeight{std::max(c[2].v, c[3].v), std::min(c[0].v, c[1].v)};
}

std::vector<float> bring_onto_plane(const float* pixels, const ConeBeamFrame& frame,
                                    const Orbit& orbit, std::size_t index, const PlaneGrid& grid) {
  const Homography to_frame = homography(frame, orbit, index, grid);
  std::vector<float> values(std::size_t(grid.u_count) * std::size_t(grid.v_count));
  const auto place = [&](int i, int j) {
    const Vec3 p = to_frame.at + double(i) * to_frame.di + double(j) * to_frame.dj;
    return std::array{p.x / p.z, p.y / p.z};
  };
  // A detector that stands as it should has its pixels on the samples already.
  constexpr double kOnAPixel = 1e-3;
  bool is_exact = true;
  for (const int i : {0, grid.u_count - 1})
    for (const int j : {0, grid.v_count - 1})
      for (const double at : place(i, j))
        is_exact = is_exact && std::abs(at - std::round(at)) < kOnAPixel;
  for (int j = 0; j < grid.v_count; ++j)
    for (int i = 0; i < grid.u_count; ++i) {
      const auto [column, row] = place(i, j);
      float& value = values[std::size_t(j) * std::size_t(grid.u_count) + std::size_t(i)];
      if (is_exact) {
        const int c = std::clamp(int(std::lround(column)), 0, frame.columns - 1);
        const int r = std::clamp(int(std::lround(row)), 0, frame.rows - 1);
        value = pixels[std::size_t(r) * std::size_t(frame.columns) + std::size_t(c)];
      } else {
        value = interpolate(pixels, frame.columns, frame.rows, column, row);
      }
    }
  return values;
}

}  // namespace angio::reconstruction::detail
