#include "core/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "core/error.hpp"

namespace angio {
namespace fs = std::filesystem;
namespace {

fs::path temporary_name(const fs::path& path) {
  return path.parent_path() / ("." + path.stem().string() + ".tmp-" + std::to_string(getpid()) +
                               path.extension().string());
}

void sync(const fs::path& path, int flags) {
  const int file = open(path.c_str(), flags | O_CLOEXEC);
  const int status = file < 0 ? -1 : fsync(file);
  const int error = errno;
  if (file >= 0) close(file);
  // A folder on some network file systems cannot be synced; that alone loses no data.
  if (status != 0 && error != EINVAL)
    throw IoError("could not write " + path.filename().string() + " (" + std::strerror(error) +
                  "). Is the disk full?");
}

}  // namespace

void make_folder(const fs::path& folder) {
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw IoError("cannot create the folder " + folder.string() + " (" +
                      (error ? error.message() : "a file of that name is in the way") +
                      "). Choose another with -o",
                  ExitCode::cannot_create);
}

void write_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  make_folder(path.parent_path());
  const fs::path temporary = temporary_name(path);
  try {
    write(temporary);
    sync(temporary, O_RDONLY);
    std::error_code error;
    fs::rename(temporary, path, error);
    if (error)
      throw IoError("cannot create " + path.string() + " (" + error.message() + ")",
                    ExitCode::cannot_create);
    sync(path.has_parent_path() ? path.parent_path() : fs::path("."), O_RDONLY | O_DIRECTORY);
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

void write_text_atomically(const fs::path& path, std::string_view text) {
  write_atomically(path, [&](const fs::path& temporary) {
    errno = 0;
    std::ofstream file(temporary, std::ios::binary);
    if (!file)
      throw IoError("cannot create " + path.string() + " (" + std::strerror(errno) +
                        "). Check the folder's permissions, or write to another",
                    ExitCode::cannot_create);
    file.write(text.data(), std::streamsize(text.size()));
    file.close();
    if (!file)
      throw IoError("could not write " + path.string() + " (" + std::strerror(errno) +
                    "). Is the disk full?");
  });
}

std::string read_text(const fs::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::array<char, 1 << 16> block;
  while (file.read(block.data(), block.size()) || file.gcount() > 0)
    text.append(block.data(), std::size_t(file.gcount()));
  // A folder can be opened like a file; reading it is what fails.
  if (!file.is_open() || file.bad())
    throw IoError("cannot read " + path.string() + " (" + std::strerror(errno) + ")",
                  fs::exists(path) ? ExitCode::io : ExitCode::no_input);
  return text;
}

}  // namespace angio
