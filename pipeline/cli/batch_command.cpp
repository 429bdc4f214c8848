#include "pipeline/cli/batch_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "pipeline/case/console.hpp"

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
  command
      .add_option("--retry", r.retries,
                  "further tries of a case that failed for another reason than its data or "
                  "options, 0 to 10")
      ->check(CLI::Range(0, 10))
      ->capture_default_str();
  command.add_flag("--resume", r.resume,
                   "leave out the cases that are done with these very options and input");
  CLI::Option* failed = command.add_flag("--only-failed", r.only_failed,
                                         "run those cases alone whose last run has failed");
  failed->excludes("--resume");
  command
      .add_option("--shard", batch.shard,
                  "run every n-th row from the i-th on, 1 <= i <= n, as one of n machines that "
                  "share\nDIR; --summary-only sums up all")
      ->type_name("I/N");
  command
      .add_option("--until", batch.until, "of each case no more than this stage and those before")
      ->type_name("STAGE");
  command.add_flag(
      "--engine", batch.for_engine,
      "exit codes for workflow engines: 75 where a further try may end otherwise, else "
      "0, also\nwhere cases failed for good: see the summary");
  CLI::Option* dry = command.add_flag(
      "--dry-run", batch.dry_run, "list what would be run, resumed or left out, and why; no more");
  command
      .add_flag("--summary-only", batch.summary_only,
                "run nothing: write the summary of what former runs have left")
      ->excludes(dry)
      ->excludes(failed);
  add_keep_option(command, batch.keep);
  add_run_options(command, batch.shared);
}

namespace {

constexpr const char* kActions[] = {"run", "resume", "skip"};

/// Lists what would be done with each row.
void print_plan(const BatchArguments& batch, const std::vector<BatchCase>& cases,
                std::size_t row_count) {
  const std::vector<CasePlan> plans = plan_batch(batch.request, cases);
  std::array<int, 3> counts{};
  std::size_t width = 4;
  for (const BatchCase& one : cases) width = std::max(width, one.name.size());
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const char* action = kActions[int(plans[c].action)];
    ++counts.at(std::size_t(plans[c].action));
    if (batch.shared.json)
      fmt::print("{}\n", nlohmann::json{{"event", "plan"},
                                        {"case", cases[c].name},
                                        {"action", action},
                                        {"reason", plans[c].reason}}
                             .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    else
      fmt::print("{:<{}}  {:<6}  {}\n", cases[c].name, width, action, plans[c].reason);
  }
  const std::size_t others = row_count - cases.size();
  if (!batch.shared.json && !batch.shared.quiet)
    say("{} case(s): {} to run, {} to resume, {} left out{}. Nothing was started\n", cases.size(),
        counts[0], counts[1], counts[2],
        others == 0 ? "" : fmt::format("; {} of other shards", others));
}

void check_folder(const BatchArguments& batch) {
  const fs::path& folder = batch.request.folder;
  if (fs::exists(folder / "run.json"))
    throw IoError(fmt::format("{} is a case (a batch needs a folder of its own). Name another -o",
                              folder.string()),
                  ExitCode::cannot_create);
  if (batch.summary_only && !fs::is_directory(folder))
    throw InputError(
        fmt::format("there is no {} to sum up (-o names the folder of a batch)", folder.string()),
        ExitCode::no_input);
}

}  // namespace

int do_batch(BatchArguments& batch) {
  Config config;  // refuses wrong options before the first case
  apply_options(config, batch.shared);
  config.validate();
  batch.request.threads = batch.shared.threads;
  batch.request.shared = batch.shared;
  batch.request.keep = keep_of(batch.keep);
  if (!batch.until.empty()) batch.request.until = stage_of("--until", batch.until);
  if (batch.request.keep == Keep::minimal && batch.request.until != Stage::report)
    throw Error(ExitCode::usage, "--keep minimal is for whole cases. Leave out --until");
  batch.request.arguments = {"--quiet"};
  if (!batch.shard.empty()) batch.request.shard = parse_shard(batch.shard);
  check_folder(batch);
  const std::vector<BatchCase> all = read_manifest(
      batch.manifest, batch.shared, batch.summary_only ? InputsAre::not_needed : InputsAre::needed);
  const std::vector<BatchCase> cases = rows_of_shard(all, batch.request.shard);
  if (batch.dry_run) {
    print_plan(batch, cases, all.size());
    return int(ExitCode::done);
  }
  batch.request.program = fs::read_symlink("/proc/self/exe");
  Reporter reporter(batch.shared.style());
  const BatchResult result = batch.summary_only
                                 ? BatchResult{summarize_batch(batch.request, cases), 0}
                                 : run_batch(batch.request, cases, reporter);
  const int failed = result.failed;
  if (failed > 0)
    reporter.note(fmt::format("{}: {} of {}", batch.summary_only ? "not done" : "failed", failed,
                              cases.size()));
  reporter.result(summary_file(batch.request).string());
  if (batch.for_engine)
    return int(result.worth_another_try > 0 ? ExitCode::interrupted : ExitCode::done);
  return int(failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

}  // namespace angio::pipeline
