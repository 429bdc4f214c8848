#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/atomic_file.hpp"

/// What two cases have to share if they come from the same input and settings.
namespace angio::test {

inline nlohmann::json read_json_file(const std::filesystem::path& file) {
  return nlohmann::json::parse(read_text(file));
}

/// A file of a case without what differs from run to run: times and memory.
inline std::string lasting_content(const std::filesystem::path& file) {
  std::string text = read_text(file);
  if (file.filename() != "run.json" && file.filename() != "metrics.json") return text;
  auto root = nlohmann::json::parse(text);
  for (const char* key : {"wall_s", "time_split_s", "frames_per_second", "real_time_factor"})
    if (root.contains("simulation")) root["simulation"].erase(key);
  for (const char* key : {"files", "record_sha256"}) root.erase(key);  // hashes of those
  if (root.contains("stages"))
    for (auto& stage : root["stages"])
      for (const char* key : {"seconds", "peak_memory_mib", "solver_seconds", "time_split_s"})
        stage.erase(key);
  return root.dump(1);
}

/// All files of a case, by their paths inside it.
inline std::map<std::string, std::string> case_content(const std::filesystem::path& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      content[std::filesystem::relative(entry.path(), folder).string()] =
          lasting_content(entry.path());
  return content;
}

}  // namespace angio::test
