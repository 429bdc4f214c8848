#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "datasets/phantom.hpp"
#include "datasets/rotational_run.hpp"

namespace angio::pipeline {

struct PhantomArguments {
  datasets::PhantomOptions options;
  datasets::RotationalRunOptions run;
  bool noise_is_given = false, frames_are_given = false;
  std::string views = "-30/20,40/-15";  ///< primary/secondary angles [degrees]
  std::string format = "dicom";
  std::filesystem::path folder;
};

void add_phantom_command(CLI::App& app, PhantomArguments& phantom);

/// Writes the phantom and its truth, and prints the path that `angio run` takes.
int do_phantom(const PhantomArguments& arguments);

}  // namespace angio::pipeline
