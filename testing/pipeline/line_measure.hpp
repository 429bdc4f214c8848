#pragma once

#include <filesystem>
#include <vector>

#include "core/centerline.hpp"

namespace angio {

/// What a reader who knows nothing of the method sees of a tree's lines. Stretches that several
/// paths share are counted once.
struct LineMeasure {
  int points = 0, outside = 0, sharp_steps = 0, sharp_radii = 0;
  int radius_off = 0;  ///< by more than 2 % of the distance to the wall
  int jumps = 0;       ///< radius changes by more than 40 % from a point to the next
  double largest_step = 0.0, largest_radius = 0.0;  ///< turns, degrees
  double too_long = 0.0;                            ///< greatest excess of length, per cent
  std::vector<double> radius_errors;                ///< relative

  [[nodiscard]] double inside_percent() const;
  [[nodiscard]] double radius_off_percent() const;  ///< of the points where it was compared
};

/// Turns are not counted in blanked tracts; radii are compared outside them and further than two
/// radii from the ends, where the lines' wall has a cap.
LineMeasure measure_lines(const CenterlineTree& tree, const std::filesystem::path& case_folder);

}  // namespace angio
