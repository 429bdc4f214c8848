#pragma once

#include <filesystem>
#include <string>

#include "formats/files.hpp"

namespace angio::formats::detail {

/// Points with the same coordinates become one, in order of first appearance; triangles that lose
/// a corner by it are dropped with their cell values. Point arrays keep the first point's values.
SurfaceData merge_equal_points(SurfaceData data);

/// Throws InputError unless every point is finite, every triangle names existing points, and there
/// is at least one triangle. @param name  of the file, for the message
void require_usable(const SurfaceData& data, const std::string& name);

/// Throws InputError if a point is not finite. @param name  of the file
void require_finite(const std::vector<Vec3>& points, const std::string& name);

/// Converts RAS to LPS [mm] or back. Orientation is kept (a half turn). Arrays stay as they are.
void swap_ras_lps(std::vector<Vec3>& points);

/// @throws InputError (66) if it is not there, (65) if it is no file or empty; IoError if it cannot
/// be opened
void require_input(const std::filesystem::path& path);

/// The whole file. @throws as require_input()
std::string read_input(const std::filesystem::path& path);

}  // namespace angio::formats::detail
