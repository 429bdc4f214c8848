#include "viewer/detail/projection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace angio::viewer::detail {
namespace {

/// For each of the patient's axes the volume axis that runs along it; a permutation.
std::array<int, 3> nearest_axes(const Mat3& direction) {
  std::array<int, 3> best{0, 1, 2};
  std::array<int, 3> order{0, 1, 2};
  double best_sum = -1.0;
  do {
    double sum = 0.0;
    for (int patient = 0; patient < 3; ++patient)
      sum += std::abs(direction(patient, order[std::size_t(patient)]));
    if (sum > best_sum + 1e-12) {
      best_sum = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

/// Which patient axis runs across and down, and its wanted sign.
struct Layout {
  const char* name;
  int right;
  int down;
  double down_sign;
};
constexpr std::array<Layout, 3> kLayouts{{{"axial", 0, 1, 1.0},        // L to the right, P down
                                          {"coronal", 0, 2, -1.0},     // L to the right, feet down
                                          {"sagittal", 1, 2, -1.0}}};  // P to the right, feet down

void fill(Projection& projection, const Volume<float>& volume, const VoxelBox& box, int axis_in) {
  const auto right = std::size_t(projection.axis_right);
  const auto down = std::size_t(projection.axis_down);
  const auto in = std::size_t(axis_in);
  std::array<int, 3> voxel{};
  for (int y = 0; y < projection.height; ++y)
    for (int x = 0; x < projection.width; ++x) {
      const int step_x = projection.right_reversed ? projection.width - 1 - x : x;
      const int step_y = projection.down_reversed ? projection.height - 1 - y : y;
      voxel[right] = box.first[right] + step_x;
      voxel[down] = box.first[down] + step_y;
      float highest = -std::numeric_limits<float>::infinity();
      for (voxel[in] = box.first[in]; voxel[in] <= box.last[in]; ++voxel[in])
        highest = std::max(highest, volume.at(voxel[0], voxel[1], voxel[2]));
      projection.values[std::size_t(y) * std::size_t(projection.width) + std::size_t(x)] = highest;
    }
}

}  // namespace

Projection::Pixel Projection::pixel_of(const Vec3& index) const {
  const double x = index[axis_right] - first[std::size_t(axis_right)];
  const double y = index[axis_down] - first[std::size_t(axis_down)];
  return {right_reversed ? width - 1 - x : x, down_reversed ? height - 1 - y : y};
}

VoxelBox box_around(const VolumeGeometry& grid, const std::vector<Vec3>& points_in_lps,
                    double margin_mm) {
  VoxelBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Vec3& point : points_in_lps) {
      const double index = grid.index_from_lps(point)[int(axis)];
      low = std::min(low, index);
      high = std::max(high, index);
    }
    const double margin = margin_mm / grid.spacing[int(axis)];
    const double last = double(grid.size[axis] - 1);
    if (points_in_lps.empty()) low = 0.0, high = last;
    box.first[axis] = int(std::clamp(std::floor(low - margin), 0.0, last));
    box.last[axis] = int(std::clamp(std::ceil(high + margin), double(box.first[axis]), last));
  }
  return box;
}

std::vector<Projection> project_maximum(const Volume<float>& volume, const VoxelBox& box) {
  const VolumeGeometry& grid = volume.geometry;
  const std::array<int, 3> axis_of = nearest_axes(grid.direction);
  std::vector<Projection> projections;
  for (const Layout& layout : kLayouts) {
    Projection projection;
    projection.name = layout.name;
    projection.axis_right = axis_of[std::size_t(layout.right)];
    projection.axis_down = axis_of[std::size_t(layout.down)];
    projection.right_reversed = grid.direction(layout.right, projection.axis_right) < 0.0;
    projection.down_reversed =
        layout.down_sign * grid.direction(layout.down, projection.axis_down) < 0.0;
    projection.first = box.first;
    const auto right = std::size_t(projection.axis_right);
    const auto down = std::size_t(projection.axis_down);
    projection.width = box.last[right] - box.first[right] + 1;
    projection.height = box.last[down] - box.first[down] + 1;
    projection.pixel_width_mm = grid.spacing[projection.axis_right];
    projection.pixel_height_mm = grid.spacing[projection.axis_down];
    projection.values.resize(std::size_t(projection.width) * std::size_t(projection.height));
    fill(projection, volume, box, 3 - projection.axis_right - projection.axis_down);
    projections.push_back(std::move(projection));
  }
  return projections;
}

}  // namespace angio::viewer::detail
