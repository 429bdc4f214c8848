#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "pipeline/cli/candidates.hpp"
#include "pipeline/cli/variants.hpp"

namespace angio::pipeline {

struct RecommendArguments {
  CandidateRequest candidates;
  std::vector<std::string> presets;
  VariantArguments variants;
};

void add_recommend_command(CLI::App& app, RecommendArguments& recommend);
int do_recommend(RecommendArguments& recommend);

}  // namespace angio::pipeline
