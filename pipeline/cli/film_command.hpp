#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

namespace angio::pipeline {

struct FilmArguments {
  std::filesystem::path case_folder, film;
  std::string size = "1280x720";
  int pictures_per_second = 25;
  bool quiet = false, json = false;
};

CLI::App& add_film_command(CLI::App& app, FilmArguments& arguments);
int do_film(const FilmArguments& arguments);

}  // namespace angio::pipeline
