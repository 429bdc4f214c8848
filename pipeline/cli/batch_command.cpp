#include "pipeline/cli/batch_command.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "core/error.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

void add_batch_command(CLI::App& app, BatchArguments& batch) {
  CLI::App& command = *app.add_subcommand(
      "batch",
      "a cohort: every row of a CSV manifest is a case\n"
      "columns: case,input and, as they are needed, preset, balloon, series and any\n"
      "configuration keys (balloon.length_mm, ...); all rows are checked first");
  auto& r = batch.request;
  command.add_option("MANIFEST", batch.manifest, "CSV file with a header")->required();
  command.add_option("-o,--output", r.folder, "folder of the cases and the summary")->required();
  command.add_option("-j,--jobs", r.jobs, "cases at a time, 1 to 256")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_option("--retry", r.retries, "further tries of a case that failed, 0 to 10")
      ->check(CLI::Range(0, 10))
      ->capture_default_str();
  command.add_flag("--resume", r.resume,
                   "leave out the cases that are done with these very options and input");
  add_run_options(command, batch.shared);
}

int do_batch(BatchArguments& batch) {
  Config config;  // refuses wrong options before the first case
  apply_options(config, batch.shared);
  config.validate();
  batch.request.threads = batch.shared.threads;
  batch.request.shared = batch.shared;
  batch.request.arguments = {"--quiet"};
  std::vector<BatchCase> cases = read_manifest(batch.manifest, batch.shared);
  batch.request.program = fs::read_symlink("/proc/self/exe");
  Reporter reporter(batch.shared.style());
  const int failed = run_batch(batch.request, std::move(cases), reporter);
  reporter.result((batch.request.folder / "summary.csv").string());
  return int(failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

}  // namespace angio::pipeline
