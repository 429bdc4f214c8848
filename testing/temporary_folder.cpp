#include "testing/temporary_folder.hpp"

#include <unistd.h>

#include <cstdlib>
#include <system_error>

namespace angio::test {
namespace {

constexpr const char* kKeepVariable = "ANGIO_KEEP_TEST_FILES";

}  // namespace

TemporaryFolder::TemporaryFolder() {
  if (const char* kept = std::getenv(kKeepVariable)) {
    path_ = kept;
    std::filesystem::create_directories(path_);
    return;
  }
  std::string name = (std::filesystem::temp_directory_path() / "angio-test-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::system_error(errno, std::generic_category(), name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  if (std::getenv(kKeepVariable)) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace angio::test
