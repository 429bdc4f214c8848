#pragma once

#include <filesystem>

#include "core/progress.hpp"

namespace angio::viewer {

struct FilmOptions {
  int width = 1280;              ///< [pixel], even, 160 to 3840
  int height = 720;              ///< [pixel], even, 120 to 2160
  int pictures_per_second = 25;  ///< [1/s], 1 to 60

  /// @throws OptionError naming what is out of range
  void validate() const;
};

/// Writes a case's simulation as a film in real time: the balloon in its vessel from the report's
/// view, close on the balloon, the wall coloured by contact pressure, with time [s], pressure [atm]
/// and minimal lumen diameter [mm] written in. Each picture shows the written frame that is nearest
/// in time; the film lasts as long as the simulation.
///
/// @param film  .mp4 (H.264, else MPEG-4), .avi (motion JPEG) or .ogv (Theora); written atomically
/// @return the number of pictures, floor(duration * pictures_per_second) + 1
/// @throws Error (64) for another ending, (69) if nothing can render or encode here, InputError
/// (66)
///         if the case has no simulation
int write_film(const std::filesystem::path& case_folder, const std::filesystem::path& film,
               const FilmOptions& options, const Progress& progress = {});

}  // namespace angio::viewer
