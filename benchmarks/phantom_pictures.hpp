#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

#include "reconstruction/reconstruction.hpp"

namespace angio::benchmarks {

/// A phantom's frames, all of them or some.
class PhantomPictures : public reconstruction::FrameReader {
 public:
  /// @param pixels  shape [frame, row, column]; must outlive this
  /// @param per_frame  pixels of a frame
  PhantomPictures(const std::vector<std::uint16_t>& pixels, std::size_t per_frame)
      : PhantomPictures(pixels, per_frame, std::vector<std::size_t>(pixels.size() / per_frame)) {
    std::iota(frames_.begin(), frames_.end(), std::size_t(0));
  }
  /// @param frames  those that it has, in its order
  PhantomPictures(const std::vector<std::uint16_t>& pixels, std::size_t per_frame,
                  std::vector<std::size_t> frames)
      : pixels_(pixels), per_frame_(per_frame), frames_(std::move(frames)) {}
  [[nodiscard]] std::vector<float> read(int first, int count) const override {
    std::vector<float> values;
    for (int f = first; f < first + count; ++f) {
      const auto begin = pixels_.begin() + std::ptrdiff_t(frames_[std::size_t(f)] * per_frame_);
      values.insert(values.end(), begin, begin + std::ptrdiff_t(per_frame_));
    }
    return values;
  }

 private:
  const std::vector<std::uint16_t>& pixels_;
  std::size_t per_frame_;
  std::vector<std::size_t> frames_;
};

}  // namespace angio::benchmarks
