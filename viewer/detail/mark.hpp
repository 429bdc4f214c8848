#pragma once

namespace angio::viewer::detail {

/// A mark to be drawn over a picture; lengths in pixels, from the picture's lower left corner.
struct MarkRequest {
  double x = 0.0, y = 0.0;                       ///< what is marked
  double radius = 0.0;                           ///< of the ring, as large as wanted, >= 0
  double label_width = 0.0, label_height = 0.0;  ///< of its words
  double gap = 0.0;                              ///< between ring and words
  double picture_width = 1.0, picture_height = 1.0;
};

struct MarkLayout {
  double radius = 0.0;
  double label_left = 0.0, label_bottom = 0.0;
};

/// The ring as wide as wanted, but at most a sixth of the picture's shorter side, so that a vessel
/// of few diameters shows around it. The words stand beside it, on the side with more room; where
/// they fit on neither, above or below it. They lie within the picture and off the ring if the
/// picture is large enough for that.
MarkLayout lay_out_mark(const MarkRequest& request);

}  // namespace angio::viewer::detail
