#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

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

/// The same as words of a command line; without threads and output.
std::vector<std::string> command_line_of(const SharedOptions& shared);

}  // namespace angio::pipeline
