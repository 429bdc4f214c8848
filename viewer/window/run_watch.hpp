#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace angio::viewer::window {

/// Follows a run under way by the modification times of the files that it writes: run.json,
/// metrics.json, meshing/lumen.vtp, and the list of frames, which the simulation writes again with
/// every frame.
class RunWatch {
 public:
  explicit RunWatch(std::filesystem::path case_folder);

  enum class News { none, frames, lumen };
  /// What has changed since the last call; a new lumen means everything.
  News look();
  /// Everything is news at the next look.
  void forget() { times_.clear(); }

 private:
  using Times = std::map<std::string, std::filesystem::file_time_type>;
  [[nodiscard]] Times read_times() const;

  std::filesystem::path folder_;
  Times times_;
};

}  // namespace angio::viewer::window
