#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace angio {

/// Writes a file so that it appears at once and whole: `write` fills a temporary file in the same
/// folder (".NAME.tmp-PID" before the extension, so that format is still told by the extension),
/// which is then synced, renamed to `path`, and the folder synced.
///
/// @param path   the final name; its folder is made if missing
/// @param write  gets the temporary name; if it throws, nothing is left behind
/// @throws IoError  cannot create (73), write failed or the disk is full (74)
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// Writes text the same way.
void write_text_atomically(const std::filesystem::path& path, std::string_view text);

/// The whole file. @throws IoError if it cannot be read.
std::string read_text(const std::filesystem::path& path);

/// Makes a folder and its parents. @throws IoError (73) saying why not.
void make_folder(const std::filesystem::path& folder);

}  // namespace angio
