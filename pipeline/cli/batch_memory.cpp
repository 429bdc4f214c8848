#include "pipeline/cli/batch_memory.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/atomic_file.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::uint64_t bytes_of(const fs::path& input) {
  std::error_code error;
  if (!fs::is_directory(input, error)) {
    const auto size = fs::file_size(input, error);
    return error ? 0 : size;
  }
  std::uint64_t sum = 0;
  auto entry =
      fs::recursive_directory_iterator(input, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored)) sum += entry->file_size(ignored);
  }
  return sum;
}

}  // namespace

std::uint64_t memory_taken(const fs::path& case_folder) {
  const fs::path file = case_folder / "run.json";
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return 0;
  const json record = json::parse(read_text(file), nullptr, false);
  if (!record.is_object() || !record.contains("stages")) return 0;
  double most = 0.0;
  for (const json& stage : record["stages"])
    if (stage.is_object() && stage.contains("peak_memory_mib") &&
        stage["peak_memory_mib"].is_number())
      most = std::max(most, stage["peak_memory_mib"].get<double>());
  constexpr double kMebibyte = 1024.0 * 1024.0;
  constexpr double kMost = 1e6;  // a file that may come from elsewhere
  return std::uint64_t(std::min(most, kMost) * kMebibyte);
}

std::uint64_t memory_guess(const std::string& input) {
  constexpr std::uint64_t kOfItself = std::uint64_t(1) << 30;
  constexpr std::uint64_t kPerByte = 24;
  return kOfItself + kPerByte * bytes_of(input);
}

}  // namespace angio::pipeline
