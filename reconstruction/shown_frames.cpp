#include "reconstruction/shown_frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "reconstruction/detail/line_integrals.hpp"

namespace angio::reconstruction {
namespace {

using angiogram::ConeBeamFrame;
constexpr int kShown = 8;
constexpr int kLongestSide = 400;

/// Blocks of `block` x `block` pixels as one; what is left over at the right and below is cut.
ConeBeamFrame coarser(const ConeBeamFrame& frame, int block) {
  const double middle = 0.5 * (block - 1);
  return {frame.source,
          frame.place(middle, middle),
          double(block) * frame.column_step,
          double(block) * frame.row_step,
          frame.columns / block,
          frame.rows / block};
}

/// @param to  shape [small.rows, small.columns]
void take_means(const std::vector<float>& picture, int columns, const ConeBeamFrame& small,
                int block, float* to) {
  for (int row = 0; row < small.rows; ++row)
    for (int column = 0; column < small.columns; ++column) {
      double sum = 0.0;
      for (int y = row * block; y < (row + 1) * block; ++y)
        for (int x = column * block; x < (column + 1) * block; ++x)
          sum += double(picture[std::size_t(y) * std::size_t(columns) + std::size_t(x)]);
      *to++ = float(sum / (block * block));
    }
}

}  // namespace

ShownFrames show_frames(const RotationalRun& run, const Reconstruction& result) {
  return show_frames(run, result.frames, result.used,
                     run.masks ? 1.0 : result.quality.unattenuated);
}

ShownFrames show_frames(const RotationalRun& run, const std::vector<ConeBeamFrame>& places,
                        const std::vector<int>& used, double air) {
  ANGIO_EXPECT(!used.empty() && places.size() == run.frames.size());
  const ConeBeamFrame& first = places.front();
  const int count = int(used.size()), shown = std::min(count, kShown);
  const int block = (std::max(first.columns, first.rows) + kLongestSide - 1) / kLongestSide;
  const ConeBeamFrame small = coarser(first, block);
  VolumeGeometry grid;
  grid.size = {small.columns, small.rows, shown};
  grid.spacing = {norm(small.column_step), norm(small.row_step), 1.0};
  ShownFrames out{{}, {}, Volume<float>(grid, 0.0F)};
  for (int n = 0; n < shown; ++n) {
    const int place = shown > 1 ? int(std::lround(double(n) * (count - 1) / (shown - 1))) : 0;
    const int index = used[std::size_t(place)];
    out.indices.push_back(index);
    out.frames.push_back(coarser(places[std::size_t(index)], block));
    take_means(detail::read_line_integrals(run, index, 1, air), first.columns, small, block,
               out.pictures.values.data() + out.pictures.geometry.offset(0, 0, n));
  }
  return out;
}

}  // namespace angio::reconstruction
