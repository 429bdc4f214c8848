#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "pipeline/cli/shared_options.hpp"

namespace angio::pipeline {

struct FilmArguments {
  std::filesystem::path case_folder, film;
  std::string size = "1280x720";
  int pictures_per_second = 25;
  SharedOptions shared;  ///< --quiet and --json alone
};

CLI::App& add_film_command(CLI::App& app, FilmArguments& arguments);
int do_film(const FilmArguments& arguments);

}  // namespace angio::pipeline
