#pragma once

#include <vector>

#include "reconstruction/reconstruction.hpp"
#include "segmentation/read_run.hpp"

namespace angio::pipeline {

/// The reader's frames as the reconstruction takes them.
class LoadedFrames : public reconstruction::FrameReader {
 public:
  /// @param pictures  must outlive this
  explicit LoadedFrames(const segmentation::RunPictures& pictures) : pictures_(pictures) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    return pictures_.read(first, count);
  }
  void read_into(int first, int count, float* pixels) const override {
    pictures_.read_into(first, count, pixels);
  }
  [[nodiscard]] std::vector<float> read_some(const std::vector<int>& frames) const override {
    return pictures_.read_some(frames);
  }

 private:
  const segmentation::RunPictures& pictures_;
};

}  // namespace angio::pipeline
