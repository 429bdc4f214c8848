#pragma once

#include <string>
#include <vector>

#include "core/vec3.hpp"

namespace angio::centerline {

/// "(12, -3, 40) mm"
std::string in_words(const Vec3& place);

/// "at A", "at A and B", "at A, B, C and 12 other places": one note for all places of a kind.
std::string at_places(const std::vector<Vec3>& places);

}  // namespace angio::centerline
