#pragma once

#include <string>

#include "viewer/detail/picture.hpp"

namespace angio::test {

/// @param bytes  a whole PNG file of three channels @throws InputError if it is none
viewer::detail::Picture picture_from_png(const std::string& bytes);

}  // namespace angio::test
