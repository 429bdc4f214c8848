#pragma once

#include <filesystem>
#include <string>

namespace angio {

/// A new empty folder in the temporary one that only its owner can read; removed with this.
class ScratchFolder {
 public:
  /// @param name  it begins with: "angio-scan"
  /// @throws IoError (73) if it cannot be made
  explicit ScratchFolder(const std::string& name);
  ~ScratchFolder();
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;  ///< empty: moved away
};

}  // namespace angio
