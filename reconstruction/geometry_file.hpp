#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "angiogram/cone_beam.hpp"

namespace angio::reconstruction {

/// Frames as RTK's ThreeDCircularProjectionGeometry, version 3, so that `rtkfdk` reconstructs from
/// them: nine numbers and a 3 x 4 matrix a frame.
///
/// RTK turns around its y axis: its x, y, z are our x, z, -y (LPS). Its matrices give mm on the
/// detector: the stack of frames has the origin (-(columns - 1) / 2 column spacing, -(rows - 1) / 2
/// row spacing), the middle of the picture.
///
/// @param frames  with detectors at right angles; others get a matrix that their numbers only
///                come near to
std::string rtk_geometry(const std::vector<angiogram::ConeBeamFrame>& frames);

/// The frames' pixels on the detector, columns before rows.
struct DetectorPixels {
  std::array<int, 2> count{};
  std::array<double, 2> spacing_mm{};  ///< 0: not known
  /// Of the first one's middle, in the millimetres of RTK's matrices; none: half of the others to
  /// each side of zero.
  std::optional<std::array<double, 2>> first_mm = {};
};

/// The frames of a geometry file: rtk_geometry()'s XML, by its matrices, or a CSV of 3 x 4 matrices
/// from (x, y, z, 1) in LPS [mm] to (column, row, 1), pixels from 0: twelve numbers a line, rows
/// first; lines that begin with # or hold words are left out.
///
/// @throws InputError  naming the file and the line or frame: what is wrong; 66 if it is missing;
///                     RTK's, and the pixels' spacing is not known
std::vector<angiogram::ConeBeamFrame> read_geometry(const std::filesystem::path& file,
                                                    const DetectorPixels& pixels);

}  // namespace angio::reconstruction
