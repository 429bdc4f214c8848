#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "pipeline/case/stage.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/minimal_case.hpp"
#include "pipeline/stages/reporter.hpp"

namespace angio::pipeline {

/// Options that several commands share, as they stand on the command line.
struct SharedOptions {
  std::string config_file;
  std::vector<std::string> presets;
  std::vector<std::string> settings;
  std::string balloon, catalogue;
  std::string contact;
  std::string backend = "auto";
  int threads = 0;
  bool quiet = false;
  bool json = false;

  [[nodiscard]] ReportStyle style() const {
    return json ? ReportStyle::json : (quiet ? ReportStyle::quiet : ReportStyle::automatic);
  }
};

void add_output_options(CLI::App& command, SharedOptions& shared);
/// What --help says of the presets: what each is for, or where that stands.
enum class PresetHelp { full, brief };
void add_run_options(CLI::App& command, SharedOptions& shared,
                     PresetHelp presets = PresetHelp::brief);

/// --keep: which files of a case stay when it is done.
void add_keep_option(CLI::App& command, std::string& keep);
Keep keep_of(const std::string& text);

/// Files first, then presets, the balloon, and single settings, so that the more special wins.
void apply_options(Config& config, const SharedOptions& shared);

/// The stage that an option names. @throws Error (64) naming the option, and the stages there are
Stage stage_of(const std::string& option, const std::string& text);

/// Applies a setting for which an option of the command line stands.
///
/// @param option, value  as they were typed, for messages: "--inlet", "1,2"
/// @param setting        "section.key=value"
/// @param expected       what may be there, for the reader: "a point X,Y,Z in LPS [mm]"
/// @throws Error (64) that names all three if the value is of another kind or out of range
void apply_option(Config& config, const std::string& option, const std::string& value,
                  const std::string& setting, const std::string& expected);

/// The words of a command line that apply_options takes back; without threads and output.
std::vector<std::string> command_line_of(const SharedOptions& shared);

}  // namespace angio::pipeline
