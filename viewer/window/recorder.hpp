#pragma once

#include <vtkRenderWindow.h>

#include <filesystem>
#include <functional>

#include "viewer/detail/picture.hpp"

namespace angio::viewer::window {

/// What the window shows, drawn again.
detail::Picture grab(vtkRenderWindow* window);

/// Writes what the window shows as PNG, atomically.
void save_picture(vtkRenderWindow* window, const std::filesystem::path& png);

/// Writes a film by VTK's Theora writer, atomically.
/// @param picture_count      > 0
/// @param pictures_per_second  [1/s], > 0
/// @param draw  makes the window show the picture of that number. @return false if it is the one
///              before, which is then written again, not drawn
void save_film(vtkRenderWindow* window, const std::filesystem::path& ogv, int picture_count,
               int pictures_per_second, const std::function<bool(int)>& draw);

/// FOLDER/STEM_NNN.EXTENSION with the least number that is free, from 1.
std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& stem,
                                const std::string& extension);

}  // namespace angio::viewer::window
