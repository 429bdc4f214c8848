#include "pipeline/cli/sweep_command.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "pipeline/cli/stage_commands.hpp"
#include "pipeline/cli/sweep.hpp"
#include "pipeline/stages/run_case.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

void add_sweep_command(CLI::App& app, SweepArguments& sweep) {
  CLI::App& command = *app.add_subcommand(
      "sweep",
      "a case with other settings, side by side: every combination of the values is a variant\n"
      "writes sweep.csv, sweep.json and sweep.svg; CASE stays as it is");
  command.add_option("CASE", sweep.base, "a case that has been run")->required();
  command
      .add_option("VALUES", sweep.axes, "section.key=a,b,c: a setting and its values; one or more")
      ->required()
      ->expected(1, -1);
  command
      .add_option("-o,--output", sweep.request.folder,
                  "folder of the variants and the table; otherwise CASE-sweep")
      ->type_name("DIR");
  command.add_option("-j,--jobs", sweep.request.jobs, "variants at a time, 1 to 256")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_flag("--reports", sweep.reports, "make each variant's report, too");
  command.add_option("--backend", sweep.shared.backend, "where they run: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  command
      .add_option("--threads", sweep.shared.threads,
                  "CPU threads of a variant; 0: the computer's, shared out")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  add_output_options(command, sweep.shared);
}

int do_sweep(SweepArguments& sweep) {
  const Config config = case_config(CaseFolder(sweep.base));
  if (is_minimal(CaseFolder(sweep.base).read_record()))
    throw InputError(fmt::format("the stages' files of {0} were removed (--keep minimal; a sweep "
                                 "goes on from them). Make them again: `angio run INPUT -o {0}`",
                                 sweep.base.string()),
                     ExitCode::no_input);
  std::vector<SweepAxis> axes;
  for (const std::string& text : sweep.axes) axes.push_back(parse_axis(text));
  const std::vector<BatchCase> variants = make_variants(axes, config);
  for (const BatchCase& variant : variants) {
    Config changed = config;
    for (const std::string& setting : variant.settings) apply_setting(changed, setting);
    refuse_other_input(config, changed, "sweep");
  }
  BatchRequest& request = sweep.request;
  if (request.folder.empty())
    request.folder = fs::absolute(sweep.base).lexically_normal().string() + "-sweep";
  if (fs::exists(request.folder / "run.json"))
    throw IoError(fmt::format("{} is a case (a sweep needs a folder of its own). Name another -o",
                              request.folder.string()),
                  ExitCode::cannot_create);
  for (const BatchCase& variant : variants) seed_variant(sweep.base, request.folder / variant.name);
  request.config = config;
  request.program = fs::read_symlink("/proc/self/exe");
  request.threads = sweep.shared.threads;
  request.shared.backend = sweep.shared.backend;
  request.arguments = {"--quiet"};
  if (!sweep.reports) request.arguments.insert(request.arguments.end(), {"--until", "simulation"});
  request.resume = true;  // what is done with these very settings stays
  Reporter reporter(sweep.shared.style());
  const int failed = run_batch(request, variants, reporter);
  std::vector<SweepRow> rows;
  for (const BatchCase& variant : variants) rows.push_back(read_variant(request.folder, variant));
  write_sweep(request.folder, axes, rows);
  if (sweep.shared.style() == ReportStyle::automatic) fmt::print("{}", sweep_table(axes, rows));
  reporter.result((request.folder / "sweep.csv").string());
  return int(failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

}  // namespace angio::pipeline
