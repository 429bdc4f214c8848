#pragma once

#include <vector>

#include "viewer/detail/figure.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// The virtual angiograms, in the order given: dark vessels on a light ground, titled with their
/// angles, all on one scale of grey.
std::vector<Figure> draw_angiograms(const ReportContent& content);

}  // namespace angio::viewer::detail
