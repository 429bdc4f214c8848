#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "core/data_array.hpp"
#include "core/vec3.hpp"

namespace angio::formats {

/// The arrays of a file that may come from elsewhere: each is of the size that is asked for, and
/// each value is a number within a range. What is not is an InputError that names the file, the
/// array, the place and the value.
class CheckedArrays {
 public:
  /// @param tuple_count  of each array: the file's points or cells
  CheckedArrays(const std::vector<DataArray>& arrays, std::size_t tuple_count, std::string file)
      : arrays_(arrays), tuple_count_(tuple_count), file_(std::move(file)) {}

  /// @throws InputError if it is missing, of another size, or a value is outside [low, high]
  [[nodiscard]] std::vector<double> numbers(const std::string& name, double low,
                                            double high) const {
    return checked(name, 1, low, high);
  }
  /// Any finite numbers.
  [[nodiscard]] std::vector<double> numbers(const std::string& name) const {
    return checked(name, 1, -kMost, kMost);
  }
  /// Three numbers a tuple, of any size. @throws InputError as numbers()
  [[nodiscard]] std::vector<Vec3> vectors(const std::string& name) const;
  /// Rounded towards zero. @throws InputError as numbers()
  template <class Integer>
  [[nodiscard]] std::vector<Integer> integers(
      const std::string& name, double low = double(std::numeric_limits<Integer>::min()),
      double high = double(std::numeric_limits<Integer>::max())) const {
    std::vector<Integer> result;
    for (const double value : checked(name, 1, low, high)) result.push_back(Integer(value));
    return result;
  }

 private:
  static constexpr double kMost = std::numeric_limits<double>::max();

  [[nodiscard]] std::vector<double> checked(const std::string& name, std::size_t components,
                                            double low, double high) const;

  const std::vector<DataArray>& arrays_;
  std::size_t tuple_count_;
  std::string file_;
};

}  // namespace angio::formats
