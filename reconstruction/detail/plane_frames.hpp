#pragma once

#include <vector>

#include "reconstruction/detail/back_projection.hpp"
#include "reconstruction/detail/orbit.hpp"
#include "reconstruction/detail/plane_samples.hpp"
#include "reconstruction/reconstruction.hpp"

/// Frames as if their detectors stood in the plane through the axis that faces the source, their
/// rows across the axis.
namespace angio::reconstruction::detail {

/// The samples that all frames of a run get on their planes.
struct PlaneGrid {
  int u_count = 0, v_count = 0;  ///< as many as the detector has columns and rows
  double sample_mm = 0.0;
};

/// Samples of a pixel's size.
PlaneGrid plane_grid(const std::vector<angiogram::ConeBeamFrame>& frames, const Orbit& orbit);

/// Where a frame's samples lie: from the least u and v that its detector sees, so that a detector
/// that stands as it should keeps its pixels.
PlaneFrame place_on_plane(const angiogram::ConeBeamFrame& frame, const Orbit& orbit,
                          std::size_t index, const PlaneGrid& grid);

/// How far along u a frame's open field sees from the axis to both sides, on its plane, in all of
/// its rows [mm].
double seen_half_width(const angiogram::ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                       const OpenField& open);
/// The same along v, up and down.
struct SeenRange {
  double low = 0.0, high = 0.0;
};
SeenRange seen_height(const angiogram::ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                      const OpenField& open);

/// u of a frame's samples [mm], shape [u_count].
std::vector<double> across_mm(const PlaneFrame& place, const PlaneGrid& grid);

PlaneMap plane_map(const angiogram::ConeBeamFrame& frame, const Orbit& orbit, std::size_t index,
                   const PlaneGrid& grid);

/// Brings a frame's values onto its plane, by cubic convolution, which keeps what needs no
/// interpolation.
/// @return shape [v_count, u_count]
std::vector<float> bring_onto_plane(const float* pixels, const PlaneMap& map,
                                    const PlaneGrid& grid);

}  // namespace angio::reconstruction::detail
