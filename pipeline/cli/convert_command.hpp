#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

namespace angio::pipeline {

struct ConvertArguments {
  std::string input;
  std::filesystem::path output;
  std::string to;  ///< empty: by the output's ending
  bool quiet = false, json = false;
};

CLI::App& add_convert_command(CLI::App& app, ConvertArguments& arguments);
int do_convert(const ConvertArguments& arguments);

}  // namespace angio::pipeline
