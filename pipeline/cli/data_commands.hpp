#pragma once

#include <CLI/App.hpp>
#include <string>

#include "pipeline/config/config.hpp"

/// How inputs are read, and what there is in one.
namespace angio::pipeline {

/// How an input is to be read, as it stands on the command line; empty: as configured.
struct ReadArguments {
  std::string series, views, ends, spacing, angles, max_memory;
  bool allow_lossy = false;
  bool resample = false;
};
void add_read_options(CLI::App& command, ReadArguments& read);
void apply_read_options(Config& config, const ReadArguments& read);

/// --unit, of a lumen surface.
void add_unit_option(CLI::App& command, std::string& unit);

struct InspectArguments {
  std::string input;
  ReadArguments read;
  std::string unit;  ///< of a surface
  bool as_json = false;
};
CLI::App& add_inspect_command(CLI::App& app, InspectArguments& inspect);

/// Lists a folder's series, or describes a volume or surface. @return the exit code
int do_inspect(const InspectArguments& arguments);

}  // namespace angio::pipeline
