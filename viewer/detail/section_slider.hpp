#pragma once

#include <string>
#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/detail/tables.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// Sections at right angles to the treated line over the scan, with the lumen's contours before, at
/// peak and after: the one where the MLD before is marked, and a slider that a script shows. Empty
/// without a line or a lumen.
std::string section_slider(const ReportContent& content, const Metrics& metrics);

/// The scan along the treated line as if that were straight (curved planar reformation), in two
/// planes at right angles to each other, with the lumen's edges before and after. Without a scan,
/// the edges alone. Empty without a line or a lumen.
std::vector<Figure> draw_straightened(const ReportContent& content);

}  // namespace angio::viewer::detail
