#pragma once

#include <vector>

#include "viewer/detail/canvas.hpp"
#include "viewer/detail/sheet_case.hpp"

/// The parts of a contact sheet. An OffscreenDisplay must live for those in 3D.
namespace angio::viewer::detail {

inline constexpr Rgb kSheetInk{30, 34, 42};
inline constexpr Rgb kSheetLesion{200, 20, 30};  ///< and whatever else must not be missed
inline constexpr double kSheetLetters = 9.0;     ///< height of a capital [pixel]
inline constexpr Spot kHeading{8.0, 18.0};       ///< of a part, from its upper left corner

/// The lumen shaded from three sides, squares of one scale; empty without a lumen.
std::vector<Picture> draw_sides_of_surface(const TriangleMesh& lumen, int pixels);

/// The lines in the translucent lumen with inlet, outlets and lesions named. Names that find no
/// room are left out, and how many is told.
Picture draw_named_tree(const SheetCase& sheet, int width, int height);

/// The diameter along the line that is treated, before and after, with its lesions and the healthy
/// diameter there.
Picture draw_diameters(const SheetCase& sheet, int width, int height);

}  // namespace angio::viewer::detail
