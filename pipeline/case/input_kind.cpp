#include "pipeline/case/input_kind.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "core/error.hpp"
#include "core/legacy_vtk.hpp"
#include "core/text.hpp"
#include "datasets/phantom.hpp"
#include "formats/files.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

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
  if (!fs::is_regular_file(input) && !fs::is_directory(input))
    throw InputError(
        fmt::format("{} is neither a file nor a folder (a pipe or a device cannot be read twice). "
                    "Give a DICOM folder, a volume or a surface",
                    input));
  if (fs::is_directory(input)) return InputKind::volume;
  const std::string extension = lower_extension(input);
  const bool is_surface = extension == ".vtk" ? is_legacy_surface(legacy_vtk_data_set(input))
                                              : formats::is_surface_ending(extension);
  return is_surface ? InputKind::surface : InputKind::volume;
}

const char* name(InputKind kind) {
  constexpr const char* kNames[] = {"volume", "surface", "phantom", "run"};
  return kNames[int(kind)];
}

}  // namespace angio::pipeline
