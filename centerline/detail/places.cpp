#include "centerline/detail/places.hpp"

#include <cmath>
#include <cstddef>

namespace angio::centerline {

std::string in_words(const Vec3& place) {
  const auto mm = [](double value) { return std::to_string(std::lround(value)); };
  return "(" + mm(place.x) + ", " + mm(place.y) + ", " + mm(place.z) + ") mm";
}

std::string at_places(const std::vector<Vec3>& places) {
  constexpr std::size_t kMost = 4;
  const std::size_t named = places.size() > kMost ? kMost - 1 : places.size();
  std::string words = "at ";
  for (std::size_t i = 0; i < named; ++i) {
    if (i > 0) words += i + 1 == places.size() ? " and " : ", ";
    words += in_words(places[i]);
  }
  if (named < places.size())
    words += " and " + std::to_string(places.size() - named) + " other places";
  return words;
}

}  // namespace angio::centerline
