#include "pipeline/case/stage.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "pipeline/config/config.hpp"

namespace angio::pipeline {
namespace {

constexpr const char* kNames[kStageCount] = {"segmentation", "centerline", "meshing", "simulation",
                                             "report"};

}  // namespace

const char* name(Stage stage) { return kNames[int(stage)]; }

Stage parse_stage(std::string_view text) {
  for (int s = 0; s < kStageCount; ++s)
    if (text == kNames[s]) return Stage(s);
  const std::string guess =
      guess_name(text, std::vector<std::string>(std::begin(kNames), std::end(kNames)));
  throw Error(ExitCode::usage,
              fmt::format("no stage is called {}{} (the stages: segmentation centerline meshing "
                          "simulation report)",
                          text, guess.empty() ? "" : fmt::format(", did you mean {}?", guess)));
}

}  // namespace angio::pipeline
