#include "pipeline/stages/stage_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/text.hpp"
#include "datasets/phantom.hpp"
#include "formats/files.hpp"
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

bool has_surface_input(const StageWork& work) { return work.files.exists(kGivenSurface); }

TriangleMesh read_given_surface(const StageWork& work) {
  return formats::read_surface(work.files.path(kGivenSurface)).mesh;
}

Volume<float> read_level_set(const StageWork& work) {
  return segmentation::read_volume_file(work.files.path(kLevelSet));
}

nlohmann::json repeatable_run(const StageWork& work) {
  return {{"version", kVersion},
          {"backend", work.run.backend},
          {"device", work.run.device},
          {"input", work.run.input_description},
          {"input_sha256", work.run.input_sha256}};
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
  const std::string extension = lower_extension(input);
  const std::set<std::string> surfaces = {".stl", ".vtp", ".ply", ".obj"};
  return surfaces.contains(extension) && !fs::is_directory(input) ? InputKind::surface
                                                                  : InputKind::volume;
}

const char* name(InputKind kind) {
  constexpr const char* kNames[] = {"volume", "surface", "phantom"};
  return kNames[int(kind)];
}

}  // namespace angio::pipeline
