#pragma once

#include <cstddef>
#include <vector>

#include "reconstruction/detail/back_projection.hpp"

/// Projection of some voxels of a grid onto frames on their planes, and its exact transpose.
///
/// The line integrals of a voxel's box, averaged over a sample, by separable footprints (Long,
/// Fessler, Balter, IEEE Trans. Med. Imaging 29:1839, 2010, section III: a trapezoid along u from
/// the projections of the box's four edges along the axis, a rectangle along v):
///
///     a(f, u, v; x) = l integral_u-1/2^u+1/2 trapezoid  integral_v-1/2^v+1/2 rectangle,
///     l = h / max(|cos phi|, |sin phi|)
///
/// h: edge of a voxel; phi: the ray's direction across the axis. Lengths are those across the axis:
/// who compares with line integrals along slanted rays divides these by their slant first.
namespace angio::reconstruction::detail {

/// Voxels of one column of the grid that follow each other.
struct VoxelRun {
  int i = 0, j = 0, first_k = 0, count = 0;
  std::size_t offset = 0;  ///< of the first of them among all chosen voxels
};

/// The voxels of a grid that may be other than zero.
struct ChosenVoxels {
  ColumnGrid grid;
  std::vector<VoxelRun> runs;  ///< by j, i, k
  std::size_t count = 0;
};

/// Frames on their planes, unfiltered; lines along v lie one behind the other.
struct FrameStack {
  int u_count = 0, v_count = 0;
  std::vector<PlaneFrame> places;
  std::vector<float> values;  ///< shape [places, u_count, v_count]

  [[nodiscard]] std::size_t per_frame() const {
    return std::size_t(u_count) * std::size_t(v_count);
  }
};

/// @param values  of the voxels [1/mm], shape [voxels.count]
/// @param which   frames of `like`, which gives places and sizes
/// @return shape [which, u_count, v_count]
std::vector<float> project(const ChosenVoxels& voxels, const std::vector<float>& values,
                           const FrameStack& like, const std::vector<int>& which);

/// The transpose: sum over samples of a(f, u, v; x) times the sample.
/// @param samples  shape [which, u_count, v_count]
/// @return shape [voxels.count]
std::vector<float> project_back(const ChosenVoxels& voxels, const std::vector<float>& samples,
                                const FrameStack& like, const std::vector<int>& which);

}  // namespace angio::reconstruction::detail
