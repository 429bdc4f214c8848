#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace angio::viewer {

/// A measure against a setting, for one choice of the other settings.
struct SweepCurve {
  std::string label;         ///< the other settings; empty: there are none
  std::vector<double> x, y;  ///< shape [variant]; NaN where there is no result
};

/// One measure.
struct SweepPanel {
  std::string measure;  ///< with its unit
  std::vector<SweepCurve> curves;
  std::optional<double> limit = {};  ///< drawn across
};

/// Writes an SVG file of a chart a measure, below each other, atomically; measures with fewer than
/// two results are left out.
/// @return whether there was anything to draw; otherwise nothing is written
bool write_sweep_plot(const std::filesystem::path& path, const std::string& setting,
                      const std::vector<SweepPanel>& panels);

}  // namespace angio::viewer
