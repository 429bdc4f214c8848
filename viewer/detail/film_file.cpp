#include "viewer/detail/film_file.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOggTheoraWriter.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/error.hpp"
#include "core/text.hpp"

namespace angio::viewer::detail {
namespace fs = std::filesystem;

class FilmFile::Encoder {
 public:
  Encoder() = default;
  virtual ~Encoder() = default;
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  virtual void add(const Picture& picture) = 0;
  virtual bool close() = 0;
};

namespace {

/// By OpenCV: FFmpeg's codecs for .mp4, its own motion JPEG for .avi.
class OpenCvEncoder : public FilmFile::Encoder {
 public:
  OpenCvEncoder(const fs::path& file, FilmKind kind, const cv::Size& size, double rate) {
    if (kind == FilmKind::avi) {
      writer_.open(file.string(), cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                   rate, size);
      return;
    }
    writer_.open(file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('a', 'v', 'c', '1'), rate,
                 size);
    if (!writer_.isOpened())  // an FFmpeg without H.264
      writer_.open(file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate,
                   size);
  }

  [[nodiscard]] bool is_open() const { return writer_.isOpened(); }

  void add(const Picture& picture) override {
    const cv::Mat rgb(picture.height, picture.width, CV_8UC3,
                      const_cast<std::uint8_t*>(picture.rgb.data()));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    writer_.write(bgr);
  }

  bool close() override {
    writer_.release();
    return true;  // OpenCV does not say
  }

 private:
  cv::VideoWriter writer_;
};

/// By VTK, which brings the Theora encoder along.
class TheoraEncoder : public FilmFile::Encoder {
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
    auto* pixels = static_cast<std::uint8_t*>(image_->GetScalarPointer());
    const std::size_t row_bytes = std::size_t(picture.width) * 3;
    for (std::size_t row = 0; row < std::size_t(picture.height); ++row)  // VTK's from the bottom
      std::copy_n(picture.rgb.data() + (std::size_t(picture.height) - 1 - row) * row_bytes,
                  row_bytes, pixels + row * row_bytes);
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

FilmFile::FilmFile(const fs::path& file, int width, int height, int pictures_per_second)
    : file_(file) {
  const FilmKind kind = film_kind(file);
  if (kind == FilmKind::ogv) {
    encoder_ = std::make_unique<TheoraEncoder>(file, width, height, pictures_per_second);
    return;
  }
  auto encoder =
      std::make_unique<OpenCvEncoder>(file, kind, cv::Size(width, height), pictures_per_second);
  if (!encoder->is_open())
    throw Error(ExitCode::unavailable,
                kind == FilmKind::mp4
                    ? "no .mp4 can be written here (the codecs of FFmpeg are missing in OpenCV). "
                      "Give a name ending in .avi or .ogv"
                    : "no .avi can be written here (OpenCV could not open it). Give a name ending "
                      "in .ogv");
  encoder_ = std::move(encoder);
}

FilmFile::~FilmFile() = default;

void FilmFile::add(const Picture& picture) { encoder_->add(picture); }

void FilmFile::close() {
  std::error_code error;
  if (!encoder_->close() || fs::file_size(file_, error) == 0 || error)
    throw IoError("cannot write the film. Is the disk full?");
}

}  // namespace angio::viewer::detail
