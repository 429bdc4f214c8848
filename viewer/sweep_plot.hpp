#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace angio::viewer {

/// A measure against a setting, for one choice of the other settings.
struct SweepCurve {
  std::string label;         ///< the other settings; empty: there are none
  std::vector<double> x, y;  ///< shape [variant], x ascending; y NaN where there is no result
};

/// One measure.
struct SweepPanel {
  std::string measure;  ///< with its unit
  std::vector<SweepCurve> curves;
  std::optional<double> limit = {};  ///< drawn across
};

/// Writes an SVG file of a chart a measure, below each other, atomically; measures with fewer than
/// two results are left out. The ticks of x stand where there are results.
///
/// @param setting  what x is, with its unit
/// @param notes    lines below the charts
/// @return whether there was anything to draw; otherwise nothing is written
bool write_sweep_plot(const std::filesystem::path& path, const std::string& setting,
                      const std::vector<SweepPanel>& panels,
                      const std::vector<std::string>& notes = {});

}  // namespace angio::viewer
