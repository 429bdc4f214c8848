#pragma once

#include <cmath>
#include <vector>

#include "core/centerline.hpp"
#include "core/volume.hpp"
#include "datasets/detail/lumen_shape.hpp"
#include "datasets/detail/truth.hpp"

/// How near a level set and its lines come to a phantom's truth.
namespace angio {

/// What one run of one phantom gives; NaN where it does not apply.
struct Accuracy {
  std::vector<double> surface_mm;     ///< distance of points of the level set's zero from the wall
  std::vector<double> line_mm;        ///< distance of line points from the true line
  std::vector<double> radius_mm;      ///< signed errors of the tube's inscribed radius
  std::vector<double> wall_mm;        ///< and of the distance to the wall, noise and all
  std::vector<double> equivalent_mm;  ///< the same of the radius from the section's area
  std::vector<double> throat;         ///< relative errors of each lesion's least inscribed radius
  std::vector<double> throat_area;    ///< relative errors of each lesion's least section area
  double dice = NAN;
  double volume = NAN;  ///< relative error
  int branches_missed = 0;
  int branches_invented = 0;
  int lesions_missed = 0;
  int lesions_invented = 0;
  double segmentation_s = NAN;
  double centerline_s = NAN;
};

/// Distances from the true wall of the points where grid edges meet the level set's zero.
std::vector<double> surface_distances(const Volume<float>& level_set,
                                      const datasets::detail::LumenShape& shape);

/// Overlap and volume on the level set's grid. A voxel's part inside is that below the plane of its
/// distance.
void compare_volumes(const Volume<float>& level_set, const datasets::detail::LumenShape& shape,
                     Accuracy& accuracy);

/// Lines, branches and lesions.
void compare_trees(const CenterlineTree& found, const datasets::PhantomTruth& truth,
                   Accuracy& accuracy);

}  // namespace angio
