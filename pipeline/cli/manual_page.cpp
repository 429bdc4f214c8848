#include <fmt/format.h>
#include <fmt/ranges.h>

#include "pipeline/cli/command_description.hpp"

namespace angio::pipeline {
namespace {

/// Text that troff takes literally: one line, no macro at its head.
std::string literal(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c == '\n' ? ' ' : c;
  }
  return result.starts_with('.') || result.starts_with('\'') ? "\\&" + result : result;
}

std::string option_entry(const OptionDescription& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back("\\fB" + literal(name) + "\\fR");
  std::string text = fmt::format(".TP\n{}", fmt::join(names, ", "));
  if (!option.value.empty())
    text += fmt::format("{}\\fI{}\\fR", names.empty() ? "" : " ", literal(option.value));
  text += "\n" + literal(option.help) + "\n";
  if (!option.choices.empty())
    text += literal(fmt::format("({})", fmt::join(option.choices, ", "))) + "\n";
  return text;
}

std::string command_section(const CommandDescription& command) {
  std::string line = "angio " + command.name, entries;
  for (const OptionDescription& option : command.options) {
    if (option.names.empty())
      line += option.required ? " " + option.value : " [" + option.value + "]";
    else if (option.required)
      line += " " + option.names.front() + " " + option.value;
    entries += option_entry(option);
  }
  return fmt::format(".SS \"{}\"\n{}\n{}", literal(line), literal(command.help), entries);
}

}  // namespace

std::string manual_page(const ProgramDescription& program, const std::string& version) {
  std::string text = fmt::format(
      ".TH ANGIO 1 \"\" \"angio {}\" \"User Commands\"\n"
      ".SH NAME\n"
      "angio \\- simulate a balloon angioplasty in a patient's angiography\n"
      ".SH SYNOPSIS\n"
      ".B angio\n"
      ".I COMMAND\n"
      "[\\fIARGUMENTS\\fR]\n"
      ".SH DESCRIPTION\n{}\n"
      ".SH OPTIONS\n",
      literal(version), literal(program.help));
  for (const OptionDescription& option : program.options) text += option_entry(option);
  text += ".SH COMMANDS\n";
  for (const CommandDescription& command : program.commands) text += command_section(command);
  return text +
         ".SH EXAMPLE\n"
         ".EX\nangio run phantom:coronary \\-o case\n.EE\n";
}

}  // namespace angio::pipeline
