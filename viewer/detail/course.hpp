#pragma once

#include <filesystem>
#include <string>

#include "viewer/detail/case_data.hpp"
#include "viewer/detail/view_frame.hpp"
#include "viewer/report.hpp"

/// The simulation of a finished case, for films and figures.
namespace angio::viewer::detail {

struct Course {
  CaseData data;          ///< at least one frame
  ReportContent content;  ///< lumen, lines, lesion; moments: first frame, peak, last frame
  std::size_t peak = 0;   ///< its place in data.frames
};

/// @throws InputError (66) if the folder is no case, or has no simulation
Course read_course(const std::filesystem::path& case_folder);

/// What a frame's files hold; without a title.
Moment read_moment(const FrameFiles& files);

/// A number of the time series at a frame; NaN where it has none.
double value_at(const Course& course, const FrameFiles& files, const std::string& column);

/// The report's view, close on the balloon: as wide as the balloon in any of the three moments and
/// a quarter more, as high as the wall beside it.
ViewFrame balloon_frame(const ReportContent& content);

}  // namespace angio::viewer::detail
