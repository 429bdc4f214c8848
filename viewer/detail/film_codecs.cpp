// The module libangio_film_codecs.so: films by OpenCV, that is FFmpeg's codecs for .mp4 and
// OpenCV's own motion JPEG for .avi.
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "viewer/detail/film_encoder.hpp"

namespace angio::viewer::detail {
namespace {

class OpenCvEncoder : public FilmEncoder {
 public:
  OpenCvEncoder(const char* file, bool is_mp4, const cv::Size& size, double rate) {
    if (!is_mp4) {
      writer_.open(file, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate,
                   size);
      return;
    }
    writer_.open(file, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('a', 'v', 'c', '1'), rate, size);
    if (!writer_.isOpened())  // an FFmpeg without H.264
      writer_.open(file, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate, size);
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

}  // namespace
}  // namespace angio::viewer::detail

extern "C" angio::viewer::detail::FilmEncoder* make_film_encoder(const char* file, bool is_mp4,
                                                                 int width, int height, int rate) {
  using angio::viewer::detail::OpenCvEncoder;
  auto encoder = std::make_unique<OpenCvEncoder>(file, is_mp4, cv::Size(width, height), rate);
  return encoder->is_open() ? encoder.release() : nullptr;
}
