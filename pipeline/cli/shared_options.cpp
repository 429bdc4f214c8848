#include "pipeline/cli/shared_options.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "core/error.hpp"
#include "pipeline/config/balloon_file.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

void add_output_options(CLI::App& command, SharedOptions& shared) {
  command.add_flag("--quiet", shared.quiet, "no progress; warnings and errors only");
  command.add_flag("--json", shared.json, "results and events as JSON on standard output");
}

void add_run_options(CLI::App& command, SharedOptions& shared, PresetHelp presets) {
  add_output_options(command, shared);
  command.add_option("--config", shared.config_file, "options from a TOML file (a case.toml)")
      ->type_name("FILE");
  command.add_option("--set", shared.settings, "one option or more; --print-config lists them all")
      ->type_name("SECTION.KEY=VALUE")
      ->expected(1, -1);
  command
      .add_option("--preset", shared.presets,
                  presets == PresetHelp::full
                      ? preset_help()
                      : "a set of options; `angio run --help` says what each is for")
      ->type_name("NAME")
      ->allow_extra_args(false);  // else it takes INPUT for a second one
  command
      .add_option(
          "--balloon", shared.balloon,
          "a balloon of the catalogue (`angio inflate --list`): its size, membrane, chart and "
          "nominal pressure")
      ->type_name("NAME");
  command
      .add_option("--catalogue", shared.catalogue, "balloons of your own, TOML as balloons.toml")
      ->type_name("FILE");
  command
      .add_option("--contact", shared.contact,
                  "how balloon and wall touch: barrier (default), or paper (for comparison)")
      ->check(CLI::IsMember({"barrier", "paper"}));
  command
      .add_option("--backend", shared.backend,
                  "where volume and simulation are computed: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command
      .add_option("--threads", shared.threads, "CPU threads, 1 to 1024; 0: as many as there are")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

void add_keep_option(CLI::App& command, std::string& keep) {
  command
      .add_option("--keep", keep,
                  "which files of a case stay when it is done: all, or minimal (metrics, report,\n"
                  "centrelines, tables)")
      ->check(CLI::IsMember({"all", "minimal"}))
      ->capture_default_str();
}

Keep keep_of(const std::string& text) { return text == "minimal" ? Keep::minimal : Keep::all; }

void apply_options(Config& config, const SharedOptions& shared) {
  if (!shared.config_file.empty()) {
    if (!fs::exists(shared.config_file))
      throw InputError(
          fmt::format("there is no {} (no such configuration file)", shared.config_file),
          ExitCode::no_input);
    load_config(config, shared.config_file);
  }
  for (const std::string& preset : shared.presets) apply_preset(config, preset);
  if (!shared.balloon.empty())
    apply_balloon(config, find_balloon(balloon_catalogue(shared.catalogue), shared.balloon));
  if (!shared.contact.empty()) apply_setting(config, "simulation.contact_model=" + shared.contact);
  for (const std::string& setting : shared.settings) apply_setting(config, setting);
  config.simulation.backend = backend_of(shared.backend);
  config.reconstruction.backend = config.simulation.backend;
  if (shared.threads > 0) omp_set_num_threads(shared.threads);
}

Stage stage_of(const std::string& option, const std::string& text) {
  try {
    return parse_stage(text);
  } catch (const Error& error) {
    throw Error(error.exit_code(), fmt::format("{} {}: {}", option, text, error.what()));
  }
}

void apply_option(Config& config, const std::string& option, const std::string& value,
                  const std::string& setting, const std::string& expected) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ExitCode::usage,
                fmt::format("{} {} cannot be used (expected {}{})", option, value, expected, why));
  };
  const auto fault_of = [](const Config& one) -> std::string {
    try {
      one.validate();
      return {};
    } catch (const OptionError& error) {
      return error.what();
    }
  };
  Config changed = config;
  try {
    apply_setting(changed, setting);
  } catch (const OptionError&) {
    refuse("");
  }
  const std::string fault = fault_of(changed);
  if (!fault.empty() && fault != fault_of(config)) refuse("; " + fault);
  config = std::move(changed);
}

std::vector<std::string> command_line_of(const SharedOptions& shared) {
  std::vector<std::string> words;
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {option, value});
  };
  add("--config", shared.config_file);
  for (const std::string& preset : shared.presets) add("--preset", preset);
  add("--balloon", shared.balloon);
  add("--catalogue", shared.catalogue);
  add("--contact", shared.contact);
  for (const std::string& setting : shared.settings) add("--set", setting);
  add("--backend", shared.backend);
  return words;
}

}  // namespace angio::pipeline
