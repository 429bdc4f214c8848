#include "pipeline/experiments/paper_input.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "datasets/phantom.hpp"
#include "pipeline/case/input_kind.hpp"

namespace angio::pipeline {
namespace {

constexpr const char* kCoronary = "coronary";

}  // namespace

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

}  // namespace angio::pipeline
