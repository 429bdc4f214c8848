#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/case/stage.hpp"

namespace angio::pipeline {

/// SHA-256 as 64 hexadecimal digits.
std::string sha256_of_text(std::string_view text);
/// Of a file's content, or of a folder's files in the order of their names.
/// @throws IoError if something cannot be read
std::string sha256_of_path(const std::filesystem::path& path);

/// What run.json says of one stage.
struct StageRecord {
  std::string status = "not run";  ///< "done", "given" (the input was a surface), "failed" (the
                                   ///< first warning says why), "interrupted", "skipped" (it does
                                   ///< not apply, or what was tried unasked gave no result)
  /// What it depends on has changed since (run.json's status is then "stale", and status_then is
  /// this status): what it left is that of another state of the case.
  bool is_stale = false;
  std::string key;  ///< hash of version, settings and inputs: equal means up to date
  double seconds = 0.0;
  double peak_memory_mib = 0.0;
  double solver_seconds = 0.0;                 ///< of the simulation, with its frames' files
  std::map<std::string, std::string> inputs;   ///< file -> SHA-256
  std::map<std::string, std::string> outputs;  ///< file in the case -> SHA-256
  std::string build;                           ///< version and commit of the program that did it
  std::vector<std::string> removed;            ///< of the outputs: see stages/minimal_case.hpp
  std::vector<std::string> warnings;
  std::map<std::string, double> time_split;  ///< of the simulation [s]; see TimeSplit
};

/// What a case's run.json holds.
struct RunRecord {
  std::string case_name;   ///< given by the user, or the first digits of the input's hash
  std::string input_kind;  ///< "volume", "surface", "phantom" or "run"
  std::string input_sha256;
  std::string input_description;  ///< no identity
  std::string backend;
  std::string device;
  std::map<Stage, StageRecord> stages;
  /// case.toml and metrics.json -> SHA-256; empty while they are being written.
  std::map<std::string, std::string> files;

  /// Has the stage this status, and is it not stale?
  [[nodiscard]] bool is(Stage stage, std::string_view status) const;
};
/// As run.json has it.
nlohmann::json to_json(const RunRecord& record);
/// What the report shows of run.json: without the times, so that the same input gives the same one.
nlohmann::json repeatable_run(const RunRecord& record);

/// The folder of one case (docs/contract.md: "A case folder").
class CaseFolder {
 public:
  explicit CaseFolder(std::filesystem::path root) : root_(std::move(root)) {}

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path folder(Stage stage) const { return root_ / name(stage); }
  [[nodiscard]] std::filesystem::path path(const std::string& relative) const {
    return root_ / relative;
  }
  [[nodiscard]] bool exists(const std::string& relative) const {
    return std::filesystem::exists(root_ / relative);
  }

  /// Makes the folder, or takes up one that belongs to the same input.
  /// @throws IoError (73) if it belongs to another case or is not ours, unless `force`
  void claim(const RunRecord& wanted, bool force) const;

  /// An empty record if there is no run.json.
  [[nodiscard]] RunRecord read_record() const;
  /// Is run.json as write_record() left it, by the hash that it holds of itself? One without a hash
  /// is of an older program.
  [[nodiscard]] bool is_record_intact() const;
  void write_record(const RunRecord& record) const;

  /// The SHA-256 of each of the case's files named, and of all files in the folders named (with a
  /// '/' at the end); missing ones are left out.
  [[nodiscard]] std::map<std::string, std::string> hashes(
      const std::vector<std::string>& relative) const;
  /// Of every file that a stage has left.
  [[nodiscard]] std::map<std::string, std::string> hashes(Stage stage) const;

  /// Whether a stage's outputs are whole and made from these very inputs and options.
  [[nodiscard]] bool is_up_to_date(const StageRecord& record, const std::string& key) const;

 private:
  std::filesystem::path root_;
};

/// A folder that one process has for itself, or that some share; freed when the process ends. A
/// file system without locks (some network mounts) is used without.
class FolderLock {
 public:
  enum class Kind { own, shared };
  FolderLock(const std::filesystem::path& folder, Kind kind);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  /// Whether another process keeps this one out.
  [[nodiscard]] bool is_refused() const { return is_refused_; }

 private:
  int folder_ = -1;
  bool is_refused_ = false;
};

/// Keeps a second run out of a case while the first is at work.
class CaseLock {
 public:
  /// @throws IoError (73) if another process holds it
  explicit CaseLock(const CaseFolder& case_folder);

 private:
  FolderLock lock_;
};

/// A stage's folder in the making: appears in the case at once, when it is whole, by commit();
/// otherwise it is removed and the case is as it was.
class StageFolder {
 public:
  StageFolder(const CaseFolder& case_folder, Stage stage);
  ~StageFolder();
  StageFolder(const StageFolder&) = delete;
  StageFolder& operator=(const StageFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
  /// Puts the folder in place of the former one.
  void commit();

 private:
  std::filesystem::path final_;
  std::filesystem::path temporary_;
};

}  // namespace angio::pipeline
