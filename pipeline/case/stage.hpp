#pragma once

#include <string_view>

namespace angio::pipeline {

/// The stages, in the order in which they run (stages/stage_table.cpp).
enum class Stage { reconstruction, segmentation, centerline, meshing, simulation, report };
inline constexpr int kStageCount = 6;

/// As in --from, --until, run.json and the case's folders.
const char* name(Stage stage);
/// @throws Error (64) naming the nearest stage
Stage parse_stage(std::string_view text);

}  // namespace angio::pipeline
