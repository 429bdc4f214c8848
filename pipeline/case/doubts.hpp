#pragma once

#include <string>
#include <string_view>

#include "centerline/centerline.hpp"
#include "core/units.hpp"
#include "pipeline/case/stage.hpp"
#include "segmentation/segmentation.hpp"

/// Which of the stages' warnings are the result's own.
namespace angio::pipeline {

/// How the warning begins that a throat is below what the data show.
inline constexpr std::string_view kUnmeasuredThroat = "the lesion's throat is narrower than";

/// How the warning begins that the vessel beside a stenosis is wider than its reference.
inline constexpr std::string_view kDoubtfulReference = "the reference of the stenosis";

/// How the notes begin of what was mended in a surface.
inline constexpr std::string_view kRepaired = "repaired: ";

/// What the note of a guessed unit says where any other unit makes no sense.
inline constexpr std::string_view kOnlyUnit = "no scan would show it";

/// Whether a note is of what was made of the input, and hardly a doubt: a repair, or the only unit
/// that makes sense.
inline bool is_of_input(const std::string& note) {
  return note.starts_with(kRepaired) ||
         (note.starts_with(kUnitGuessed) && note.find(kOnlyUnit) != std::string::npos);
}

/// Whether a warning is told before those of other things: of the treatment, of a unit that was
/// guessed, of a tree's inlet, of a throat that nobody can measure, of a reference that
/// the vessel beside it contradicts, of a lumen that may be none.
inline bool concerns_result(Stage stage, const std::string& warning) {
  return stage == Stage::simulation || warning.starts_with(kUnitGuessed) ||
         warning.starts_with(kUnmeasuredThroat) || warning.starts_with(kDoubtfulReference) ||
         warning.starts_with(centerline::kUncertainInlet) ||
         warning.starts_with(segmentation::kDoubtfulLumen) ||
         warning.starts_with(segmentation::kOutweighedLumen);
}

}  // namespace angio::pipeline
