#pragma once

#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/detail/view_frame.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// Where the whole tree is looked at from: at its broadest, and of a straight vessel from the side
/// on which the lesion looks narrowest.
ViewFrame tree_frame(const ReportContent& content);

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

/// Where the close-ups look from. @param content  with moments
ViewFrame close_up_frame(const ReportContent& content);

/// The pressure [kPa] that all but a fiftieth of the pressed vertices stay below, at the moment
/// where it is highest: a few sharp corners would otherwise leave one colour to the rest.
double usual_peak(const std::vector<Moment>& moments);

}  // namespace angio::viewer::detail
