#include "viewer/window/treated_line.hpp"

#include <algorithm>
#include <cmath>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "viewer/detail/report_charts.hpp"
#include "viewer/detail/tables.hpp"

namespace angio::viewer::window {
namespace case_file = formats::case_file;
namespace fs = std::filesystem;

double TreatedLine::start_mm() const {
  return std::isfinite(lesion_mm) ? lesion_mm : 0.5 * length_mm();
}

double TreatedLine::widest_mm(double at_mm) const {
  constexpr double kNearMm = 10.0;
  double widest = 0.0;
  for (std::size_t i = 0; i < abscissa_mm.size(); ++i)
    for (const auto* diameters : {&before, &peak, &after})
      if (i < diameters->size() && std::abs(abscissa_mm[i] - at_mm) < kNearMm &&
          std::isfinite((*diameters)[i]))
        widest = std::max(widest, (*diameters)[i]);
  return widest;
}

TreatedLine read_treated_line(const fs::path& case_folder, const detail::CaseData& data) {
  TreatedLine line;
  if (data.paths.empty()) return line;
  std::error_code ignored;
  int id = data.paths.front().id;
  if (fs::exists(case_folder / case_file::kMetrics, ignored)) {
    const detail::Metrics metrics(read_text(case_folder / case_file::kMetrics));
    const auto lesion = [&](const char* key) {
      return metrics.number("lesion", key).value_or(kUnknown);
    };
    id = int(metrics.number("lesion", "centerline_id").value_or(id));
    line.lesion_mm = lesion("abscissa_mm");
    line.proximal_mm = lesion("proximal_mm");
    line.distal_mm = lesion("distal_mm");
    line.reference_mm = lesion("reference_diameter_mm");
  }
  line.path = data.paths.front();
  for (const CenterlinePath& path : data.paths)
    if (path.id == id) line.path = path;

  const fs::path profile = detail::simulation_folder(case_folder) / "lumen_profile.csv";
  if (fs::exists(profile, ignored)) {
    const TimeSeries table = detail::read_time_series(profile);
    line.abscissa_mm = detail::column(table, "abscissa_mm");
    line.before = detail::column(table, "inscribed_diameter_before_mm");
    line.peak = detail::column(table, "inscribed_diameter_peak_mm");
    line.after = detail::column(table, "inscribed_diameter_after_mm");
  }
  if (line.abscissa_mm.empty()) {
    line.abscissa_mm = line.path.abscissa;
    for (const double radius : line.path.inscribed_radius) line.before.push_back(2.0 * radius);
  }
  return line;
}

}  // namespace angio::viewer::window
