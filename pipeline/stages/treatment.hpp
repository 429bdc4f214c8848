#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/stages/treated_lumen.hpp"

/// What a treatment has come to, in numbers.
namespace angio::pipeline {

/// The lumen before, at the peak pressure and after deflation, measured in the same way.
struct Treatment {
  TreatedMeasures before, peak, after;

  [[nodiscard]] double gain_mm() const { return after.lesion.mld_mm - before.lesion.mld_mm; }
  /// Of the lumen that the balloon holds open: before and behind contact's gap the same surface.
  [[nodiscard]] double recoil_mm() const { return peak.lesion.mld_mm - after.lesion.mld_mm; }
  /// Of the lumen at the peak.
  [[nodiscard]] double recoil_percent() const { return 100.0 * recoil_mm() / peak.lesion.mld_mm; }
  /// Of what the lumen had gained at the peak.
  [[nodiscard]] double recoil_percent_of_gain() const {
    return 100.0 * recoil_mm() / (peak.lesion.mld_mm - before.lesion.mld_mm);
  }
};

using Stretch = std::array<double, 2>;  ///< first and last abscissa on the treated line [mm]

/// Where the stenoses of lesions.json lie on a line, on others as far as these run along with it.
std::vector<Stretch> lesions_on(const CenterlinePath& path, const nlohmann::json& lesions,
                                const CenterlineTree& tree);

/// Where the balloon widens the vessel most beside the lesion.
struct WideningBeside {
  double ratio = 1.0;
  double abscissa_mm = 0.0, before_mm = 0.0, peak_mm = 0.0;
};

/// The greatest, over the places that are further than a reference diameter from every lesion's
/// edges,
///
///     ratio(s) = D_peak(s) / max(D(s), median of D within a reference diameter of s),
///
/// D the diameter of a circle of the section's area: the median passes over another narrowing.
/// Unset where the balloon reaches nothing beside the lesions.
/// @param lesions  the edges of the treated one and of all others on the line
std::optional<WideningBeside> widening_beside(const centerline::LumenProfile& before,
                                              const centerline::LumenProfile& peak,
                                              const std::vector<Stretch>& lesions,
                                              double reference_mm);

/// A warning where that is over limits::kMostWideningBeside as it is told, in hundredths; else
/// nothing.
/// @param is_lesion  false: a balloon is tried where there is none
std::vector<std::string> widening_warnings(const std::optional<WideningBeside>& widening,
                                           bool is_lesion);

/// What two runs whose starts nobody could tell apart say together.
struct GuardVerdict {
  std::string state;   ///< "off", "agrees", "differs" or "failed"
  std::string reason;  ///< a sentence where it differs or has failed; else empty
};

/// A result is not determined where gain or recoil of the two runs differ by more than a tenth of
/// the larger gain (recoils: or of the larger recoil, if that is more), and by more than 0.02 mm,
/// below which the error of the measure lies.
/// @param second_failure  why there is no second run; empty: there is
GuardVerdict judge(const Treatment& first, const std::optional<Treatment>& second,
                   const std::string& second_failure);

/// metrics.json's lesion (what is measured before), peak and result; the ranges of two runs, null
/// where there is one.
/// @param reference_mm  reference diameter at the lesion
/// @param balloon_mm    the balloon's diameter in the lesion at the peak
nlohmann::json treatment_json(const Treatment& first, const std::optional<Treatment>& second,
                              double reference_mm, double balloon_mm);

/// What is to be said where the lumen that is simulated is narrowed by over ten points more or less
/// than the one that was measured; empty elsewhere.
/// @param measured_percent  diameter stenosis of the lesion as it is listed
std::vector<std::string> start_warnings(const TreatedMeasures& before, double measured_percent,
                                        double reference_mm);

/// What is to be said of the numbers; empty where nothing is.
std::vector<std::string> treatment_warnings(const Treatment& treatment, const GuardVerdict& guard,
                                            const TreatedSpans& spans);

}  // namespace angio::pipeline
