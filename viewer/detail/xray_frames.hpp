#pragma once

#include <string>
#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// Frames of the run, dark where the beam is weakened, with the outline of the lumen as each of
/// them sees it. What is broader than vessels is taken out where no mask was subtracted:
///
///     p - G * p,    G: a Gaussian of an eighth of the picture's shorter side
///
/// Empty without frames.
std::vector<Figure> draw_xray_frames(const ReportContent& content);

/// The file of a frame's picture. @param number  from 1
std::string xray_file(int number);

/// Pictures of one size side by side, four in a row, each with its caption.
Picture sheet_of(const std::vector<Figure>& figures);

}  // namespace angio::viewer::detail
