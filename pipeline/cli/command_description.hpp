#pragma once

#include <CLI/App.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// What the program's commands and options are, taken from its own parser, for the shells'
/// completion and the manual page, which therefore cannot say anything else.
namespace angio::pipeline {

struct OptionDescription {
  std::vector<std::string> names;  ///< with their dashes; empty: by position
  std::string value;               ///< what stands for its value; empty: a flag
  std::vector<std::string> choices;
  std::string help;
  bool required = false;
  bool is_list = false;               ///< takes several values with commas between
  std::string group;                  ///< its heading in --help
  std::string default_value;          ///< as --help tells it; empty: none, or not told
  std::optional<double> least, most;  ///< of a number that has a range
  bool is_repeatable = false;         ///< may be given several times, or takes several values

  /// Is its value one of the choices?
  [[nodiscard]] bool is_enumeration() const { return !choices.empty() && !is_repeatable; }
};

struct CommandDescription {
  std::string name, help;
  std::vector<OptionDescription> options;
};

struct ProgramDescription {
  std::string help;
  std::vector<OptionDescription> options;
  std::vector<CommandDescription> commands;  ///< but the hidden ones
};

/// Values of options that the parser does not check, by the option's long name with dashes.
using KnownValues = std::map<std::string, std::vector<std::string>>;

ProgramDescription describe(const CLI::App& app, const KnownValues& known);

/// A script that completes commands, options and their values.
/// @param shell bash, zsh or fish
std::string completion_script(const ProgramDescription& program, const std::string& shell);

/// A manual page (section 1) as troff.
std::string manual_page(const ProgramDescription& program, const std::string& version);

/// A command's parameters for 3D Slicer, which shows a form of them (Slicer Execution Model).
std::string slicer_xml(const CommandDescription& command, const std::string& version);

}  // namespace angio::pipeline
