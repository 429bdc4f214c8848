#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "datasets/phantom.hpp"

/// The commands about data alone: what is there, and phantoms.
namespace angio::pipeline {

/// Lists a folder's series, or describes a volume or surface. @return the exit code
int do_inspect(const std::string& input, bool as_json);

struct PhantomArguments {
  datasets::PhantomOptions options;
  std::string format = "dicom";
  std::filesystem::path folder;
};

void add_phantom_command(CLI::App& app, PhantomArguments& phantom);

/// Writes the phantom and its truth, and prints the path that `angio run` takes.
int do_phantom(const PhantomArguments& arguments);

}  // namespace angio::pipeline
