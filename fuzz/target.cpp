#include "fuzz/target.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

#include "core/error.hpp"

namespace angio::fuzz {
namespace fs = std::filesystem;
namespace {

/// Removed at the end, if there is an orderly one.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("angio-fuzz-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "a fuzz target threw what no user should see: %s\n", what);
  std::abort();
}

}  // namespace

int run_target(Target target, std::string_view bytes) {
  try {
    target(bytes);
  } catch (const Error& error) {
    if (error.exit_code() == ExitCode::internal) fail(error.what());
  } catch (const std::exception& error) {
    fail(error.what());
  }
  return 0;
}

fs::path file_of(std::string_view bytes, const char* name) {
  static const Folder folder;
  const fs::path file = folder.path() / name;
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  return file;
}

}  // namespace angio::fuzz
