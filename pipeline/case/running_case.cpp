#include "pipeline/case/running_case.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <system_error>
#include <vector>

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr const char* kNote = ".lock";

/// A temporary file of core/atomic_file.hpp.
bool is_leftover(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with('.') && name.find(".tmp-") != std::string::npos;
}

}  // namespace

LockNote::LockNote(const CaseFolder& folder) : file_(folder.path(kNote)) {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  std::ofstream(file_) << fmt::format("process {} on {}\n", getpid(), host.data());
}

LockNote::~LockNote() {
  std::error_code ignored;
  fs::remove(file_, ignored);
}

std::string who_is_at_work(const CaseFolder& folder) {
  std::ifstream file(folder.path(kNote));
  std::string line;
  std::getline(file, line);
  return line;
}

bool is_free(const CaseFolder& folder) {
  if (!fs::exists(folder.root())) return true;
  if (!fs::is_directory(folder.root())) return false;
  std::error_code unreadable;
  const fs::directory_iterator entries(folder.root(), unreadable);
  return std::all_of(begin(entries), end(entries), [](const fs::directory_entry& entry) {
    return is_leftover(entry.path()) || entry.path().filename() == kNote;
  });
}

void remove_leftovers(const CaseFolder& folder) {
  std::error_code ignored;
  std::vector<fs::path> leftovers;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.root(), ignored))
    if (entry.is_regular_file(ignored) && is_leftover(entry.path()))
      leftovers.push_back(entry.path());
  for (const fs::path& file : leftovers) fs::remove(file, ignored);
}

}  // namespace angio::pipeline
