#include "centerline/detail/places.hpp"

#include <cmath>

#include "core/text.hpp"

namespace angio::centerline {

std::string in_words(const Vec3& place) {
  const auto mm = [](double value) { return std::to_string(std::lround(value)); };
  return "(" + mm(place.x) + ", " + mm(place.y) + ", " + mm(place.z) + ") mm";
}

std::string at_places(const std::vector<Vec3>& places) {
  std::vector<std::string> words;
  for (const Vec3& place : places) words.push_back(in_words(place));
  return "at " + list_a_few(words, "places");
}

}  // namespace angio::centerline
