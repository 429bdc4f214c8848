#include "pipeline/experiments/experiment.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "datasets/phantom.hpp"

namespace angio::pipeline {
namespace {

constexpr const char* kCloth = "cloth";
constexpr const char* kCoronary = "coronary";

}  // namespace

bool is_cloth(const Config& config) { return config.experiment == kCloth; }

std::string default_input(const Config& config) {
  return config.experiment.empty() ? "" : kPhantomPrefix + config.experiment;
}

void check_experiment_input(const Config& config, const std::string& input) {
  const bool is_phantom = input.starts_with(kPhantomPrefix);
  if (config.experiment.empty() || (config.experiment == kCoronary && !is_phantom)) return;
  if (is_phantom && datasets::parse_phantom(input).name == config.experiment) return;
  throw Error(ExitCode::usage,
              fmt::format("the experiment {0} begins with the paper's mesh (INPUT is {1}). Leave "
                          "INPUT out, or give phantom:{0}",
                          config.experiment, is_phantom ? "another phantom" : "a file"));
}

TriangleMesh experiment_surface(StageWork& work) {
  const datasets::PhantomOptions options = datasets::parse_phantom(work.input);
  if (options.name == kCoronary)
    work.warnings.emplace_back(
        "no INPUT was given: the vessel is a generated coronary, not a patient's");
  TriangleMesh surface = options.name == kCoronary ? datasets::make_phantom_surface(options).surface
                                                   : datasets::make_paper_surface(options);
  work.input_description =
      fmt::format("the seed paper's experiment, {} vessel",
                  options.name == kCoronary ? "generated coronary" : options.name.c_str());
  return surface;
}

}  // namespace angio::pipeline
