#pragma once

#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "pipeline/config/config.hpp"

/// Another value for any setting of the table, also for those that will be added to it.
namespace angio::test {

inline const pipeline::Setting& find_setting(const std::vector<pipeline::Setting>& table,
                                             const std::string& key) {
  for (const pipeline::Setting& setting : table)
    if (setting.key == key) return setting;
  throw InternalError("no setting is called " + key);
}

/// The names that a text may be, as the refusal of a wrong one lists them: "expected a, b or c".
inline std::vector<std::string> names_expected(const pipeline::Setting& setting) {
  try {
    setting.set("\"no such name\"");
  } catch (const OptionError& error) {
    std::string text = error.what();
    text = text.substr(text.find("expected ") + 9);
    text = text.substr(0, text.find(')'));
    for (char& c : text)
      if (c == ',') c = ' ';
    std::vector<std::string> names;
    std::istringstream words(text);
    for (std::string word; words >> word;)
      if (word != "or") names.push_back("\"" + word + "\"");
    return names;
  }
  return {"\"2\"", "\"pet\"", "\"coronary\""};
}

/// Values that may do, the most likely first.
inline std::vector<std::string> candidates(const pipeline::Setting& setting) {
  const std::string value = setting.get();
  if (value == "true") return {"false"};
  if (value == "false") return {"true"};
  const bool is_text = value.starts_with('"') || value.starts_with('\'');
  if (is_text && value.substr(1, value.size() - 2) == "auto") {
    std::vector<std::string> some = names_expected(setting);
    some.insert(some.end(), {"120.0", "[1.0, 2.0, 3.0]", "[[-9.0, -9.0, -9.0], [9.0, 9.0, 9.0]]"});
    return some;
  }
  if (is_text) return names_expected(setting);
  if (value == "[]") return {"[1.0]", "[[1.0, 2.0, 3.0]]", "[[6.0, 2.9], [8.0, 3.0], [12.0, 3.2]]"};
  if (value.starts_with('[')) {
    const std::size_t digit = value.find_first_of("0123456789");
    std::size_t used = 0;
    const double first = std::stod(value.substr(digit), &used);
    return {"[0.5, 0.5, 0.5]",
            value.substr(0, digit) + fmt::format("{}", first + 0.125) + value.substr(digit + used)};
  }
  const double number = std::stod(value);
  std::vector<std::string> some;
  if (value.find_first_of(".e") == std::string::npos)
    for (const int step : {1, 2, -1, -2}) some.push_back(fmt::format("{}", int(number) + step));
  for (const double other :
       {1.25 * number, 0.8 * number, number + 0.5, number + 1.0, number - 0.5, 2.0, 20.0, 2000.0})
    some.push_back(fmt::format("{}", other));
  return some;
}

/// Another value of the setting, as TOML: one that a configuration may have, or, where other
/// settings would have to change with it, one that it cannot.
/// @throws InternalError if none is found: candidates() must be taught its kind
inline std::string other_value(const pipeline::Config& config, const std::string& key) {
  pipeline::Config copy = config;
  const std::vector<pipeline::Setting> table = settings(copy);
  const pipeline::Setting& setting = find_setting(table, key);
  const std::string before = setting.get();
  std::string refused;
  for (const std::string& value : candidates(setting)) {
    copy = config;
    try {
      setting.set(value);
      if (setting.get() == before) continue;
      if (refused.empty()) refused = value;
      copy.validate();
      return value;
    } catch (const Error&) {
      continue;
    }
  }
  if (refused.empty()) throw InternalError("no other value is known for " + key + " = " + before);
  return refused;
}

}  // namespace angio::test
