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
