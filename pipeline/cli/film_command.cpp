#include "pipeline/cli/film_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "core/error.hpp"
#include "formats/tokens.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/cli/stale_note.hpp"
#include "pipeline/stages/reporter.hpp"
#include "viewer/film.hpp"

namespace angio::pipeline {
namespace {

/// "1280x720". @throws Error (64)
void read_size(const std::string& text, viewer::FilmOptions& options) {
  const std::size_t cross = text.find('x');
  const auto width = formats::parse_number<int>(std::string_view(text).substr(0, cross));
  const auto height = cross == std::string::npos
                          ? std::nullopt
                          : formats::parse_number<int>(std::string_view(text).substr(cross + 1));
  if (!width || !height)
    throw Error(ExitCode::usage,
                "--size " + text + " is no size of a picture. Give WIDTHxHEIGHT, as 1280x720");
  options.width = *width;
  options.height = *height;
}

/// @throws OptionError (78) that names the options as they were typed
void check(const viewer::FilmOptions& options, const FilmArguments& a) {
  try {
    options.validate();
  } catch (const OptionError& error) {
    throw OptionError(
        fmt::format("--size {} --fps {}: {}", a.size, a.pictures_per_second, error.what()));
  }
}

}  // namespace

CLI::App& add_film_command(CLI::App& app, FilmArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "film", "the simulation of a case as a film in real time, close on the balloon");
  command.add_option("CASE", a.case_folder, "the case's folder")->required();
  command.add_option("-o,--output", a.film, "the film: .mp4, .avi or .ogv")
      ->required()
      ->type_name("FILE");
  command.add_option("--size", a.size, "of the picture in pixels, even, 160x120 to 3840x2160")
      ->type_name("WxH")
      ->capture_default_str();
  command.add_option("--fps", a.pictures_per_second, "pictures per second, 1 to 60")
      ->type_name("N")
      ->capture_default_str();
  add_output_options(command, a.shared);
  return command;
}

int do_film(const FilmArguments& a) {
  viewer::FilmOptions options;
  read_size(a.size, options);
  options.pictures_per_second = a.pictures_per_second;
  check(options, a);
  Reporter reporter(a.shared.style());
  reporter.begin_stage("film");
  refuse_untreated(CaseFolder(a.case_folder));
  note_if_stale(a.case_folder, reporter);
  viewer::write_film(a.case_folder, a.film, options, reporter.progress());
  reporter.result(a.film.string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
