#include "formats/checked_arrays.hpp"

#include <array>
#include <charconv>

#include "core/error.hpp"
#include "formats/files.hpp"

namespace angio::formats {
namespace {

std::string text_of(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

}  // namespace

std::vector<double> CheckedArrays::checked(const std::string& name, std::size_t components,
                                           double low, double high) const {
  const std::vector<double>& values = find_array(arrays_, name).values;
  if (values.size() != components * tuple_count_)
    throw InputError(
        file_ + ": the array " + name + " has " + std::to_string(values.size()) +
        " values, where " + std::to_string(components * tuple_count_) +
        " belong (the file was changed or is damaged). Run the stage that writes it again");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] >= low && values[i] <= high))
      throw InputError(
          file_ + ": the array " + name + " holds " + text_of(values[i]) + " at place " +
          std::to_string(i) +
          ", which cannot be (the file was changed or is damaged). Run the stage that writes it "
          "again");
  return values;
}

std::vector<Vec3> CheckedArrays::vectors(const std::string& name) const {
  const std::vector<double> values = checked(name, 3, -kMost, kMost);
  std::vector<Vec3> result(values.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return result;
}

}  // namespace angio::formats
