#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "formats/html.hpp"
#include "pipeline/cli/command_description.hpp"

// After the schema of the Slicer Execution Model (slicer.readthedocs.io, "Slicer Execution Model").
namespace angio::pipeline {
namespace {

std::string element(const char* name, const std::string& text) {
  return fmt::format("<{0}>{1}</{0}>\n", name, formats::escape_html(text));
}

/// Without dashes, as a C identifier; of what has no name the word that stands for it.
std::string identifier(const OptionDescription& option) {
  std::string name = option.names.empty() ? option.value : option.names.back();
  std::string result;
  for (const char c : name) {
    if (c == '-' && result.empty()) continue;
    result += std::isalnum(static_cast<unsigned char>(c)) != 0
                  ? char(std::tolower(static_cast<unsigned char>(c)))
                  : '_';
  }
  return result;
}

/// What a parameter is in Slicer, and in which direction it goes; empty: neither.
struct SlicerType {
  std::string name = "string";
  std::string channel;
};

/// By the word that stands for its value; a scan is chosen among Slicer's volumes, which it hands
/// over as a file.
SlicerType type_of(const OptionDescription& option) {
  if (option.value.empty()) return {"boolean", ""};
  if (option.is_enumeration()) return {"string-enumeration", ""};
  if (option.value == "INPUT" && option.names.empty()) return {"image", "input"};
  const bool is_output =
      std::find(option.names.begin(), option.names.end(), "--output") != option.names.end() ||
      option.value == "OUT";
  static const std::map<std::string_view, const char*> kTypes = {
      {"INT", "integer"},      {"UINT", "integer"},  {"FLOAT", "double"},   {"ATM", "double"},
      {"MM", "double"},        {"N", "integer"},     {"S", "double"},       {"FILE", "file"},
      {"IN", "file"},          {"OUT", "file"},      {"CASE", "directory"}, {"DIR", "directory"},
      {"FOLDER", "directory"}, {"MANIFEST", "file"},
  };
  const std::string word = option.value.substr(0, option.value.find(','));  // "ATM,ATM,..."
  const auto known = kTypes.find(word);
  std::string name = known == kTypes.end() ? "string" : known->second;
  const bool is_path = name == "file" || name == "directory";
  if (option.is_list && !is_path) name += "-vector";
  return {name, is_path ? (is_output ? "output" : "input") : ""};
}

std::string flags_of(const OptionDescription& option) {
  std::string text;
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? element("longflag", name) : element("flag", name);
  return text;
}

std::string constraints_of(const OptionDescription& option) {
  if (!option.least || !option.most) return {};
  return fmt::format(
      "<constraints>\n<minimum>{}</minimum>\n<maximum>{}</maximum>\n</constraints>\n",
      *option.least, *option.most);
}

std::string parameter(const OptionDescription& option, const std::string& name,
                      int& positional_count) {
  const SlicerType type = type_of(option);
  std::string text = fmt::format("<{}>\n", type.name);
  text += element("name", name);
  if (option.names.empty())
    text += element("index", fmt::format("{}", positional_count++));
  else
    text += flags_of(option);
  text += element("label", option.names.empty() ? option.value : option.names.back());
  text += element("description", option.help.empty() ? name : option.help);
  if (!type.channel.empty()) text += element("channel", type.channel);
  if (option.value.empty())
    text += element("default", "false");
  else if (!option.default_value.empty())
    text += element("default", option.default_value);
  if (option.is_enumeration())
    for (const std::string& choice : option.choices) text += element("element", choice);
  text += constraints_of(option);
  return text + fmt::format("</{}>\n", type.name);
}

/// Not for a form: help, and what prints this.
bool is_shown(const OptionDescription& option) {
  constexpr std::array<std::string_view, 3> kHidden{"--help", "--xml", "--json"};
  return std::none_of(option.names.begin(), option.names.end(), [&](const std::string& name) {
    return std::find(kHidden.begin(), kHidden.end(), name) != kHidden.end();
  });
}

bool is_main(const OptionDescription& option) {
  return option.names.empty() || option.required ||
         std::find(option.names.begin(), option.names.end(), "--output") != option.names.end();
}

/// A group of parameters; nothing where it is empty.
std::string group(const std::string& label, const std::string& parameters, bool is_advanced) {
  if (parameters.empty()) return {};
  return fmt::format("<parameters{}>\n", is_advanced ? " advanced=\"true\"" : "") +
         element("label", label) + element("description", label) + parameters + "</parameters>\n";
}

/// Unlike every other: an argument may have the name of an option.
std::string unique_identifier(const CommandDescription& command, const OptionDescription& option) {
  const std::string name = identifier(option);
  const bool is_taken =
      option.names.empty() &&
      std::any_of(command.options.begin(), command.options.end(),
                  [&](const auto& o) { return !o.names.empty() && identifier(o) == name; });
  return is_taken ? name + "_argument" : name;
}

}  // namespace

std::string slicer_xml(const CommandDescription& command, const std::string& version) {
  std::string text = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<executable>\n";
  text += element("category", "Vascular.angio");
  text += element("title", "angio " + command.name);
  text += element("description", command.help + "\nNot for clinical use.");
  text += element("version", version);
  text += element("license", "GPL-3.0-or-later");
  text += element("contributor", "the angio authors");
  int positional_count = 0;
  std::string main;
  std::vector<std::string> groups;  // in the order of --help
  std::map<std::string, std::string> others;
  for (const OptionDescription& option : command.options) {
    if (!is_shown(option)) continue;
    if (is_main(option)) {
      main += parameter(option, unique_identifier(command, option), positional_count);
      continue;
    }
    if (!others.contains(option.group)) groups.push_back(option.group);
    others[option.group] += parameter(option, unique_identifier(command, option), positional_count);
  }
  text += group("What", main, false);
  for (const std::string& name : groups) text += group(name, others[name], true);
  return text + "</executable>\n";
}

}  // namespace angio::pipeline
