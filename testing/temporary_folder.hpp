#pragma once

#include <filesystem>
#include <string>

namespace angio::test {

/// A new empty folder, removed at the end; or the folder $ANGIO_KEEP_TEST_FILES, which is kept, to
/// look at what a single test makes.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace angio::test
