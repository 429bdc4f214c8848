#include "reconstruction/detail/seen_field.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::reconstruction::detail {

Field common_field(const std::vector<angiogram::ConeBeamFrame>& frames, const Orbit& orbit,
                   const OpenField& open) {
  Field field{1e9, -1e9, 1e9};
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const double half = seen_half_width(frames[f], orbit, f, open), away = orbit.radius[f];
    field.radius = std::min(field.radius, half * away / std::hypot(half, away));
    const SeenRange seen = seen_height(frames[f], orbit, f, open);
    field.low = std::max(field.low, seen.low);
    field.high = std::min(field.high, seen.high);
  }
  if (!(field.radius > 0.0) || !(field.high > field.low))
    throw InputError(
        "no place around the axis is seen by every frame (the detector is off the axis, or its "
        "distances are wrong). Check the distances and the geometry");
  return field;
}

Grids make_grids(const Orbit& orbit, const Field& field, const PlaneGrid& plane,
                 const ReconstructionOptions& options) {
  const double height = field.high - field.low, side = std::max(2.0 * field.radius, height);
  const double voxel = options.voxel_mm > 0.0
                           ? options.voxel_mm
                           : std::max(plane.sample_mm, side / options.largest_side);
  const auto count = [&](double length) { return std::max(2, int(length / voxel)); };
  Grids grids;
  ColumnGrid& c = grids.columns;
  c.i_count = c.j_count = count(2.0 * field.radius);
  c.k_count = count(height);
  c.voxel = float(voxel);
  const auto first = [&](int n) { return -0.5 * (n - 1) * voxel; };
  const double middle = 0.5 * (field.low + field.high);
  c.first_x = c.first_y = float(first(c.i_count));
  c.first_z = float(middle + first(c.k_count));
  c.field_radius = float(field.radius);
  VolumeGeometry& g = grids.geometry;
  g.size = {c.i_count, c.j_count, c.k_count};
  g.spacing = {voxel, voxel, voxel};
  for (int row = 0; row < 3; ++row) {
    g.direction(row, 0) = orbit.first_direction[row];
    g.direction(row, 1) = orbit.second_direction[row];
    g.direction(row, 2) = orbit.axis[row];
  }
  g.origin = orbit.isocentre + double(c.first_x) * orbit.first_direction +
             double(c.first_y) * orbit.second_direction + double(c.first_z) * orbit.axis;
  return grids;
}

void fill_outside(const ColumnGrid& c, Volume<float>& volume) {
  const auto is_inside = [&](int i, int j) {
    const float x = c.first_x + float(i) * c.voxel, y = c.first_y + float(j) * c.voxel;
    return x * x + y * y <= c.field_radius * c.field_radius;
  };
  std::vector<float> some;
  constexpr int kEvery = 5;
  for (int k = 0; k < c.k_count; k += kEvery)
    for (int j = 0; j < c.j_count; j += kEvery)
      for (int i = 0; i < c.i_count; i += kEvery)
        if (is_inside(i, j)) some.push_back(volume.at(i, j, k));
  if (some.empty()) return;
  const auto middle = some.begin() + std::ptrdiff_t(some.size() / 2);
  std::nth_element(some.begin(), middle, some.end());
  parallel_for(c.k_count, [&](std::ptrdiff_t k) {
    for (int j = 0; j < c.j_count; ++j)
      for (int i = 0; i < c.i_count; ++i)
        if (!is_inside(i, j)) volume.at(i, j, int(k)) = *middle;
  });
}

double noise_of(const Volume<float>& volume) {
  constexpr int kEvery = 3;
  const auto& size = volume.geometry.size;
  std::vector<std::vector<float>> slices(std::size_t((size[2] + kEvery - 1) / kEvery));
  parallel_for(std::ptrdiff_t(slices.size()), [&](std::ptrdiff_t n) {
    const int k = int(n) * kEvery;
    for (int j = 0; j < size[1]; j += kEvery)
      for (int i = 1; i < size[0]; i += kEvery) {
        const float step = std::abs(volume.at(i, j, k) - volume.at(i - 1, j, k));
        if (step > 0.0F) slices[std::size_t(n)].push_back(step);
      }
  });
  std::vector<float> steps;
  for (const auto& slice : slices) steps.insert(steps.end(), slice.begin(), slice.end());
  if (steps.empty()) return 0.0;
  std::nth_element(steps.begin(), steps.begin() + std::ptrdiff_t(steps.size() / 2), steps.end());
  return double(steps[steps.size() / 2]) / (0.6745 * std::sqrt(2.0));
}

}  // namespace angio::reconstruction::detail
