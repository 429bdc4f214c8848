#include "core/scratch_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/error.hpp"

namespace angio {
namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const std::string& name) {
  std::error_code unknown;
  std::string made = (fs::temp_directory_path(unknown) / (name + "-XXXXXX")).string();
  if (mkdtemp(made.data()) == nullptr)  // of mode 0700
    throw IoError("no temporary folder can be made (" + std::string(std::strerror(errno)) +
                      "). Set TMPDIR to a folder with space",
                  ExitCode::cannot_create);
  path_ = made;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

ScratchFolder::ScratchFolder(ScratchFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})) {}

}  // namespace angio
