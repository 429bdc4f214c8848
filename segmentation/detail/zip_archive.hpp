#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace angio::segmentation::detail {

/// Whether a file begins like a zip archive.
bool is_zip_archive(const std::filesystem::path& path);

/// A zip archive whose files are unpacked into memory, never onto the disk: names in it are not
/// used as paths, so none can leave a folder.
class ZipArchive {
 public:
  struct Entry {
    std::int64_t index = 0;
    std::uint64_t size = 0;  ///< unpacked [bytes]
  };

  /// @throws InputError if it is damaged, locked with a password, or would unpack to a size that
  ///         no scan has (a zip bomb)
  explicit ZipArchive(const std::filesystem::path& path);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// The files in it, by name.
  [[nodiscard]] std::vector<Entry> entries() const;

  /// The bytes of one file, at most `limit` of them.
  /// @throws InputError if they are damaged
  [[nodiscard]] std::vector<char> read(std::int64_t index, std::uint64_t limit) const;

 private:
  struct Handle;
  std::unique_ptr<Handle> handle_;
};

}  // namespace angio::segmentation::detail
