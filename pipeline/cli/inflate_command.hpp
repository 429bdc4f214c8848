#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace angio::pipeline {

/// `angio inflate`: a balloon alone, no vessel.
struct InflateArguments {
  std::string balloon;  ///< a name of the catalogue; empty: the measures below
  std::filesystem::path catalogue, folder;
  double radius_mm = 0.0, length_mm = 0.0, wall_mm = 0.0;  ///< 0: not given
  std::string material, ends = "hemispheres";
  std::vector<double> pressures_atm, volumes_mm3;
  std::string solver = "newton", backend = "auto";
  int around = 0, threads = 0;
  bool list = false, quiet = false, json = false;
};

CLI::App& add_inflate_command(CLI::App& app, InflateArguments& arguments);

/// Writes inflation.csv and inflation.svg. @return the exit code
int do_inflate(const InflateArguments& arguments);

}  // namespace angio::pipeline
