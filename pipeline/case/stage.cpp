#include "pipeline/case/stage.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "pipeline/config/config.hpp"

namespace angio::pipeline {
namespace {

constexpr const char* kNames[kStageCount] = {"reconstruction", "segmentation", "centerline",
                                             "meshing",        "simulation",   "report"};

/// The stage that a wrong word means: the one that begins as the word does for four letters or more
/// (the commands are called `segment`, `mesh`, `simulate`), else the nearest; empty: none.
std::string guess_stage(std::string_view word) {
  constexpr std::size_t kLeastStem = 4;
  for (const char* known : kNames)
    if (word.size() >= kLeastStem && word.starts_with(std::string_view(known, kLeastStem)))
      return known;
  return guess_name(word, std::vector<std::string>(std::begin(kNames), std::end(kNames)));
}

}  // namespace

const char* name(Stage stage) { return kNames[int(stage)]; }

Stage parse_stage(std::string_view text) {
  for (int s = 0; s < kStageCount; ++s)
    if (text == kNames[s]) return Stage(s);
  const std::string guess = guess_stage(text);
  throw Error(
      ExitCode::usage,
      fmt::format(
          "no stage is called {}{} (the stages: reconstruction segmentation centerline meshing "
          "simulation report)",
          text, guess.empty() ? "" : fmt::format(", did you mean {}?", guess)));
}

}  // namespace angio::pipeline
