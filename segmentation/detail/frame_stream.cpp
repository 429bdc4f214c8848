#include "segmentation/detail/frame_stream.hpp"

#include "core/error.hpp"

namespace angio::segmentation::detail {
namespace {

struct NoMoreWanted : std::exception {};

}  // namespace

FrameStream::FrameStream(const DicomHeader& header, int first, int every)
    : header_(header), thread_([this, first, every] { run(first, every); }) {}

FrameStream::~FrameStream() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  asked_.notify_one();
  thread_.join();
}

void FrameStream::run(int first, int every) {
  std::exception_ptr error;
  try {
    std::vector<SliceReference> frames;
    for (int f = first; f < int(header_.frames.size()); f += every) frames.push_back({0, f});
    decode_each({header_}, frames, [&](std::size_t n, const StoredPixels& pixels) {
      give(header_, frames[n].frame, pixels);
    });
  } catch (const NoMoreWanted&) {
    return;
  } catch (...) {
    error = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  error_ = error;
  done_.notify_one();
}

void FrameStream::give(const DicomHeader& header, int frame, const StoredPixels& pixels) {
  std::unique_lock lock(mutex_);
  asked_.wait(lock, [this] { return wanted_ || is_over_; });
  if (is_over_) throw NoMoreWanted();
  rescale(header, frame, pixels, wanted_);
  wanted_ = nullptr;
  done_.notify_one();
}

void FrameStream::next(float* values) {
  std::unique_lock lock(mutex_);
  wanted_ = values;
  asked_.notify_one();
  done_.wait(lock, [this] { return !wanted_ || is_over_; });
  if (!wanted_) return;
  wanted_ = nullptr;
  if (error_) std::rethrow_exception(error_);
  throw InternalError("more frames were asked for than there are");
}

}  // namespace angio::segmentation::detail
