#pragma once

#include <filesystem>
#include <string>

#include "formats/files.hpp"

namespace angio::formats {

/// The moment that a frame of a simulation is of.
struct FrameMoment {
  double time_s = 0.0;
  double pressure_atm = 0.0;  ///< above the outside
  std::string phase;          ///< "inflate"
};

/// Writes a frame's surface as .vtp, as write_surface does, with the moment as field data: the
/// arrays `time_s`, `pressure_atm` and `phase`, of one value each.
void write_frame_surface(const std::filesystem::path& path, const SurfaceData& data,
                         const FrameMoment& moment);

/// The other way. @throws InputError if the file has no such field data
FrameMoment read_frame_moment(const std::filesystem::path& path);

}  // namespace angio::formats
