#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "angiogram/cone_beam.hpp"

namespace angio::reconstruction {

/// Frames as RTK's ThreeDCircularProjectionGeometry, version 3, so that `rtkfdk` reconstructs from
/// them: nine numbers and a 3 x 4 matrix a frame.
///
/// RTK turns around its y axis: its x, y, z are our x, z, -y (LPS). Its matrices give mm on the
/// detector, from the middle of the picture: the stack of frames has the origin
/// (-(columns - 1) / 2 column spacing, -(rows - 1) / 2 row spacing).
///
/// @param frames  with detectors at right angles; others get a matrix that their numbers only
///                come near to
std::string rtk_geometry(const std::vector<angiogram::ConeBeamFrame>& frames);

/// The frames of a geometry file: rtk_geometry()'s XML, by its matrices, or a CSV of 3 x 4 matrices
/// from (x, y, z, 1) in LPS [mm] to (column, row, 1), pixels from 0: twelve numbers a line, rows
/// first; lines that begin with # or hold words are left out.
///
/// @param column_spacing_mm, row_spacing_mm  of the frames' pixels on the detector
/// @throws InputError  naming the file and the line or frame: what is wrong; 66 if it is missing
std::vector<angiogram::ConeBeamFrame> read_geometry(const std::filesystem::path& file, int columns,
                                                    int rows, double column_spacing_mm,
                                                    double row_spacing_mm);

}  // namespace angio::reconstruction
