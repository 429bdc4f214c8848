#include "pipeline/cli/recommend_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/cli/recommend.hpp"
#include "pipeline/cli/stage_commands.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;

void add_recommend_command(CLI::App& app, RecommendArguments& recommend) {
  CLI::App& command = *app.add_subcommand(
      "recommend",
      "balloons, lengths and pressures for a case's lesion, simulated side by side and ranked\n"
      "writes recommendation.csv, .json and .svg; CASE stays as it is. For research, not medical "
      "advice");
  command.add_option("CASE", recommend.variants.base, "a case that has been meshed")->required();
  CandidateRequest& request = recommend.candidates;
  const auto add_values = [&](const char* name, std::vector<std::string>& values, const char* type,
                              const char* help) {
    return command.add_option(name, values, help)
        ->type_name(type)
        ->delimiter(',')
        ->allow_extra_args(false);  // else it takes CASE for a value
  };
  CLI::Option* diameters = add_values(
      "--diameters", request.diameters, "MM,...",
      "nominal; otherwise those sold next to 0.9, 1.0 and 1.1 times the reference diameter");
  add_values("--balloons", request.balloons, "NAME,...",
             "balloons of the catalogue instead (`angio inflate --list`)")
      ->excludes(diameters);
  command.add_option("--catalogue", request.catalogue, "balloons of your own, TOML")
      ->type_name("FILE");
  add_values(
      "--lengths", request.lengths, "MM,...",
      "otherwise the shortest sold that covers the lesion, and the next at nominal pressure");
  add_values("--pressures", request.pressures, "ATM,...",
             "numbers, nominal or rated; otherwise nominal,rated");
  command
      .add_option("--preset", recommend.presets,
                  "a set of options for all of them; `angio run --help` says what each is for")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_variant_options(command, recommend.variants, "CASE-recommend");
  command.footer(ranking_rule() +
                 " Without --lengths and --pressures there are at most nine candidates; with "
                 "either, every combination.");
}

int do_recommend(RecommendArguments& recommend) {
  VariantArguments& arguments = recommend.variants;
  const Config own = base_config(arguments.base);
  const TreatedLesion lesion = treated_lesion(arguments.base);
  Config config = own;
  for (const std::string& preset : recommend.presets) apply_preset(config, preset);
  refuse_other_input(own, config, "recommend");
  const std::vector<Candidate> candidates =
      make_candidates(recommend.candidates, lesion.size, config);
  std::vector<BatchCase> variants;
  for (const Candidate& candidate : candidates) variants.push_back(candidate.variant);
  const ReportStyle style = arguments.shared.style();
  Reporter reporter(style);
  reporter.note(fmt::format("{} candidate{} for a lesion of {:.1f} mm in a vessel of {:.2f} mm",
                            candidates.size(), candidates.size() == 1 ? "" : "s",
                            lesion.size.length_mm, lesion.size.reference_diameter_mm));
  const VariantResults runs = run_variants(arguments, config, variants, "recommend", reporter);
  const fs::path& folder = arguments.request.folder;
  std::vector<CandidateResult> results;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const fs::path metrics = folder / variants[c].name / formats::case_file::kMetrics;
    results.push_back(judge_candidate(candidates[c], runs.rows[c],
                                      fs::exists(metrics) ? read_json(metrics) : nlohmann::json(),
                                      lesion));
  }
  rank_results(results);
  write_recommendation(folder, lesion, results);
  if (style == ReportStyle::automatic)
    fmt::print("{}{}", recommendation_table(results), recommendation_words(results));
  reporter.result((folder / "recommendation.csv").string());
  return int(runs.failed > 0 ? ExitCode::some_cases_failed : ExitCode::done);
}

}  // namespace angio::pipeline
