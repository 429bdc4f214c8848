#pragma once

#include <cstddef>
#include <vector>

#include "angiogram/c_arm.hpp"
#include "core/centerline.hpp"

namespace angio::angiogram {

struct WorkingViewOptions {
  /// To both sides, [0, 180]. Our assumption: up to the lateral view, 90.
  double primary_limit_degrees = 90.0;
  /// To head and feet, [0, 90]. Our assumption: further the detector meets chest or table, 40.
  double secondary_limit_degrees = 40.0;
  /// How many per cent of foreshortening a per cent of overlap is as bad as, [0, 100].
  double overlap_weight = 1.0;
  /// Of the second view from the first, [0, 90]: two views of one stenosis are wanted that far
  /// apart. Our assumption.
  double second_view_degrees = 45.0;

  void validate() const;  ///< @throws OptionError naming the field
};

/// A stretch of one of a tree's lines: the vessel that is to be seen.
struct ViewedSegment {
  std::size_t path = 0;                  ///< index in the tree
  double first_mm = 0.0, last_mm = 0.0;  ///< abscissas, first_mm < last_mm
  std::vector<Vec3> throat =
      {};                    ///< points of the wall round its narrowest section; empty: not known
  Vec3 throat_tangent = {};  ///< of the line there, unit
};

/// What a view shows of the segment.
struct SeenSegment {
  CArmAngles angles;
  double foreshortening_percent = 0.0;  ///< [0, 100]
  double overlap_percent = 0.0;         ///< [0, 100]
  double throat_mm = 0.0;               ///< how wide the throat looks; 0: not known
};

/// Views by their angles, on a grid within the limits.
struct ViewMap {
  std::vector<double> primary_degrees, secondary_degrees;  ///< ascending
  std::vector<SeenSegment> views;                          ///< shape [secondary][primary]
};

struct WorkingView {
  SeenSegment best;
  SeenSegment second;  ///< the best of those far enough from the first, where there is one
  bool has_second = false;
  ViewMap map;
};

/// The view in which a vessel's segment is least foreshortened and least hidden by other vessels.
///
///     foreshortening = 100 (1 - sum |dx - (dx . b) b| / sum |dx|),    b: along the beam
///     overlap        = 100 (points of the segment in other vessels' shadow) / (points)
///     cost           = foreshortening + overlap_weight overlap
///
/// Sources: Chen, Carroll, IEEE Trans. Med. Imaging 19(4), 2000, 318-336 (both measures, in a map
/// of the angles); what is reached in coronaries: foreshortening 6 +- 4 %, overlap 5 to 9 % (Garcia
/// et al., Int. J. Cardiovasc. Imaging 25(5), 2009). Of views within 0.5 of the least cost, which
/// nobody tells apart, those are taken in which the throat looks narrowest, to 5 % (an eccentric
/// stenosis is hidden in the others), and of these the one nearest to the front: our rules. Angles
/// are whole degrees.
///
/// Rays are taken as parallel: a C-arm's, from 1 m, differ by 1.5 degrees at 25 mm from its centre.
/// Points stand evenly along the segment, five across its diameter. "Other vessels" are balls along
/// the tree's lines, of the measured radius, but for those joined with the segment within its
/// widest radius and their own: there the shadows meet in every view. A place that the line runs
/// through again, further off, counts.
///
/// @param segment  not empty; beyond the line's ends it is cut off
/// @throws InputError  the line has no such segment
/// @throws OptionError
WorkingView find_working_view(const CenterlineTree& tree, const ViewedSegment& segment,
                              const WorkingViewOptions& options);

/// One view of the same, whatever the limits.
SeenSegment judge_view(const CenterlineTree& tree, const ViewedSegment& segment,
                       const CArmAngles& angles);

}  // namespace angio::angiogram
