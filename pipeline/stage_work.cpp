#include "pipeline/stage_work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "core/error.hpp"
#include "datasets/phantom.hpp"
#include "pipeline/experiment.hpp"
#include "pipeline/stage_parts.hpp"
#include "pipeline/version.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

void keep(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

/// The part of a stage's progress between two fractions.
Progress part(const Progress& whole, double first, double last) {
  return Progress([&whole, first, last](double fraction, std::string_view step) {
    whole.report(first + (last - first) * fraction, step);
  });
}

bool has_surface_input(const StageWork& work) {
  return work.record.input_kind == name(InputKind::surface);
}

Volume<float> read_level_set(const StageWork& work) {
  return segmentation::read_volume_file(work.case_folder.path("segmentation/lumen_level_set.nrrd"));
}

nlohmann::json repeatable_run(const StageWork& work) {
  return {{"version", kVersion},
          {"backend", work.record.backend},
          {"device", work.record.device},
          {"input", work.record.input_description},
          {"input_sha256", work.record.input_sha256}};
}

const CenterlinePath& path_of(const CenterlineTree& tree, int path_id) {
  const auto found = std::find_if(tree.paths.begin(), tree.paths.end(),
                                  [&](const CenterlinePath& path) { return path.id == path_id; });
  if (found == tree.paths.end())
    throw OptionError(
        fmt::format("lesion.centerline = {} is not in this case (it has {} lines, "
                    "numbered from 0)",
                    path_id, tree.paths.size()));
  return *found;
}

std::vector<std::string> stage_inputs(Stage stage) {
  switch (stage) {
    case Stage::segmentation:
      return {};
    case Stage::centerline:
      return {"segmentation/lumen_level_set.nrrd", "segmentation/lumen_surface.vtp"};
    case Stage::meshing:
      return {"segmentation/volume.nrrd", "segmentation/lumen_level_set.nrrd",
              "segmentation/lumen_surface.vtp", "centerline/centerlines.vtp",
              "centerline/narrowed_lumen.vtp"};
    case Stage::simulation:
      return {"centerline/centerlines.vtp", "meshing/lumen.vtp",  "meshing/balloon.vtp",
              "meshing/guidewire.vtp",      "meshing/region.vtp", "meshing/air.vtu",
              "meshing/placement.json",     "meshing/cloth.vtp"};
    case Stage::report:
      return {"segmentation/volume.nrrd",
              "segmentation/lumen_level_set.nrrd",
              "centerline/centerlines.vtp",
              "centerline/lesions.json",
              "meshing/lumen.vtp",
              "meshing/placement.json",
              "simulation/simulation.pvd",
              "simulation/timeseries.csv",
              "simulation/lumen_profile.csv",
              "simulation/summary.json",
              "simulation/diagnosis.json"};
  }
  throw InternalError("no such stage");
}

void do_cloth_stage(Stage stage, StageWork& work) {
  if (stage == Stage::meshing) return do_cloth_meshing(work);
  if (stage == Stage::simulation) return do_cloth_simulation(work);
  do_cloth_report(work);
}

void do_stage(Stage stage, StageWork& work) {
  if (is_cloth(work.config)) return do_cloth_stage(stage, work);
  switch (stage) {
    case Stage::segmentation:
      return do_segmentation(work);
    case Stage::centerline:
      return do_centerline(work);
    case Stage::meshing:
      return do_meshing(work);
    case Stage::simulation:
      return do_simulation(work);
    case Stage::report:
      return do_report(work);
  }
}

InputKind input_kind(const std::string& input) {
  if (input.starts_with(kPhantomPrefix)) {
    try {
      datasets::parse_phantom(input);
    } catch (const OptionError& error) {  // on the command line, not in a configuration
      throw Error(ExitCode::usage, error.what());
    }
    return InputKind::phantom;
  }
  if (!fs::exists(input))
    throw InputError(fmt::format("there is no {} (no such file or folder). Check the path", input),
                     ExitCode::no_input);
  std::string extension = fs::path(input).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  const std::set<std::string> surfaces = {".stl", ".vtp", ".ply", ".obj"};
  return surfaces.contains(extension) && !fs::is_directory(input) ? InputKind::surface
                                                                  : InputKind::volume;
}

const char* name(InputKind kind) {
  constexpr const char* kNames[] = {"volume", "surface", "phantom"};
  return kNames[int(kind)];
}

}  // namespace angio::pipeline
