#include "segmentation/detail/dicom_pictures.hpp"

#include <omp.h>

#include <algorithm>
#include <utility>

#include "core/parallel.hpp"
#include "segmentation/detail/open_shapes.hpp"

namespace angio::segmentation::detail {

DicomPictures::DicomPictures(DicomHeader header) : headers_{std::move(header)} {
  DicomPixels& pixels = headers_.front().pixels;
  const auto& run = headers_.front().projection;
  // MONOCHROME1 is how to show the pixels; what they are says the sign.
  pixels.is_monochrome1 = run && run->is_inverted;
  if (run) open_ = open_pixels(run->open_shapes, pixels.columns, pixels.rows);
}

void DicomPictures::read_into(int first, int count, float* pixels) const {
  if (count == 1 && !follows(first)) {
    const std::vector<float> one = read_some({first});
    std::copy(one.begin(), one.end(), pixels);
    return;
  }
  const std::lock_guard lock(mutex_);
  if (streams_.empty() || first != next_) start(first);
  try {
    take(first, count, pixels);
  } catch (...) {
    streams_.clear();
    throw;
  }
  cover(std::size_t(count), pixels);
  next_ = first + count;
  if (next_ == int(headers_.front().frames.size())) streams_.clear();
}

std::vector<float> DicomPictures::read_some(const std::vector<int>& frames) const {
  std::vector<SliceReference> members;
  for (const int frame : frames) members.push_back({0, frame});
  std::vector<float> pixels = decode_frames(headers_, members);
  cover(frames.size(), pixels.data());
  return pixels;
}

std::vector<char> DicomPictures::covered() const {
  std::vector<char> is_covered(open_.size());
  for (std::size_t i = 0; i < open_.size(); ++i) is_covered[i] = open_[i] == int(i) ? 0 : 1;
  return is_covered;
}

void DicomPictures::cover(std::size_t count, float* pixels) const {
  for (std::size_t f = 0; f < count && !open_.empty(); ++f) {
    float* frame = pixels + f * per_frame();
    for (std::size_t i = 0; i < open_.size(); ++i) frame[i] = frame[open_[i]];
  }
}

std::size_t DicomPictures::per_frame() const { return headers_.front().pixels.per_frame(); }

void DicomPictures::take(int first, int count, float* pixels) const {
  const int taking_turns = int(streams_.size());
  parallel_for(taking_turns, [&](std::ptrdiff_t n) {
    // The stream of the frames whose number is n more than a multiple from begin_ on.
    const int offset = ((int(n) - (first - begin_)) % taking_turns + taking_turns) % taking_turns;
    for (int f = offset; f < count; f += taking_turns)
      streams_[std::size_t(n)]->next(pixels + std::size_t(f) * per_frame());
  });
}

bool DicomPictures::follows(int first) const {
  const std::lock_guard lock(mutex_);
  return !streams_.empty() && first == next_;
}

void DicomPictures::start(int first) const {
  constexpr int kMostStreams = 4;
  streams_.clear();
  begin_ = first;
  const int taking_turns = std::min(kMostStreams, omp_get_max_threads());
  for (int n = 0; n < taking_turns; ++n)
    streams_.push_back(std::make_unique<FrameStream>(headers_.front(), first + n, taking_turns));
}

}  // namespace angio::segmentation::detail
