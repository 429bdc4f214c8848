#pragma once

#include <optional>
#include <string>
#include <vector>

#include "viewer/detail/chart.hpp"
#include "viewer/detail/tables.hpp"
#include "viewer/report.hpp"

namespace angio::viewer::detail {

/// The lumen's diameter along the lesion's line, before and after, with the reference diameter and
/// both narrowest places.
Chart diameter_chart(const ReportContent& content, const Metrics& metrics);

/// Fractional flow reserve from the inlet along the lesion's line, before and after, with what
/// limits flow.
Chart flow_chart(const ReportContent& content, const Metrics& metrics);

/// The balloon's diameter in the vessel against its pressure, going up and coming down, beside its
/// chart, with the peak and the rated burst pressure. No series without pressure and diameter.
Chart pressure_diameter_chart(const ReportContent& content, const Metrics& metrics);

/// Pressure, diameters, volume and contacts over time, as far as the columns are there; the phases
/// are marked.
std::vector<Chart> time_charts(const TimeSeries& series);

/// The same of what tells of the solver: penetration and corrections.
std::vector<Chart> solver_charts(const TimeSeries& series);

/// The position corrections by friction and adhesion, the seed paper's Figures 7, 9, 11 and 12.
std::vector<Chart> correction_charts(const TimeSeries& series);

/// Where a profile has the narrowest place before, as it is marked: in the treated stretch, where
/// it comes nearest to the MLD of the metrics [mm]. Nothing without an MLD or a profile.
std::optional<double> mld_place(const DiameterProfile& before, const Metrics& metrics);

/// A column as numbers; what is no number becomes NaN. Empty if there is no such column.
std::vector<double> column(const TimeSeries& series, const std::string& name);

}  // namespace angio::viewer::detail
