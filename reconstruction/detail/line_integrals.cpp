#include "reconstruction/detail/line_integrals.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr int kFramesLookedAt = 8;
constexpr double kAirShare = 0.9995;
constexpr float kLeastBeam = 1e-5F;  ///< of I0

/// Do frames hold nothing but the detector's noise? Means of blocks of 8 x 8 pixels scatter by an
/// eighth of it, so that the farthest of a million lie 1.2 of it apart.
/// @param pixels  shape [frames, rows, columns]
bool is_only_noise(const std::vector<float>& pixels, int columns, int rows) {
  constexpr int kBlock = 8;
  constexpr double kFarApart = 1.5;
  std::vector<float> steps;
  double least = std::numeric_limits<double>::max(), most = std::numeric_limits<double>::lowest();
  const std::size_t width = std::size_t(columns), height = std::size_t(rows);
  for (std::size_t first = 0; first < pixels.size(); first += width * height)
    for (std::size_t row = 0; row + kBlock <= height; row += kBlock)
      for (std::size_t column = 0; column + kBlock <= width; column += kBlock) {
        const float* corner = pixels.data() + first + row * width + column;
        steps.push_back(std::abs(corner[1] - corner[0]));
        double sum = 0.0;
        for (std::size_t y = 0; y < kBlock; ++y)
          for (std::size_t x = 0; x < kBlock; ++x) sum += double(corner[y * width + x]);
        least = std::min(least, sum / (kBlock * kBlock));
        most = std::max(most, sum / (kBlock * kBlock));
      }
  if (steps.empty()) return false;
  const auto middle = steps.begin() + std::ptrdiff_t(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double noise = double(*middle) / (0.6745 * std::sqrt(2.0));
  return most - least < kFarApart * noise;
}

/// Of whole frames.
std::vector<float> line_integrals(const RotationalRun& run, std::vector<float> pictures,
                                  const std::vector<float>& masks, double air) {
  const angiogram::ConeBeamFrame& frame = run.frames.front();
  const std::size_t pixels = std::size_t(frame.columns) * std::size_t(frame.rows);
  parallel_for(std::ptrdiff_t(pictures.size() / pixels), [&](std::ptrdiff_t n) {
    const std::size_t at = std::size_t(n) * pixels;
    to_line_integrals(pictures.data() + at, masks.empty() ? nullptr : masks.data() + at, pixels,
                      run.relation, air);
    if (run.open_field)
      cover_shutter(pictures.data() + at, frame.columns, frame.rows, *run.open_field);
  });
  return pictures;
}

}  // namespace

double unattenuated(const RotationalRun& run) {
  const int count = int(run.frames.size()), looked = std::min(count, kFramesLookedAt);
  std::vector<int> spread;
  for (int n = 0; n < looked; ++n) spread.push_back(int(std::int64_t(n) * count / looked));
  std::vector<float> pixels = run.pictures->read_some(spread);
  const auto [least, most] = std::minmax_element(pixels.begin(), pixels.end());
  if (!(*least < *most))
    throw InputError(
        "all pixels of the run are the same (frames of air, or a saturated or empty export). "
        "Export the run again, as the detector had it");
  if (is_only_noise(pixels, run.frames.front().columns, run.frames.front().rows))
    throw InputError(
        "the run's frames hold nothing but noise (frames of air, or of a closed shutter). Give the "
        "run that was taken of the patient");
  const auto place = pixels.begin() + std::ptrdiff_t(kAirShare * double(pixels.size() - 1));
  std::nth_element(pixels.begin(), place, pixels.end());
  if (run.relation == PixelRelation::linear && !(*place > 0.0F))
    throw InputError(
        "the run's pixels are not above zero (a picture that was subtracted before, or a rescaled "
        "one). Export the run as the detector had it");
  return double(*place);
}

BeamRule beam_rule(PixelRelation relation, double air) {
  return {relation == PixelRelation::logarithmic, float(air), kLeastBeam * float(air)};
}

void to_line_integrals(float* pixels, const float* mask, std::size_t count, PixelRelation relation,
                       double air) {
  const BeamRule rule = beam_rule(relation, air);
  for (std::size_t i = 0; i < count; ++i)
    pixels[i] = line_integral(pixels[i], mask ? mask + i : nullptr, rule);
}

void cover_shutter(float* pixels, int columns, int rows, const OpenField& field) {
  for (int row = 0; row < rows; ++row) {
    const int from_row = std::clamp(row, field.first_row, field.last_row);
    for (int c = 0; c < columns; ++c) {
      const int from = std::clamp(c, field.first_column, field.last_column);
      if (from_row != row || from != c)
        pixels[std::size_t(row) * std::size_t(columns) + std::size_t(c)] =
            pixels[std::size_t(from_row) * std::size_t(columns) + std::size_t(from)];
    }
  }
}

std::vector<float> read_line_integrals(const RotationalRun& run, int first, int count, double air) {
  return line_integrals(run, run.pictures->read(first, count),
                        run.masks ? run.masks->read(first, count) : std::vector<float>(), air);
}

std::vector<float> read_line_integrals(const RotationalRun& run, const std::vector<int>& frames,
                                       double air) {
  return line_integrals(run, run.pictures->read_some(frames),
                        run.masks ? run.masks->read_some(frames) : std::vector<float>(), air);
}

}  // namespace angio::reconstruction::detail
