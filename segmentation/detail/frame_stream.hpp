#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "segmentation/detail/dicom_pixels.hpp"

namespace angio::segmentation::detail {

/// Every n-th frame of an object, one after the other: its child process (decode_each) works on the
/// next while the caller is busy with the last.
class FrameStream {
 public:
  /// @param header  outlives the stream
  FrameStream(const DicomHeader& header, int first, int every);
  ~FrameStream();
  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  /// @param values  of the next frame, shape [rows, columns]
  /// @throws InputError  the pixels are truncated or damaged
  void next(float* values);

 private:
  void run(int first, int every);
  void give(const DicomHeader& header, int frame, const StoredPixels& pixels);

  const DicomHeader& header_;
  std::mutex mutex_;
  std::condition_variable asked_, done_;
  float* wanted_ = nullptr;  ///< where the next frame goes; null: none is asked for
  bool is_over_ = false;     ///< there are no more frames, or no more are wanted
  std::exception_ptr error_;
  std::thread thread_;  ///< the child's parent
};

}  // namespace angio::segmentation::detail
