#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "core/volume.hpp"
#include "pipeline/stage_work.hpp"

/// What the files of the stages' work share; the rest of the program includes stage_work.hpp.
namespace angio::pipeline {

inline constexpr const char* kPhantomPrefix = "phantom:";

void do_cloth_stage(Stage stage, StageWork& work);
void do_segmentation(StageWork& work);
void do_centerline(StageWork& work);
void do_meshing(StageWork& work);
void do_simulation(StageWork& work);
void do_report(StageWork& work);

/// Appends to a list of warnings.
void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more);

/// The part of a stage's progress between two fractions. `whole` must outlive it.
Progress part(const Progress& whole, double first, double last);

bool has_surface_input(const StageWork& work);
Volume<float> read_level_set(const StageWork& work);

/// What the report shows of run.json: without the times, so that the same input gives the same one.
nlohmann::json repeatable_run(const StageWork& work);

/// @throws OptionError if no line has that id
const CenterlinePath& path_of(const CenterlineTree& tree, int path_id);

}  // namespace angio::pipeline
