#pragma once

#include "viewer/detail/picture.hpp"

namespace angio::viewer::detail {

/// Writes a film's pictures, one after the other.
class FilmEncoder {
 public:
  FilmEncoder() = default;
  virtual ~FilmEncoder() = default;
  FilmEncoder(const FilmEncoder&) = delete;
  FilmEncoder& operator=(const FilmEncoder&) = delete;
  virtual void add(const Picture& picture) = 0;
  virtual bool close() = 0;  ///< whether all was written, where the encoder tells
};

/// What the module libangio_film_codecs.so has, as `make_film_encoder`.
/// @param is_mp4  else AVI
/// @param width, height  [pixel], even
/// @param rate  [1/s]
/// @return null where the codec is missing
using MakeFilmEncoder = FilmEncoder*(const char* file, bool is_mp4, int width, int height,
                                     int rate);

}  // namespace angio::viewer::detail
