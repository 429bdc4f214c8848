#include "viewer/detail/film_file.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOggTheoraWriter.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/error.hpp"
#include "core/text.hpp"
#include "viewer/detail/film_encoder.hpp"

namespace angio::viewer::detail {
namespace fs = std::filesystem;

namespace {

/// The codecs of FFmpeg load 160 libraries, 0.3 s of every command; so they wait until a film asks.
MakeFilmEncoder* load_codecs() {
  void* codecs = dlopen("libangio_film_codecs.so", RTLD_NOW | RTLD_LOCAL);
  if (!codecs)
    throw Error(ExitCode::unavailable,
                fmt::format("no .mp4 or .avi can be written here (the program's film codecs cannot "
                            "be loaded: {}). Install angio whole, or give a name ending in .ogv",
                            dlerror()));
  return reinterpret_cast<MakeFilmEncoder*>(dlsym(codecs, "make_film_encoder"));
}

/// By VTK, which brings the Theora encoder along.
class TheoraEncoder : public FilmEncoder {
 public:
  TheoraEncoder(const fs::path& file, int width, int height, int rate) {
    image_->SetDimensions(width, height, 1);
    image_->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    writer_->SetInputData(image_);
    writer_->SetFileName(file.c_str());
    writer_->SetRate(rate);
    writer_->SetQuality(2);
  }

  void add(const Picture& picture) override {
    copy_upside_down(picture, static_cast<std::uint8_t*>(image_->GetScalarPointer()));
    image_->Modified();
    if (!is_started_) writer_->Start();
    is_started_ = true;
    writer_->Write();
  }

  bool close() override {
    if (is_started_) writer_->End();
    return writer_->GetError() == 0;
  }

 private:
  vtkNew<vtkImageData> image_;
  vtkNew<vtkOggTheoraWriter> writer_;
  bool is_started_ = false;
};

}  // namespace

FilmKind film_kind(const fs::path& film) {
  const std::string extension = lower_extension(film);
  if (extension == ".mp4") return FilmKind::mp4;
  if (extension == ".avi") return FilmKind::avi;
  if (extension == ".ogv") return FilmKind::ogv;
  throw Error(ExitCode::usage, "no film can be written as " + film.filename().string() +
                                   " (the ending names no format known here). Give a name ending "
                                   "in .mp4, .avi or .ogv");
}

FilmFile::FilmFile(const fs::path& file, const fs::path& name, int width, int height,
                   int pictures_per_second)
    : file_(file), name_(name) {
  const FilmKind kind = film_kind(file);
  const bool was_there = fs::exists(file);
  if (!std::ofstream(file, std::ios::app))
    throw IoError(
        "cannot write " + name.string() + " (" + std::strerror(errno) + "). Choose another place",
        ExitCode::cannot_create);
  if (kind == FilmKind::ogv) {
    encoder_ = std::make_unique<TheoraEncoder>(file, width, height, pictures_per_second);
    return;
  }
  encoder_ = std::unique_ptr<FilmEncoder>(
      load_codecs()(file.c_str(), kind == FilmKind::mp4, width, height, pictures_per_second));
  if (!encoder_ && !was_there) fs::remove(file);
  if (!encoder_)
    throw Error(ExitCode::unavailable,
                kind == FilmKind::mp4
                    ? "no .mp4 can be written here (the codecs of FFmpeg are missing in OpenCV). "
                      "Give a name ending in .avi or .ogv"
                    : "no .avi can be written here (OpenCV could not open it). Give a name ending "
                      "in .ogv");
}

FilmFile::~FilmFile() = default;

void FilmFile::add(const Picture& picture) { encoder_->add(picture); }

void FilmFile::close() {
  std::error_code error;
  if (!encoder_->close() || fs::file_size(file_, error) == 0 || error)
    throw IoError("cannot write " + name_.string() + ". Is the disk full?");
}

}  // namespace angio::viewer::detail
