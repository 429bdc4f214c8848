#pragma once

#include <cstddef>
#include <vector>

#include "core/host_device.hpp"
#include "core/volume.hpp"
#include "reconstruction/detail/orbit.hpp"

/// Feldkamp's back-projection, a column of voxels at a time. On the plane through the axis that
/// faces the source, the points of a line along the axis share u, and v is linear on the line.
namespace angio::reconstruction::detail {

/// A frame on its plane: lengths in mm around the isocentre, x and y across the axis.
struct PlaneFrame {
  float source_x = 0, source_y = 0;  ///< unit, towards the source
  float across_x = 0, across_y = 0;  ///< unit, along u
  float radius = 0;                  ///< the source's distance from the axis
  float height = 0;                  ///< the source's, along the axis
  float first_u = 0, first_v = 0;    ///< of the first sample
  float per_mm = 0;                  ///< samples to a mm
};

/// How a frame sees a line along the axis.
struct ColumnView {
  float u = 0;  ///< which of the frame's lines along v, counted in samples
  float v = 0;  ///< the sample along v at z = 0
  float v_per_mm = 0;
  float weight = 0;  ///< (R / (R - t))^2
};

ANGIO_HOST_DEVICE inline ColumnView view_column(const PlaneFrame& f, float x, float y) {
  const float zoom = f.radius / (f.radius - (x * f.source_x + y * f.source_y));
  ColumnView view;
  view.u = (zoom * (x * f.across_x + y * f.across_y) - f.first_u) * f.per_mm;
  view.v = (f.height * (1.0F - zoom) - f.first_v) * f.per_mm;
  view.v_per_mm = zoom * f.per_mm;
  view.weight = zoom * zoom;
  return view;
}

/// Where a stretch of voxels along the axis begins [mm].
struct Stretch {
  float x = 0, y = 0, z = 0;
  float voxel = 1;
};

/// Adds what a frame gives to a stretch of a line of voxels, from z on upward.
///
/// @param sample  the filtered frame between its samples, linear, its outermost values going on
///                beyond its edges: sample(u, v)
template <int kCount, class Sample>
ANGIO_HOST_DEVICE inline void add_frame(const PlaneFrame& frame, int u_count, const Stretch& at,
                                        const Sample& sample, float (&sums)[kCount]) {
  const ColumnView view = view_column(frame, at.x, at.y);
  if (!(view.u >= 0.0F && view.u < float(u_count - 1))) return;
  const float first = view.v + view.v_per_mm * at.z, step = view.v_per_mm * at.voxel;
  for (int n = 0; n < kCount; ++n) sums[n] += view.weight * sample(view.u, first + float(n) * step);
}

/// Filtered frames on their planes. Lines along v lie one behind the other.
struct FilteredFrames {
  int u_count = 0, v_count = 0;
  std::vector<PlaneFrame> frames;
  std::vector<float> values;  ///< shape [frame_count, u_count, v_count]
};

/// Where voxels lie around the isocentre: across the axis along i and j, along it along k.
struct ColumnGrid {
  int i_count = 0, j_count = 0, k_count = 0;
  float voxel = 1;                              ///< edge [mm]
  float first_x = 0, first_y = 0, first_z = 0;  ///< of the first voxel's middle [mm]
  float field_radius = 0;                       ///< columns farther from the axis are left alone
};

/// Adds frames to a volume. Beyond a frame's first and last sample along v the outermost goes on.
/// @param sums  shape [j_count, i_count, k_count]
void back_project(const FilteredFrames& frames, const ColumnGrid& grid, std::vector<float>& sums);

/// Columns of voxels as a volume's slices.
/// @param columns  shape [j_count, i_count, k_count]
/// @return shape [k_count, j_count, i_count]
std::vector<float> to_slices(const std::vector<float>& columns, const ColumnGrid& grid);

}  // namespace angio::reconstruction::detail
