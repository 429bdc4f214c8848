#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/require.hpp"
#include "core/text.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/phantom.hpp"

namespace angio::datasets {
namespace {

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

/// A vessel too short for its width would run into itself.
void check_proportions(const PhantomOptions& options) {
  if (options.radius_mm <= 0.0 || options.length_mm <= 0.0) return;
  const detail::DefaultSize& size = detail::default_size(options.name);
  const double least = size.least_length_in_radii * options.radius_mm;
  if (options.length_mm >= least) return;
  throw OptionError("phantom.length_mm = " + text(options.length_mm) + " is too short for " +
                    options.name + " with phantom.radius_mm = " + text(options.radius_mm) +
                    " (its parts would run into each other). Use a length of at least " +
                    text(least) + " or a radius of at most " +
                    text(options.length_mm / size.least_length_in_radii));
}

double parse_number(std::string_view key, std::string_view value) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc{} || end != value.data() + value.size())
    throw OptionError("phantom option " + std::string(key) + "=" + std::string(value) +
                      " is not a number. Write " +
                      (key == "stenosis" ? "the percentage of the diameter, for example stenosis=60"
                                         : "for example " + std::string(key) + "=0.5"));
  return number;
}

std::uint64_t parse_seed(std::string_view value) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), seed);
  if (error != std::errc{} || end != value.data() + value.size())
    throw OptionError("phantom option seed=" + std::string(value) +
                      " is not a whole number from 0 to 2^64 - 1. Write for example seed=1");
  return seed;
}

void set_option(PhantomOptions& options, std::string_view key, std::string_view value) {
  struct Known {
    std::string_view key;
    double PhantomOptions::*field;
  };
  constexpr std::array<Known, 8> kKnown{{{"stenosis", &PhantomOptions::stenosis_percent},
                                         {"radius", &PhantomOptions::radius_mm},
                                         {"length", &PhantomOptions::length_mm},
                                         {"spacing", &PhantomOptions::spacing_mm},
                                         {"slice", &PhantomOptions::slice_mm},
                                         {"noise", &PhantomOptions::noise_sd},
                                         {"blur", &PhantomOptions::blur_mm},
                                         {"oblique", &PhantomOptions::oblique_degrees}}};
  if (key == "seed") {
    options.seed = parse_seed(value);
    return;
  }
  std::vector<std::string> names{"seed"};
  for (const Known& k : kKnown) {
    if (k.key == key) {
      options.*k.field = parse_number(key, value);
      return;
    }
    names.emplace_back(k.key);
  }
  throw OptionError(
      "a phantom has no option \"" + std::string(key) +
      "\" (there are: stenosis, radius, length, spacing, slice, noise, blur, oblique, seed). "
      "Did you mean \"" +
      nearest_name(key, names) + "\"?");
}

}  // namespace

void PhantomOptions::validate() const {
  detail::default_size(name);
  require_within("phantom.stenosis_percent", stenosis_percent, 0.0, 95.0);
  if (radius_mm != 0.0)
    require_within("phantom.radius_mm", radius_mm, 0.4, 15.0,
                   ". Leave it out for the phantom's own");
  if (length_mm != 0.0)
    require_within("phantom.length_mm", length_mm, 5.0, 200.0,
                   ". Leave it out for the phantom's own");
  require_within("phantom.spacing_mm", spacing_mm, 0.05, 2.0);
  if (slice_mm != 0.0)
    require_within("phantom.slice_mm", slice_mm, 0.05, 5.0, ". Leave it out for cubic voxels");
  require_within("phantom.noise_sd", noise_sd, 0.0, 1.0,
                 " (it is a fraction of the contrast). 0.1 means 10 %");
  require_within("phantom.blur_mm", blur_mm, 0.0, 3.0);
  require_within("phantom.oblique_degrees", oblique_degrees, 0.0, 90.0);
  check_proportions(*this);
}

PhantomOptions parse_phantom(std::string_view description) {
  constexpr std::string_view kPrefix = "phantom:";
  if (description.substr(0, kPrefix.size()) == kPrefix) description.remove_prefix(kPrefix.size());
  PhantomOptions options;
  std::size_t comma = description.find(',');
  options.name = description.substr(0, comma);
  detail::default_size(options.name);
  while (comma != std::string_view::npos) {
    description.remove_prefix(comma + 1);
    comma = description.find(',');
    const std::string_view item = description.substr(0, comma);
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos)
      throw OptionError("phantom option \"" + std::string(item) +
                        "\" has no value. Write key=value, for example "
                        "phantom:coronary,stenosis=60,noise=0.1");
    set_option(options, item.substr(0, equals), item.substr(equals + 1));
  }
  options.validate();
  return options;
}

}  // namespace angio::datasets
