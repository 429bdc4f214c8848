#pragma once

#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// The whole vessel tree with the lesion ringed. An OffscreenDisplay must live for these.
Figure draw_tree(const ReportContent& content);

/// Every moment from the same place: the balloon inside the translucent wall.
std::vector<Figure> draw_moments(const ReportContent& content);

/// The whole course in one picture, as the seed paper's Figures 1, 6, 8 and 10: the balloon inside
/// the translucent wall, which is coloured by contact pressure. Empty if there is no sequence.
std::vector<Figure> draw_sequence(const ReportContent& content);

/// The wall coloured by contact pressure at the moment where it is highest; empty if nothing
/// touches.
std::vector<Figure> draw_contact(const ReportContent& content);

}  // namespace angio::viewer::detail
