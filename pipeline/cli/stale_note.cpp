#include "pipeline/cli/stale_note.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/metrics.hpp"

namespace angio::pipeline {

void note_if_stale(const std::filesystem::path& case_folder, Reporter& reporter) {
  const std::filesystem::path file = case_folder / formats::case_file::kMetrics;
  if (!std::filesystem::is_regular_file(file)) return;
  try {
    const nlohmann::json metrics = read_json(file);
    if (metrics.is_object() && metrics.contains("status") && metrics["status"] == "stale")
      reporter.note(
          "the case is out of date: its settings or files have changed since it was simulated, and "
          "what is shown is the earlier simulation. `angio run` makes it anew");
  } catch (const InputError&) {  // damaged: what reads it for its numbers says so
  }
}

}  // namespace angio::pipeline
