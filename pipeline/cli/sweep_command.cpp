#include "pipeline/cli/sweep_command.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "pipeline/cli/sweep.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

void add_sweep_command(CLI::App& app, SweepArguments& sweep) {
  CLI::App& command = *app.add_subcommand(
      "sweep",
      "a case with other settings, side by side: every combination of the values is a variant\n"
      "writes sweep.csv, sweep.json and sweep.svg; CASE stays as it is");
  command.add_option("CASE", sweep.variants.base, "a case that has been run")->required();
  command
      .add_option("VALUES", sweep.axes, "section.key=a,b,c: a setting and its values; one or more")
      ->required()
      ->expected(1, -1);
  add_variant_options(command, sweep.variants, "CASE-sweep");
}

int do_sweep(SweepArguments& sweep) {
  const Config config = base_config(sweep.variants.base);
  std::vector<SweepAxis> axes;
  for (const std::string& text : sweep.axes) axes.push_back(parse_axis(text));
  const std::vector<BatchCase> variants = make_variants(axes, config);
  const ReportStyle style = sweep.variants.shared.style();
  Reporter reporter(style);
  const VariantResults results = run_variants(sweep.variants, config, variants, "sweep", reporter);
  const fs::path& folder = sweep.variants.request.folder;
  write_sweep(folder, axes, results.rows);
  if (style == ReportStyle::automatic) fmt::print("{}", sweep_table(axes, results.rows));
  reporter.result((folder / "sweep.csv").string());
  return int(results.failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

}  // namespace angio::pipeline
