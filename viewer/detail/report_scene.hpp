#pragma once

#include <string>

#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// The section with the scene in three dimensions: a button, the scene's program and its data, both
/// packed until it is pressed. Tree, wall, balloon and wire through time, the scan around them, and
/// the diameter curve. Empty without a lumen.
std::string scene_section(const ReportContent& content);

}  // namespace angio::viewer::detail
