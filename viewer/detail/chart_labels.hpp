#pragma once

#include <array>
#include <vector>

namespace angio::viewer::detail {

/// Where a label stands [px], from a chart's upper left corner.
struct LabelPlace {
  enum class Anchor { start, middle, end };
  double x = 0, y = 0;  ///< of the words' baseline
  Anchor anchor = Anchor::start;
  double cost = 0;  ///< of choosing it: as much as so many points of a curve under the words
};

/// A part of a chart [px].
struct LabelBox {
  double left = 0, right = 0, top = 0, bottom = 0;
};

/// @param width  of the words [px]
LabelBox box_of(const LabelPlace& place, double width);

/// From the box to a point [px]; 0 inside.
double distance_to(const LabelBox& box, double x, double y);

/// Finds places for a chart's labels: inside, off each other, and off the curves as far as can be.
class ChartLabels {
 public:
  explicit ChartLabels(const LabelBox& area) : area_(area) {}

  /// Nothing should be written across this line. @param points  (x, y) [px]; not finite: a gap
  void keep_off(const std::vector<std::array<double, 2>>& points);

  /// Of the places that lie inside and on no other label the one with the least cost and curves
  /// under its words (a point of a curve each 3 px); the last place where there is none. The label
  /// is then there.
  /// @param wanted  the dearest first; at least one
  /// @param width   of the words [px]
  LabelPlace place(const std::vector<LabelPlace>& wanted, double width);

 private:
  std::vector<std::array<double, 2>> lines_;  ///< points of them, close to each other
  std::vector<LabelBox> taken_;
  LabelBox area_;
};

}  // namespace angio::viewer::detail
