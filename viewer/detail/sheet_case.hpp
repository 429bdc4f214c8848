#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "viewer/report.hpp"

/// A case folder as its contact sheet needs it: whatever is there.
namespace angio::viewer::detail {

/// A stenosis of lesions.json. What could not be measured is not a number.
struct SheetLesion {
  std::string name;  ///< A, B, ... the most severe first
  int path = 0;
  double abscissa_mm = 0.0;
  double mld_mm = 0.0;
  double reference_mm = 0.0;
  double stenosis_percent = 0.0;
  double proximal_mm = 0.0;  ///< abscissas of its edges
  double distal_mm = 0.0;
};

struct SheetCase {
  std::string name;
  std::string input;   ///< kind and size: voxels or triangles
  std::string status;  ///< a word, and why
  std::string times;   ///< seconds by stage
  /// The parts that are there; `moments` holds the peak (or the balloon as placed), `after` the
  /// profile after the dilation.
  ReportContent content;
  std::vector<SheetLesion> lesions;
  std::vector<std::string> notes;  ///< the stages' warnings and errors
  std::string why_nothing;         ///< in words, where there is no lumen
};

/// @param log  what the run printed; may be missing
SheetCase read_sheet_case(const std::filesystem::path& folder, const std::filesystem::path& log);

}  // namespace angio::viewer::detail
