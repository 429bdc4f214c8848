#pragma once

#include <vector>

#include "angiogram/working_view.hpp"

namespace angio::angiogram {

/// A segment and what may hide it, made once for all views.
class SegmentShadow {
 public:
  /// @throws InputError  the line has no such segment
  SegmentShadow(const CenterlineTree& tree, const ViewedSegment& segment);

  /// find_working_view()'s measures.
  [[nodiscard]] SeenSegment seen(const CArmAngles& angles) const;

 private:
  struct Ball {
    Vec3 point;
    double radius = 0.0;
  };
  /// Two balls that follow each other on a line: a tapered piece of another vessel.
  struct Piece {
    Ball a, b;
  };
  [[nodiscard]] double overlap_percent(const CArmAxes& axes) const;
  [[nodiscard]] double throat_mm(const CArmAxes& axes) const;
  void add_pieces(const CenterlineTree& tree, const ViewedSegment& segment);

  std::vector<Ball> segment_;  ///< evenly along it
  std::vector<Piece> others_;
  std::vector<Vec3> throat_;
  Vec3 throat_tangent_;
};

}  // namespace angio::angiogram
