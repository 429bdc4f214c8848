#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

struct ConvertArguments {
  std::string input;
  std::filesystem::path output;
  std::string to;    ///< empty: by the output's ending
  std::string unit;  ///< of a surface or volume file; empty: as it says
  bool keep_link = false;
  SharedOptions shared;  ///< --quiet and --json alone
};

CLI::App& add_convert_command(CLI::App& app, ConvertArguments& arguments);
int do_convert(const ConvertArguments& arguments);

}  // namespace angio::pipeline
