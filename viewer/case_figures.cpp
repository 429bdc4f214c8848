#include "viewer/case_figures.hpp"

#include <cmath>
#include <string>

#include "core/atomic_file.hpp"
#include "formats/case_file.hpp"
#include "formats/text.hpp"
#include "viewer/detail/course.hpp"
#include "viewer/detail/drawing_picture.hpp"
#include "viewer/detail/offscreen.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/report_charts.hpp"

namespace angio::viewer {
namespace case_file = formats::case_file;
namespace fs = std::filesystem;
using namespace detail;
namespace {

constexpr int kPlotScale = 2;  // of the PNG beside the SVG

std::vector<Moment> read_sequence(const Course& course) {
  const auto& frames = course.data.frames;
  std::vector<Moment> sequence;
  for (const std::size_t place : sequence_places(frames.size(), course.peak)) {
    const FrameFiles& frame = frames[place];
    Moment moment = read_moment(frame);
    moment.title = std::string("(") + char('a' + int(sequence.size())) + ") " +
                   formats::fixed_text(frame.time_s, 3) + " s";
    const double pressure = value_at(course, frame, "pressure_atm");
    if (std::isfinite(pressure)) moment.title += ", " + formats::fixed_text(pressure, 1) + " atm";
    sequence.push_back(std::move(moment));
  }
  return sequence;
}

DiameterProfile profile_of(const TimeSeries& table, const std::string& when) {
  DiameterProfile profile{column(table, "abscissa_mm"),
                          column(table, "inscribed_diameter_" + when + "_mm"),
                          column(table, "equivalent_diameter_" + when + "_mm")};
  if (profile.inscribed_diameter_mm.empty()) profile.abscissa_mm.clear();
  return profile;
}

/// The diameter along the path, as far as there are profiles.
Chart make_diameter_chart(const fs::path& case_folder, ReportContent& content) {
  std::error_code ignored;
  if (const fs::path file = case_folder / case_file::kProfile; fs::exists(file, ignored)) {
    const TimeSeries table = read_time_series(file);
    content.before = profile_of(table, "before");
    content.peak = profile_of(table, "peak");
    content.after = profile_of(table, "after");
  }
  const fs::path metrics = case_folder / case_file::kMetrics;
  return diameter_chart(content, Metrics(fs::exists(metrics, ignored) ? read_text(metrics) : ""));
}

/// NAME.svg and NAME.png; nothing where all charts are empty.
void write_plots(const fs::path& folder, const std::string& name, const std::vector<Chart>& charts,
                 std::vector<fs::path>& written) {
  const std::string text = svg_file(charts);
  if (text.empty()) return;
  for (const auto& [ending, bytes] :
       {std::pair{".svg", text}, std::pair{".png", png_bytes(drawing_picture(text, kPlotScale))}}) {
    written.push_back(folder / (name + ending));
    write_text_atomically(written.back(), bytes);
  }
}

}  // namespace

std::vector<fs::path> write_case_figures(const fs::path& case_folder, const fs::path& folder,
                                         const Progress& progress) {
  Course course = read_course(case_folder);
  ReportContent& content = course.content;
  content.sequence = read_sequence(course);
  const OffscreenDisplay display;
  progress.report(0.1, "nine moments");
  std::vector<fs::path> written{folder / "moments.png"};
  write_text_atomically(written.back(), png_bytes(draw_sequence(content).front().picture));
  progress.report(0.8, "plots");
  write_plots(folder, "diameter", {make_diameter_chart(case_folder, content)}, written);
  std::vector<Chart> course_charts = time_charts(content.time_series);
  course_charts.resize(2);  // pressure, diameters
  write_plots(folder, "course", course_charts, written);
  progress.report(1.0);
  return written;
}

}  // namespace angio::viewer
