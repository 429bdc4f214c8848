#pragma once

#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/report.hpp"

/// Pictures drawn with OpenCV; they need no display.
namespace angio::viewer::detail {

/// Maximum intensity projections along the patient's three axes, with the lumen's outline. Empty
/// without a volume.
std::vector<Figure> draw_projections(const ReportContent& content);

/// Axial, coronal and sagittal slice through the lesion with the lumen's contour. Empty without a
/// volume.
std::vector<Figure> draw_slices(const ReportContent& content);

/// One sheet of cross-sections at right angles to the vessel, from before to behind the lesion,
/// with the contours before and after. Without a volume, contours alone.
std::vector<Figure> draw_contact_sheet(const ReportContent& content);

}  // namespace angio::viewer::detail
