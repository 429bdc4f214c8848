#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "meshing/repair_surface.hpp"
#include "meshing/surface_size.hpp"
#include "pipeline/stages/stage_work.hpp"

/// A lumen surface that the user gives, as an input.
namespace angio::pipeline {

struct GivenSurface {
  TriangleMesh mesh;  ///< repaired [mm]
  std::vector<meshing::SurfaceRepair> repairs;
  meshing::SurfaceSize size;  ///< [mm]
  LengthUnit unit = LengthUnit::mm;
  std::string unit_source;            ///< "option", "file", "size" or "default"
  std::vector<std::string> warnings;  ///< of the unit
};

/// Reads, repairs and measures a surface, and brings it to millimetres: by the unit asked for,
/// otherwise by the one that the file states, otherwise by its size.
///
/// @throws InputError if it cannot be repaired, or no vessel is that small or large
GivenSurface read_given_surface(const std::filesystem::path& file, std::optional<LengthUnit> asked);

/// The segmentation of a case whose input is a surface: it is kept as the later stages read it.
/// @param unit  that it is measured in; unset: as it says, or by its size
void take_surface(StageWork& work, std::optional<LengthUnit> unit);

/// Prints what a surface is like and whether it can be used. @throws InputError if it cannot
void inspect_surface(const std::filesystem::path& file, std::optional<LengthUnit> asked,
                     bool as_json);

}  // namespace angio::pipeline
