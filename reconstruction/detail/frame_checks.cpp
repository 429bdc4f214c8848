#include "reconstruction/detail/frame_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/statistics.hpp"
#include "reconstruction/detail/box_sum.hpp"
#include "reconstruction/detail/line_integrals.hpp"

namespace angio::reconstruction::detail {
namespace {

std::vector<int> spread_frames(const RotationalRun& run, int most) {
  const int count = int(run.frames.size()), taken = std::min(count, most);
  std::vector<int> frames;
  for (int n = 0; n < taken; ++n) frames.push_back(int(std::int64_t(n) * count / taken));
  return frames;
}

/// Brightness and noise of blocks of pixels; those without noise are saturated or covered.
std::vector<std::pair<double, double>> noise_of_blocks(const std::vector<float>& pixels,
                                                       std::size_t columns, std::size_t rows) {
  constexpr std::size_t kBlock = 16;
  const double sd_of_median = 1.0 / (0.6745 * std::sqrt(6.0));  // of second differences
  std::vector<std::pair<double, double>> blocks;
  for (std::size_t first = 0; first < pixels.size(); first += columns * rows)
    for (std::size_t row = 0; row + kBlock <= rows; row += kBlock)
      for (std::size_t column = 0; column + kBlock <= columns; column += kBlock) {
        std::vector<double> bends;
        double sum = 0.0;
        for (std::size_t y = 0; y < kBlock; ++y) {
          const float* line = pixels.data() + first + (row + y) * columns + column;
          for (std::size_t x = 0; x < kBlock; ++x) sum += double(line[x]);
          for (std::size_t x = 1; x + 1 < kBlock; ++x)
            bends.push_back(
                std::abs(double(line[x - 1]) - 2.0 * double(line[x]) + double(line[x + 1])));
        }
        const double noise = sd_of_median * median(std::move(bends));
        if (noise > 0.0) blocks.emplace_back(sum / double(kBlock * kBlock), noise);
      }
  return blocks;
}

/// The median noise of the brightest quarter of blocks to that of the darkest; 0 where the blocks
/// are too few, or too much alike.
double noise_ratio(std::vector<std::pair<double, double>> blocks) {
  constexpr std::size_t kLeast = 64;
  constexpr double kSpread = 10.0;     // of noise, between dark and bright
  constexpr double kLeastNoise = 1.5;  // whole numbers tell no less
  if (blocks.size() < kLeast) return 0.0;
  std::sort(blocks.begin(), blocks.end());
  const std::size_t quarter = blocks.size() / 4;
  std::vector<double> dark, bright;
  for (std::size_t n = 0; n < quarter; ++n) {
    dark.push_back(blocks[n].second);
    bright.push_back(blocks[blocks.size() - 1 - n].second);
  }
  const double of_dark = median(dark), of_bright = median(bright);
  const double apart = blocks[blocks.size() - quarter].first - blocks[quarter].first;
  const bool is_told =
      std::min(of_dark, of_bright) > kLeastNoise && apart > kSpread * std::max(of_dark, of_bright);
  return is_told ? of_bright / of_dark : 0.0;
}

constexpr int kAtATime = 8, kFrames = 3 * kAtATime;  // that tell of the filling
constexpr double kAroundMm = 5.0;

/// What a course of the contrast medium over the frames tells: whether less than a share of what
/// the middle frames show is left at an end.
std::string doubt_of_course(const std::vector<double>& course, double least) {
  // A median of three tells a frame from its noise.
  std::vector<double> smooth;
  for (std::size_t n = 1; n + 1 < course.size(); ++n)
    smooth.push_back(median(std::vector{course[n - 1], course[n], course[n + 1]}));
  const double full = median(std::vector<double>{smooth.begin() + std::ptrdiff_t(smooth.size() / 4),
                                                 smooth.end() - std::ptrdiff_t(smooth.size() / 4)});
  if (!(full > 0.0) || std::min(smooth.front(), smooth.back()) > least * full) return {};
  const bool comes = smooth.front() < smooth.back();
  return fmt::format(
      "the contrast medium {} during the run (its {} frames hold {:.0f} % of the middle's): what "
      "is "
      "{} looks narrower than it is. Inject earlier and longer, or leave those frames out",
      comes ? "comes in" : "leaves", comes ? "first" : "last",
      100.0 * std::max(0.0, std::min(smooth.front(), smooth.back()) / full),
      comes ? "filled late" : "washed out");
}

/// The places of some slices of a volume that are the most above the mean of the square around.
std::vector<Vec3> bright_places(const Volume<float>& volume) {
  constexpr double kShare = 1e-3;
  constexpr int kSlices = 64;
  const int columns = volume.geometry.size[0], rows = volume.geometry.size[1];
  const int half = std::max(1, int(std::lround(kAroundMm / volume.geometry.spacing.x)));
  const std::size_t area = std::size_t(columns) * std::size_t(rows);
  std::vector<double> sums(area), counts(area, 1.0), room;
  box_sum(counts, columns, rows, half, room);
  std::vector<std::pair<float, std::uint32_t>> above;  // and which voxel: there are under 2^31
  const int step = std::max(1, volume.geometry.size[2] / kSlices);
  for (int k = 0; k < volume.geometry.size[2]; k += step) {
    const std::size_t first = volume.geometry.offset(0, 0, k);
    const float* slice = volume.values.data() + first;
    std::copy_n(slice, area, sums.begin());
    box_sum(sums, columns, rows, half, room);
    for (std::size_t i = 0; i < area; ++i)
      if (const double excess = double(slice[i]) - sums[i] / counts[i]; excess > 0.0)
        above.emplace_back(float(excess), std::uint32_t(first + i));
  }
  const auto kept = std::ptrdiff_t(kShare * double(above.size()));
  std::nth_element(above.begin(), above.begin() + kept, above.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Vec3> places;
  for (auto at = above.begin(); at != above.begin() + kept; ++at) {
    const auto in_slice = int(at->second % area);
    places.push_back(volume.geometry.lps_from_index(
        {double(in_slice % columns), double(in_slice / columns), double(at->second / area)}));
  }
  return places;
}

/// The mean of a frame's line integrals where it sees places, above those of the square around.
double mean_above_surroundings(const std::vector<float>& integrals,
                               const angiogram::ConeBeamFrame& frame,
                               const std::vector<Vec3>& places) {
  const angiogram::ConeBeamView view(frame);
  const double pixel_mm = norm(frame.column_step) * view.see(places.front()).depth;
  const int half = std::max(1, int(std::lround(kAroundMm / pixel_mm)));
  std::vector<double> sums(integrals.begin(), integrals.end()), room;
  box_sum(sums, frame.columns, frame.rows, half, room);
  const double count = (2.0 * half + 1.0) * (2.0 * half + 1.0);
  double sum = 0.0;
  int seen = 0;
  for (const Vec3& place : places) {
    const angiogram::SeenPoint at = view.see(place);
    const auto column = std::ptrdiff_t(std::lround(at.column)),
               row = std::ptrdiff_t(std::lround(at.row));
    if (column < half || row < half || column + half >= frame.columns || row + half >= frame.rows)
      continue;
    const auto i = std::size_t(row * frame.columns + column);
    sum += double(integrals[i]) - sums[i] / count;
    ++seen;
  }
  return seen > 0 ? sum / seen : 0.0;
}

}  // namespace

std::string doubt_of_relation(const RotationalRun& run) {
  constexpr int kFrames = 6;
  constexpr double kClear = 1.2;  // medians of some dozen blocks err by a hundredth
  const angiogram::ConeBeamFrame& frame = run.frames.front();
  const double ratio =
      noise_ratio(noise_of_blocks(run.pictures->read_some(spread_frames(run, kFrames)),
                                  std::size_t(frame.columns), std::size_t(frame.rows)));
  if (ratio <= 0.0) return {};
  const bool is_logarithmic = run.relation == PixelRelation::logarithmic;
  if (is_logarithmic ? ratio < kClear : ratio > 1.0 / kClear) return {};
  return fmt::format(
      "the pixels were taken to be {}, but their noise {} with brightness by {:.1f}, as in {} "
      "ones: "
      "attenuation, and so radii, may be wrong. Export the run as the detector had it",
      is_logarithmic ? "logarithmic (LOG)" : "proportional to the beam (LIN)",
      is_logarithmic ? "rises" : "falls", is_logarithmic ? ratio : 1.0 / ratio,
      is_logarithmic ? "linear" : "logarithmic or inverted");
}

std::string doubt_of_scale(const RotationalRun& run, double air) {
  constexpr int kFrames = 6;
  constexpr double kMost = 16.0;
  if (run.relation != PixelRelation::logarithmic || run.masks) return {};
  const std::vector<float> pixels = run.pictures->read_some(spread_frames(run, kFrames));
  const double most = air - double(*std::min_element(pixels.begin(), pixels.end()));
  if (most < kMost) return {};
  return fmt::format(
      "the pixels are logarithmic (LOG), but with line integrals of up to {:.3g} no beam would be "
      "left: what they were multiplied by is not stated (Rescale Slope). Attenuation is not to "
      "scale; places and widths are",
      most);
}

std::string doubt_of_filling(const RotationalRun& run) {
  constexpr double kFull = 0.65;  // a vessel 100 mm beside the axis looks larger by a quarter
  if (!run.masks || int(run.frames.size()) < kFrames) return {};
  std::vector<double> sums;
  const angiogram::ConeBeamFrame& frame = run.frames.front();
  const std::size_t pixels = std::size_t(frame.columns) * std::size_t(frame.rows);
  const std::vector<int> frames = spread_frames(run, kFrames);
  for (auto from = frames.begin(); from != frames.end(); from += kAtATime) {
    const std::vector<float> integrals =
        read_line_integrals(run, std::vector<int>(from, from + kAtATime), 1.0);
    for (auto at = integrals.begin(); at != integrals.end(); at += std::ptrdiff_t(pixels))
      sums.push_back(std::accumulate(at, at + std::ptrdiff_t(pixels), 0.0));
  }
  return doubt_of_course(sums, kFull);
}

std::string doubt_of_filling(const RotationalRun& run, double air,
                             const std::vector<angiogram::ConeBeamFrame>& frames,
                             const Volume<float>& volume) {
  constexpr double kFull = 0.5;  // turned and overlapping vessels look a third brighter or darker
  if (run.masks || int(run.frames.size()) < kFrames) return {};
  const std::vector<Vec3> places = bright_places(volume);
  if (places.empty()) return {};
  std::vector<double> courses;
  for (const int f : spread_frames(run, kFrames)) {
    const std::vector<float> integrals = read_line_integrals(run, std::vector<int>{f}, air);
    courses.push_back(mean_above_surroundings(integrals, frames[std::size_t(f)], places));
  }
  return doubt_of_course(courses, kFull);
}

}  // namespace angio::reconstruction::detail
