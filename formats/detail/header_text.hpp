#pragma once

#include <optional>
#include <string_view>

#include "core/units.hpp"

/// What the free text of a surface file's header says.
namespace angio::formats::detail {

/// Whether its points are in RAS ("SPACE=RAS", as 3D Slicer writes).
bool says_ras(std::string_view header);

/// What its coordinates are measured in: "unit=mm", "Units: cm", "File units = meters", ...
/// "SPACE=" means mm: patient space is in millimetres, here and in 3D Slicer.
///
/// @return nothing if it does not say, or names a unit that is none of ours
std::optional<LengthUnit> stated_unit(std::string_view header);

/// A unit by its name in any case, singular or plural: "mm", "Millimetres", "inches".
std::optional<LengthUnit> unit_of_name(std::string_view name);

}  // namespace angio::formats::detail
