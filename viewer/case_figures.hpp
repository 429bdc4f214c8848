#pragma once

#include <filesystem>
#include <vector>

#include "core/progress.hpp"

namespace angio::viewer {

/// Writes a case's pictures for a paper into a folder, each atomically:
/// moments.png, nine moments of the simulation in rows of three, of one view and one scale of
/// colours, each with time [s] and pressure [atm]; diameter.svg and .png, the diameter along the
/// path before, at peak and after; course.svg and .png, pressure and diameters over time. A plot
/// whose table is missing (a simulation that failed has no profile) is left out.
///
/// @return the files, in that order
/// @throws Error (69) if nothing can render here, InputError (66) if the case has no simulation
std::vector<std::filesystem::path> write_case_figures(const std::filesystem::path& case_folder,
                                                      const std::filesystem::path& folder,
                                                      const Progress& progress = {});

}  // namespace angio::viewer
