#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "viewer/detail/picture.hpp"

namespace angio::viewer::detail {

class FilmEncoder;

/// How a film's file is encoded.
enum class FilmKind { mp4, avi, ogv };

/// By the ending. @throws Error (64) naming the endings that work
FilmKind film_kind(const std::filesystem::path& film);

/// Encodes pictures of one size into a file.
class FilmFile {
 public:
  /// @param file  its ending tells the kind
  /// @param name  of the file in messages
  /// @param width, height  [pixel], even
  /// @param pictures_per_second  [1/s], > 0
  /// @throws Error (69) where no codec is installed for that kind, naming the endings that work
  FilmFile(const std::filesystem::path& file, const std::filesystem::path& name, int width,
           int height, int pictures_per_second);
  ~FilmFile();
  FilmFile(const FilmFile&) = delete;
  FilmFile& operator=(const FilmFile&) = delete;

  void add(const Picture& picture);  ///< of the film's size
  /// Ends the file. @throws IoError (74) if it could not be written
  void close();

 private:
  std::filesystem::path file_, name_;
  std::unique_ptr<FilmEncoder> encoder_;
};

}  // namespace angio::viewer::detail
