#include "viewer/detail/report_charts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/clinical_limits.hpp"
#include "formats/text.hpp"
#include "formats/tokens.hpp"

namespace angio::viewer::detail {
namespace {

std::size_t column_index(const TimeSeries& series, const std::string& name) {
  return std::size_t(std::find(series.columns.begin(), series.columns.end(), name) -
                     series.columns.begin());
}

/// The stretches of equal phase.
std::vector<ChartBand> phase_bands(const TimeSeries& series, const std::vector<double>& time) {
  const std::size_t phase = column_index(series, "phase");
  std::vector<ChartBand> bands;
  if (phase == series.columns.size()) return bands;
  for (std::size_t r = 0; r < series.rows.size(); ++r) {
    if (phase >= series.rows[r].size() || !std::isfinite(time[r])) continue;
    const std::string& name = series.rows[r][phase];
    if (bands.empty() || bands.back().label != name) {
      if (!bands.empty()) bands.back().last = time[r];
      bands.push_back({time[r], time[r], name});
    }
    bands.back().last = time[r];
  }
  return bands;
}

void add_profile(Chart& chart, const DiameterProfile& profile, const std::string& when, int color) {
  if (profile.abscissa_mm.empty()) return;
  chart.series.push_back({when, profile.abscissa_mm, profile.inscribed_diameter_mm, color, false});
  chart.series.push_back({when + ", from the area", profile.abscissa_mm,
                          profile.equivalent_diameter_mm, color, true, false});
  chart.dashed_means = "from the area (else of the inscribed circle)";
}

/// Where the lesion is treated along the line [mm]; everything where it is not told.
struct Stretch {
  double first = -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
};

Stretch treated_stretch(const Metrics& metrics) {
  Stretch lesion;
  lesion.first = metrics.number("lesion", "treated_first_mm").value_or(lesion.first);
  lesion.last = metrics.number("lesion", "treated_last_mm").value_or(lesion.last);
  return lesion;
}

/// Where the profile comes nearest to the number, in the stretch.
std::optional<double> place_of(const DiameterProfile& profile, std::optional<double> mld_mm,
                               const Stretch& lesion) {
  if (!mld_mm) return std::nullopt;
  const auto& diameter = profile.inscribed_diameter_mm;
  const std::size_t count = std::min(diameter.size(), profile.abscissa_mm.size());
  const auto away = [&](std::size_t i) {
    return std::max(
        {lesion.first - profile.abscissa_mm[i], profile.abscissa_mm[i] - lesion.last, 0.0});
  };
  const auto nearer = [&](std::size_t i, std::size_t j) {
    return std::pair(away(i), std::abs(diameter[i] - *mld_mm)) <
           std::pair(away(j), std::abs(diameter[j] - *mld_mm));
  };
  std::size_t place = count;
  for (std::size_t i = 0; i < count; ++i)
    if (std::isfinite(diameter[i]) && (place == count || nearer(i, place))) place = i;
  return place == count ? std::nullopt : std::optional(profile.abscissa_mm[place]);
}

/// The number of the metrics, at the place of the profile that has it.
void add_mld_mark(Chart& chart, const DiameterProfile& profile, std::optional<double> mld_mm,
                  const Stretch& lesion, const std::string& when, int color) {
  if (const auto place = place_of(profile, mld_mm, lesion))
    chart.marks.push_back(
        {*place, *mld_mm, "MLD " + when + " " + formats::fixed_text(*mld_mm, 2) + " mm", color});
}

struct Line {
  const char* column;
  const char* label;
};

/// A chart of the columns that are there; no series if none is.
Chart time_chart(const TimeSeries& series, const std::string& title, const std::string& y_label,
                 const std::vector<Line>& lines) {
  Chart chart;
  chart.title = title;
  chart.x_label = "time [s]";
  chart.y_label = y_label;
  chart.width = 560;
  chart.height = 240;
  const std::vector<double> time = column(series, "time_s");
  if (time.empty()) return chart;
  int color = 1;
  for (const Line& line : lines) {
    const std::vector<double> values = column(series, line.column);
    if (!values.empty()) chart.series.push_back({line.label, time, values, color, false});
    ++color;
  }
  chart.bands = phase_bands(series, time);
  return chart;
}

}  // namespace

std::vector<double> column(const TimeSeries& series, const std::string& name) {
  const std::size_t index = column_index(series, name);
  std::vector<double> values;
  if (index == series.columns.size()) return values;
  for (const auto& row : series.rows) {
    const auto number =
        index < row.size() ? formats::parse_number<double>(row[index]) : std::nullopt;
    values.push_back(number.value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  return values;
}

std::optional<double> mld_place(const DiameterProfile& before, const Metrics& metrics) {
  return place_of(before, metrics.number("lesion", "mld_mm"), treated_stretch(metrics));
}

Chart diameter_chart(const ReportContent& content, const Metrics& metrics) {
  Chart chart;
  chart.title = "Diameter along the vessel";
  chart.x_label = "distance from the inlet [mm]";
  chart.y_label = "diameter [mm]";
  chart.width = 960;
  chart.height = 320;
  add_profile(chart, content.before, "before", 1);
  add_profile(chart, content.after, "after", 2);
  add_profile(chart, content.peak, "at peak", 3);
  const Stretch lesion = treated_stretch(metrics);
  add_mld_mark(chart, content.before, metrics.number("lesion", "mld_mm"), lesion, "before", 1);
  add_mld_mark(chart, content.after, metrics.number("result", "mld_mm"), lesion, "after", 2);
  add_mld_mark(chart, content.peak, metrics.number("peak", "mld_mm"), lesion, "at peak", 3);
  if (const auto reference = metrics.number("lesion", "reference_diameter_mm"))
    chart.levels.push_back({*reference, "reference " + formats::fixed_text(*reference, 2) + " mm"});
  return chart;
}

Chart flow_chart(const ReportContent& content, const Metrics& metrics) {
  Chart chart;
  const bool has_name = is_coronary(metrics);
  chart.title = has_name ? "Fractional flow reserve, pulled back along the vessel"
                         : "Pressure along the vessel over the inlet's";
  chart.x_label = "distance from the inlet [mm]";
  chart.y_label = "pressure / inlet's";
  chart.width = 960;
  chart.height = 320;
  chart.y_from_zero = false;
  const std::vector<double>& place = content.flow_abscissa_mm;
  const auto add = [&](const FlowProfile& flow, const std::string& when, int color) {
    if (flow.ffr.empty()) return;
    chart.series.push_back({when, place, flow.ffr, color, false});
    ChartSeries range{when + ", one standard deviation", place, flow.low, color, true, false};
    chart.dashed_means = "one standard deviation";
    range.x.push_back(std::numeric_limits<double>::quiet_NaN());  // breaks the line
    range.y.push_back(range.x.back());
    range.x.insert(range.x.end(), place.begin(), place.end());
    range.y.insert(range.y.end(), flow.high.begin(), flow.high.end());
    chart.series.push_back(std::move(range));
  };
  add(content.flow_before, "before", 1);
  add(content.flow_after, "after", 2);
  if (place.empty()) return chart;
  if (has_name)
    chart.levels.push_back(
        {limits::kFlowLimitingFfr, "limit " + formats::fixed_text(limits::kFlowLimitingFfr, 2)});
  const auto first = metrics.number("lesion", "proximal_mm"),
             last = metrics.number("lesion", "distal_mm"),
             behind = metrics.number("flow", "behind_mm");
  if (first && last)
    chart.bands = {{place.front(), *first, ""}, {*first, *last, ""}, {*last, place.back(), ""}};
  const auto mark = [&](const char* key, const std::string& when, int color) {
    const auto ffr = metrics.number("flow", key);
    if (ffr && behind)
      chart.marks.push_back(
          {*behind, *ffr,
           (has_name ? "FFR " : "Pd/Pa ") + when + " " + formats::fixed_text(*ffr, 2), color});
  };
  mark("ffr_before", "before", 1);
  mark("ffr_after", "after", 2);
  return chart;
}

Chart pressure_diameter_chart(const ReportContent& content, const Metrics& metrics) {
  Chart chart;
  chart.title = "Pressure and diameter";
  chart.x_label = "pressure above the outside [atm]";
  chart.y_label = "diameter at the lesion [mm]";
  chart.width = 760;
  chart.height = 360;
  const std::vector<double> pressure = column(content.time_series, "pressure_atm"),
                            diameter = column(content.time_series, "balloon_diameter_mm");
  if (pressure.empty() || diameter.empty()) return chart;
  const auto peak = std::size_t(std::max_element(pressure.begin(), pressure.end(),
                                                 [](double a, double b) { return !(a >= b); }) -
                                pressure.begin());
  // The peak is held: the way down begins where it ends.
  std::size_t down = peak;
  while (down + 1 < pressure.size() && pressure[down + 1] == pressure[peak]) ++down;
  const auto part = [](const std::vector<double>& values, std::size_t first, std::size_t last) {
    return std::vector<double>(values.begin() + std::ptrdiff_t(first),
                               values.begin() + std::ptrdiff_t(last + 1));
  };
  chart.series.push_back(
      {"in the vessel, inflating", part(pressure, 0, down), part(diameter, 0, down), 1, false});
  chart.series.push_back({"deflating", part(pressure, down, pressure.size() - 1),
                          part(diameter, down, pressure.size() - 1), 3, false});
  const BalloonChart& alone = content.balloon_chart;
  if (!alone.pressure_atm.empty())
    chart.series.push_back({"alone, by its chart", alone.pressure_atm, alone.diameter_mm, 2, true});
  chart.marks.push_back({pressure[peak], diameter[down],
                         "peak " + formats::fixed_text(pressure[peak], 1) + " atm, " +
                             formats::fixed_text(diameter[down], 2) + " mm",
                         1});
  if (const auto rated = metrics.number("balloon", "rated_burst_atm")) {
    const double top = std::max(*std::max_element(diameter.begin(), diameter.end()),
                                alone.diameter_mm.empty() ? 0.0 : alone.diameter_mm.back());
    chart.series.push_back({"rated burst pressure, " + formats::fixed_text(*rated, 1) + " atm",
                            {*rated, *rated},
                            {0.0, top},
                            4,
                            true});
  }
  return chart;
}

std::vector<Chart> time_charts(const TimeSeries& series) {
  return {time_chart(series, "Balloon pressure", "pressure [atm]", {{"pressure_atm", "pressure"}}),
          time_chart(series, "Diameters", "diameter [mm]",
                     {{"balloon_diameter_mm", "balloon at the lesion"},
                      {"lumen_mld_mm", "minimal lumen diameter"}}),
          time_chart(series, "Balloon volume", "volume [mm³]", {{"balloon_volume_mm3", "volume"}}),
          time_chart(series, "Contacts", "count", {{"contact_count", "contacts"}})};
}

std::vector<Chart> solver_charts(const TimeSeries& series) {
  std::vector<Chart> charts{time_chart(series, "Penetration of the surfaces", "depth [mm]",
                                       {{"max_penetration_mm", "deepest penetration"}})};
  for (Chart& chart : correction_charts(series)) charts.push_back(std::move(chart));
  return charts;
}

std::vector<Chart> correction_charts(const TimeSeries& series) {
  return {time_chart(series, "Corrections by friction", "sum of lengths [mm]",
                     {{"friction_delta_mm", "friction"}}),
          time_chart(series, "Corrections by adhesion", "sum of lengths [mm]",
                     {{"viscous_delta_mm", "adhesion"}})};
}

}  // namespace angio::viewer::detail
