#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "segmentation/detail/dicom_pixels.hpp"
#include "segmentation/detail/frame_stream.hpp"
#include "segmentation/read_run.hpp"

namespace angio::segmentation::detail {

/// Frames that are read in their order are decoded ahead, by some processes that take turns.
class DicomPictures : public RunPictures {
 public:
  explicit DicomPictures(DicomHeader header);
  void read_into(int first, int count, float* pixels) const override;
  [[nodiscard]] std::vector<float> read_some(const std::vector<int>& frames) const override;
  [[nodiscard]] std::vector<char> covered() const override;

 protected:
  [[nodiscard]] std::size_t per_frame() const override;

 private:
  void take(int first, int count, float* pixels) const;
  [[nodiscard]] bool follows(int first) const;
  void start(int first) const;
  void cover(std::size_t count, float* pixels) const;

  std::vector<DicomHeader> headers_;
  std::vector<int> open_;  ///< open_pixels()
  // Where reading stands; what is read does not depend on it.
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<FrameStream>> streams_;
  mutable int begin_ = 0, next_ = 0;
};

}  // namespace angio::segmentation::detail
