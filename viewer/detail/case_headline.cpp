#include "viewer/detail/case_headline.hpp"

#include <cctype>
#include <cmath>
#include <optional>

#include "formats/text.hpp"

namespace angio::viewer::detail {
namespace {

std::string kind_words(const std::string& input_kind) {
  if (input_kind == "volume") return "Scan: ";
  if (input_kind == "surface") return "Surface: ";
  if (input_kind == "phantom") return "Phantom: ";
  if (input_kind == "run") return "X-ray frames: ";
  return {};
}

}  // namespace

std::string length_text(double length_mm) {
  return formats::number_text(std::round(10.0 * length_mm) / 10.0);
}

namespace {

/// "3.00 × 12 mm balloon"; empty: none was placed.
std::string balloon_words(const Metrics& metrics) {
  const auto diameter = metrics.number("balloon", "nominal_diameter_mm"),
             length = metrics.number("balloon", "length_mm");
  if (!diameter || !length) return {};
  return formats::fixed_text(*diameter, 2) + " × " + length_text(*length) + " mm balloon";
}

/// "stenosis of 60 % on line 1, 29 mm from the inlet"; empty: the metrics tell of none.
std::string lesion_words(const Metrics& metrics) {
  const auto least = metrics.number("lesion", "stenosis_at_least_percent"),
             percent = metrics.number("lesion", "diameter_stenosis_percent"),
             line = metrics.number("lesion", "centerline_id"),
             place = metrics.number("lesion", "abscissa_mm");
  if (!least && !percent) return {};
  const std::string size =
      least ? "at least " + formats::fixed_text(*least, 0) : formats::fixed_text(*percent, 0);
  return "stenosis of " + size + " %" +
         (line ? " on line " + formats::fixed_text(*line, 0) : std::string()) +
         (place ? ", " + formats::fixed_text(*place, 0) + " mm from the inlet" : std::string());
}

}  // namespace

std::string case_headline(const Metrics& metrics, const std::string& input_kind) {
  const std::string balloon = balloon_words(metrics);
  std::string words;
  if (metrics.text("status") == "no_lesion") {
    words = "no certain stenosis" + (balloon.empty() ? "" : ", trial of a " + balloon);
  } else {
    words = lesion_words(metrics);
    if (words.empty()) return {};
    if (!balloon.empty()) words += ", " + balloon;
  }
  words = kind_words(input_kind) + words;
  words[0] = char(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

}  // namespace angio::viewer::detail
