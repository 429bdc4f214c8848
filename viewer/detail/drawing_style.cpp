#include "viewer/detail/drawing_style.hpp"

#include <map>
#include <sstream>
#include <string_view>

#include "viewer/detail/page_style.hpp"

namespace angio::viewer::detail {
namespace {

/// The values of the style sheet's first ":root{...}", by "--name".
std::map<std::string, std::string> light_values(const std::string& style) {
  const std::size_t open = style.find('{'), close = style.find('}');
  std::istringstream rules(style.substr(open + 1, close - open - 1));
  std::map<std::string, std::string> values;
  for (std::string rule; std::getline(rules, rule, ';');) {
    const std::size_t name = rule.find("--"), colon = rule.find(':');
    if (name != std::string::npos && colon != std::string::npos && name < colon)
      values[rule.substr(name, colon - name)] = rule.substr(colon + 1);
  }
  return values;
}

/// The rules of all drawings and of the sections' one, with values in place of var(--name).
std::string drawing_rules() {
  const std::string style = kPageStyle;
  const auto values = light_values(style);
  std::string rules = "svg{font:12px sans-serif}";
  std::istringstream lines(style);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("svg ") || line.starts_with("#section-view")) rules += line + "\n";
  constexpr std::string_view kBegin = "var(";
  for (std::size_t at = rules.find(kBegin); at != std::string::npos; at = rules.find(kBegin, at)) {
    const std::size_t end = rules.find(')', at);
    const auto value = values.find(rules.substr(at + kBegin.size(), end - at - kBegin.size()));
    rules.replace(at, end + 1 - at, value == values.end() ? "#000" : value->second);
  }
  return rules;
}

}  // namespace

std::string styled_drawing(const std::string& element) {
  static const std::string rules = drawing_rules();
  const std::size_t name_end = std::string_view("<svg").size(), close = element.find('>');
  if (close == std::string::npos) return {};
  return element.substr(0, name_end) +
         " xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\"" +
         element.substr(name_end, close + 1 - name_end) + "<style>" + rules + "</style>" +
         element.substr(close + 1);
}

}  // namespace angio::viewer::detail
