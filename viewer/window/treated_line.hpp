#pragma once

#include <filesystem>
#include <limits>
#include <vector>

#include "core/centerline.hpp"
#include "viewer/detail/case_data.hpp"

namespace angio::viewer::window {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The line that the section walks along, and the diameters that the curve shows.
struct TreatedLine {
  CenterlinePath path;  ///< without points where the case has no lines
  double lesion_mm = kUnknown, proximal_mm = kUnknown, distal_mm = kUnknown;  ///< abscissas
  double reference_mm = kUnknown;                                             ///< diameter
  std::vector<double> abscissa_mm;          ///< shape [section]; of the curves
  std::vector<double> before, peak, after;  ///< inscribed diameters [mm], NaN where not measured;
                                            ///< peak and after empty before the simulation is done
  [[nodiscard]] bool exists() const { return path.points.size() > 1; }
  [[nodiscard]] double length_mm() const { return exists() ? path.abscissa.back() : 0.0; }
  /// The widest of all diameters known within 10 mm [mm]; 0 without any.
  [[nodiscard]] double widest_mm(double at_mm) const;
  /// Where to begin: the lesion; without one, the middle of the line.
  [[nodiscard]] double start_mm() const;
};

/// Reads metrics.json and lumen_profile.csv as far as they are there; without a profile the
/// diameters are those of the centreline's inscribed balls.
TreatedLine read_treated_line(const std::filesystem::path& case_folder,
                              const detail::CaseData& data);

}  // namespace angio::viewer::window
