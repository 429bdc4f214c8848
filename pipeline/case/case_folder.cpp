#include "pipeline/case/case_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <memory>
#include <system_error>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "pipeline/case/running_case.hpp"
#include "pipeline/version.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr const char* kOwnHash = "record_sha256";

class Sha256 {
 public:
  Sha256() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }
  void add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    std::string text;
    for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context_{EVP_MD_CTX_new()};
};

void add_file(Sha256& hash, const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> buffer(1 << 20);
  while (stream) {
    stream.read(buffer.data(), std::streamsize(buffer.size()));
    hash.add({buffer.data(), std::size_t(stream.gcount())});
    throw_if_interrupted();
  }
  if (!stream.eof())
    throw IoError("cannot read a file of the input (permission, or a broken disk)");
}

json to_json(const StageRecord& record) {
  json node = {{"status", record.is_stale ? "stale" : record.status},
               {"key", record.key},
               {"seconds", record.seconds},
               {"peak_memory_mib", record.peak_memory_mib},
               {"solver_seconds", record.solver_seconds},
               {"time_split_s", record.time_split},
               {"inputs", record.inputs},
               {"outputs", record.outputs},
               {"warnings", record.warnings}};
  if (record.is_stale) node["status_then"] = record.status;
  if (!record.build.empty()) node["build"] = record.build;
  if (!record.removed.empty()) node["removed"] = record.removed;
  return node;
}

StageRecord stage_from_json(const json& node) {
  StageRecord record;
  record.status = node.value("status", "not run");
  record.is_stale = record.status == "stale";
  if (record.is_stale) record.status = node.value("status_then", "not run");
  record.key = node.value("key", "");
  record.seconds = node.value("seconds", 0.0);
  record.peak_memory_mib = node.value("peak_memory_mib", 0.0);
  record.solver_seconds = node.value("solver_seconds", 0.0);
  record.time_split = node.value("time_split_s", std::map<std::string, double>{});
  record.inputs = node.value("inputs", std::map<std::string, std::string>{});
  record.outputs = node.value("outputs", std::map<std::string, std::string>{});
  record.build = node.value("build", "");
  for (const std::string& file : node.value("removed", std::vector<std::string>{}))
    if (record.outputs.contains(file)) record.removed.push_back(file);
  record.warnings = node.value("warnings", std::vector<std::string>{});
  return record;
}

[[noreturn]] void refuse_record(const fs::path& file) {
  throw InputError(
      fmt::format("{} is damaged (not the JSON that this program writes). Add --force to "
                  "`angio run` to start again",
                  file.string()));
}

}  // namespace

std::string sha256_of_text(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.hex();
}

std::string sha256_of_path(const fs::path& path) {
  Sha256 hash;
  if (!fs::is_directory(path)) {
    add_file(hash, path);
    return hash.hex();
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied))
    if (entry.is_regular_file() && access(entry.path().c_str(), R_OK) == 0)
      files.push_back(entry.path());  // the others are no part of what is read either
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) add_file(hash, file);
  return hash.hex();
}

void CaseFolder::claim(const RunRecord& wanted, bool force) const {
  if (fs::exists(root_) && !fs::is_directory(root_))
    throw IoError(
        fmt::format("{} is a file (a case is a folder). Choose another with -o", root_.string()),
        ExitCode::cannot_create);
  if (!is_free(*this) && !force) {
    if (!exists("run.json"))
      throw IoError(fmt::format("{} is not empty and is no case of this program (its files could "
                                "be overwritten). Choose another with -o, or add --force",
                                root_.string()),
                    ExitCode::cannot_create);
    const RunRecord present = read_record();
    if (present.input_sha256 != wanted.input_sha256)
      throw IoError(fmt::format("{} belongs to another case (its input was a different one). "
                                "Choose another with -o, or add --force to replace it",
                                root_.string()),
                    ExitCode::cannot_create);
  }
  make_folder(root_);
  if (access(root_.c_str(), W_OK) != 0)
    throw IoError(
        fmt::format("cannot write into {} (no permission). Choose another with -o", root_.string()),
        ExitCode::cannot_create);
}

RunRecord CaseFolder::read_record() const {
  RunRecord record;
  if (!exists("run.json")) return record;
  try {
    const json root = json::parse(read_text(path("run.json")));
    record.case_name = root.value("case", "");
    record.backend = root.value("backend", "");
    record.device = root.value("device", "");
    const json input = root.value("input", json::object());
    record.input_kind = input.value("kind", "");
    record.input_sha256 = input.value("sha256", "");
    record.input_description = input.value("description", "");
    record.files = root.value("files", std::map<std::string, std::string>{});
    for (const auto& [stage, node] : root.at("stages").items())
      record.stages[parse_stage(stage)] = stage_from_json(node);
  } catch (const json::exception&) {
    refuse_record(path("run.json"));
  } catch (const Error& error) {  // an unknown stage
    if (error.exit_code() != ExitCode::usage) throw;
    refuse_record(path("run.json"));
  }
  return record;
}

bool RunRecord::is(Stage stage, std::string_view status) const {
  const auto found = stages.find(stage);
  return found != stages.end() && found->second.status == status && !found->second.is_stale;
}

json to_json(const RunRecord& record) {
  json stages = json::object();
  for (int s = 0; s < kStageCount; ++s) {
    const auto found = record.stages.find(Stage(s));
    if (Stage(s) == Stage::reconstruction && found == record.stages.end()) continue;
    stages[name(Stage(s))] = to_json(found == record.stages.end() ? StageRecord{} : found->second);
  }
  json root = {{"program", "angio"},
               {"version", kVersion},
               {"case", record.case_name},
               {"backend", record.backend},
               {"device", record.device},
               {"input",
                {{"kind", record.input_kind},
                 {"sha256", record.input_sha256},
                 {"description", record.input_description}}},
               {"stages", stages}};
  if (!record.files.empty()) root["files"] = record.files;
  return root;
}

json repeatable_run(const RunRecord& record) {
  return {{"version", kVersion},
          {"backend", record.backend},
          {"device", record.device},
          {"input", record.input_description},
          {"input_sha256", record.input_sha256}};
}

void CaseFolder::write_record(const RunRecord& record) const {
  json root = to_json(record);
  root[kOwnHash] = sha256_of_text(root.dump(2));
  write_text_atomically(path("run.json"), root.dump(2) + "\n");
}

bool CaseFolder::is_record_intact() const {
  const std::string text = read_text(path("run.json"));
  json root = json::parse(text, nullptr, false);
  if (!root.is_object()) return false;
  if (!root.contains(kOwnHash)) return true;
  if (root.dump(2) + "\n" != text) return false;
  const json hash = root[kOwnHash];
  root.erase(kOwnHash);
  return hash == sha256_of_text(root.dump(2));
}

std::map<std::string, std::string> CaseFolder::hashes(
    const std::vector<std::string>& relative) const {
  std::map<std::string, std::string> result;
  for (const std::string& file : relative) {
    if (!exists(file)) continue;
    if (!file.ends_with('/')) {
      result[file] = sha256_of_path(path(file));
      continue;
    }
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path(file)))
      if (entry.is_regular_file())
        result[fs::relative(entry.path(), root_).string()] = sha256_of_path(entry.path());
  }
  return result;
}

std::map<std::string, std::string> CaseFolder::hashes(Stage stage) const {
  return hashes({std::string(name(stage)) + "/"});
}

bool CaseFolder::is_up_to_date(const StageRecord& record, const std::string& key) const {
  constexpr std::array kMade{"done", "given", "skipped"};
  const bool is_made = std::find(kMade.begin(), kMade.end(), record.status) != kMade.end();
  if (!is_made || record.key != key) return false;
  return std::all_of(record.outputs.begin(), record.outputs.end(), [&](const auto& output) {
    return exists(output.first) && sha256_of_path(path(output.first)) == output.second;
  });
}

FolderLock::FolderLock(const fs::path& folder, Kind kind)
    : folder_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  const int wanted = kind == Kind::own ? LOCK_EX : LOCK_SH;
  is_refused_ = folder_ >= 0 && flock(folder_, wanted | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

FolderLock::~FolderLock() {
  if (folder_ >= 0) close(folder_);
}

CaseLock::CaseLock(const CaseFolder& case_folder)
    : lock_(case_folder.root(), FolderLock::Kind::own) {
  if (!lock_.is_refused()) return;
  const std::string who = who_is_at_work(case_folder);
  throw IoError(fmt::format("another run is at work in {}{} (two would spoil each other's "
                            "files). Wait for it, or choose another -o",
                            case_folder.root().string(), who.empty() ? who : ": " + who),
                ExitCode::cannot_create);
}

StageFolder::StageFolder(const CaseFolder& case_folder, Stage stage)
    : final_(case_folder.folder(stage)),
      temporary_(case_folder.root() / fmt::format(".{}.tmp-{}", name(stage), getpid())) {
  // What a killed run of this stage left behind goes first.
  for (const fs::directory_entry& entry : fs::directory_iterator(case_folder.root()))
    if (entry.path().filename().string().starts_with(fmt::format(".{}.tmp-", name(stage))))
      fs::remove_all(entry.path());
  make_folder(temporary_);
}

StageFolder::~StageFolder() {
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

void StageFolder::commit() {
  std::error_code error;
  fs::remove_all(final_, error);
  if (!error) fs::rename(temporary_, final_, error);
  if (error)
    throw IoError(fmt::format("cannot put {} in place ({})", final_.string(), error.message()),
                  ExitCode::cannot_create);
}

}  // namespace angio::pipeline
