#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "pipeline/stages/stage_settings.hpp"
#include "pipeline/stages/stage_work.hpp"

/// The work of each stage, for the table; and what more than one of them needs.
namespace angio::pipeline {

void do_segmentation(StageWork& work, const SegmentationSettings& settings);
void do_centerline(StageWork& work, const CenterlineSettings& settings);
void do_meshing(StageWork& work, const MeshingSettings& settings);
void do_simulation(StageWork& work, const SimulationSettings& settings);
void do_report(StageWork& work, const ReportSettings& settings);

void do_cloth_meshing(StageWork& work, const ClothSettings& settings);
void do_cloth_simulation(StageWork& work, const ClothSettings& settings);
void do_cloth_report(StageWork& work, const ClothSettings& settings);

inline constexpr const char* kLevelSet = "segmentation/lumen_level_set.nrrd";
inline constexpr const char* kGivenSurface = "segmentation/lumen_surface.vtp";
inline constexpr const char* kCenterlines = "centerline/centerlines.vtp";
inline constexpr const char* kNarrowedLumen = "centerline/narrowed_lumen.vtp";
inline constexpr const char* kPlacement = "meshing/placement.json";

/// Appends to a list of warnings.
void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more);

/// The part of a stage's progress between two fractions. `whole` must outlive it.
Progress part(const Progress& whole, double first, double last);

/// Was the case's lumen given as a surface, not found in a volume?
bool has_surface_input(const StageWork& work);
TriangleMesh read_given_surface(const StageWork& work);
Volume<float> read_level_set(const StageWork& work);

/// What the report shows of run.json: without the times, so that the same input gives the same one.
nlohmann::json repeatable_run(const StageWork& work);

/// @throws OptionError if no line has that id
const CenterlinePath& path_of(const CenterlineTree& tree, int path_id);

}  // namespace angio::pipeline
