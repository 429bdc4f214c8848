#include "pipeline/cli/figure_command.hpp"

#include <CLI/CLI.hpp>

#include "core/error.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/cli/stale_note.hpp"
#include "pipeline/stages/reporter.hpp"
#include "viewer/case_figures.hpp"

namespace angio::pipeline {

CLI::App& add_figure_command(CLI::App& app, FigureArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "figure",
      "pictures of a case for a paper: nine moments (moments.png), the diameter\n"
      "along the path and the course over time (diameter, course: .svg, .png)");
  command.add_option("CASE", a.case_folder, "the case's folder")->required();
  command.add_option("-o,--output", a.folder, "folder of the pictures")
      ->required()
      ->type_name("DIR");
  add_output_options(command, a.shared);
  return command;
}

int do_figure(const FigureArguments& a) {
  Reporter reporter(a.shared.style());
  reporter.begin_stage("figure");
  refuse_untreated(CaseFolder(a.case_folder));
  note_if_stale(a.case_folder, reporter);
  for (const auto& file : viewer::write_case_figures(a.case_folder, a.folder, reporter.progress()))
    reporter.result(file.string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
