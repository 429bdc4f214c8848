#include "segmentation/detail/blood_level.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

namespace angio::segmentation::detail {
namespace {

constexpr std::size_t kBinCount = 512;
constexpr double kLeastShare = 0.02;     ///< of the voxels: a tissue
constexpr double kLeastSmoothing = 3.0;  ///< [bins]
constexpr double kValley = 0.85;         ///< of the lower mode beside it: parts two of them
constexpr float kOwnReach = 0.25f;       ///< of the way to the next mode below,
constexpr float kOwnWidths = 2.5f;       ///< and of the mode's width at half its height
constexpr double kOwnPart = 0.25;        ///< of the axes within both: the mode is blood's own
constexpr double kLeastLength = 10.0;    ///< [mm] of even tubes that tell
constexpr double kCommonPart = 0.25;     ///< of the commonest tissue
constexpr float kStandsOut = 0.2f;       ///< of the way from tissue to the level of before
constexpr double kLeastPool = 20000.0;   ///< [mm^3] of even places

/// Intensities on the axes, with their weights.
std::vector<std::pair<float, double>> intensities(const std::vector<TubeAxis>& axes) {
  std::vector<std::pair<float, double>> contrast;
  for (const TubeAxis& axis : axes)
    for (float c : axis.contrast)
      contrast.emplace_back(c, axis.length_share * double(c) * double(c));
  const float most = weighted_quantile(contrast, 0.5);
  std::vector<std::pair<float, double>> intensity;
  for (const TubeAxis& axis : axes)
    for (std::size_t n = 0; n < axis.voxels.size(); ++n) {
      const auto c = double(std::min(axis.contrast[n], most));
      intensity.emplace_back(axis.intensity[n], axis.length_share * c * c);
    }
  return intensity;
}

/// The part of the weights within a range.
double part_within(const std::vector<std::pair<float, double>>& values, float low, float high) {
  double total = 0.0, within = 0.0;
  for (const auto& [value, weight] : values) {
    total += weight;
    if (value >= low && value <= high) within += weight;
  }
  return total > 0.0 ? within / total : 0.0;
}

/// How often values occur, in even bins.
struct Histogram {
  float low = 0.0f, bin = 0.0f;
  std::vector<double> share;  ///< of all voxels, shape [kBinCount]
};

std::vector<float> sample_of(const Volume<float>& volume) {
  constexpr std::size_t kSampleCount = 2000000;
  const std::size_t step = std::max<std::size_t>(1, volume.values.size() / kSampleCount);
  std::vector<float> sample;
  for (std::size_t v = 0; v < volume.values.size(); v += step) sample.push_back(volume.values[v]);
  return sample;
}

/// @param sample  of the volume, not empty
Histogram histogram_of(std::vector<float> sample, float lumen) {
  const auto low = sample.begin() + std::ptrdiff_t(sample.size() / 200);
  std::nth_element(sample.begin(), low, sample.end());
  Histogram histogram{*low, 1.5f * (lumen - *low) / float(kBinCount),
                      std::vector<double>(kBinCount, 0.0)};
  if (!(histogram.bin > 0.0f)) return histogram;
  for (float value : sample) {
    const float place = (value - histogram.low) / histogram.bin;
    const auto b = std::size_t(std::clamp(place, 0.0f, float(kBinCount) + 0.5f));
    if (b < kBinCount) histogram.share[b] += 1.0 / double(sample.size());
  }
  return histogram;
}

std::vector<double> smoothed(const std::vector<double>& values, double sigma) {
  const int reach = int(std::ceil(3.0 * sigma));
  std::vector<double> result(values.size(), 0.0);
  for (int n = 0; n < int(values.size()); ++n) {
    double total = 0.0;
    for (int m = std::max(0, n - reach); m <= std::min(int(values.size()) - 1, n + reach); ++m) {
      const double weight = std::exp(-0.5 * (n - m) * (n - m) / (sigma * sigma));
      result[std::size_t(n)] += weight * values[std::size_t(m)];
      total += weight;
    }
    result[std::size_t(n)] /= total;
  }
  return result;
}

struct Mode {
  std::size_t peak = 0, end = 0;  ///< bins; the end is the valley above
  double share = 0.0;
};

/// Modes from the lowest to the highest, none without a valley to the next.
///
/// @param least  share of the values that a mode has
std::vector<Mode> modes_of(const std::vector<double>& share, double least = kLeastShare) {
  std::vector<Mode> modes;
  Mode current;
  std::size_t valley = 0;
  bool falls = false;
  for (std::size_t b = 0; b < share.size(); ++b) {
    if (share[b] < share[valley]) valley = b;
    if (share[b] > share[current.peak] && !falls) current.peak = valley = b;
    if (share[b] < kValley * share[current.peak]) falls = true;
    if (falls && share[valley] < kValley * share[b]) {
      current.end = valley;
      modes.push_back(current);
      current = {b, 0, 0.0};
      valley = b;
      falls = false;
    } else if (share[b] > share[current.peak]) {
      current.peak = valley = b;
      falls = false;
    }
  }
  current.end = share.size();
  modes.push_back(current);
  std::size_t from = 0;
  for (Mode& mode : modes)
    for (; from < mode.end; ++from) mode.share += share[from];
  std::erase_if(modes, [&](const Mode& mode) { return mode.share < least; });
  return modes;
}

/// The top of the parabola through a peak and its neighbours [bins].
double peak_place(const std::vector<double>& share, std::size_t peak) {
  if (peak == 0 || peak + 1 == share.size()) return double(peak);
  const double a = share[peak - 1], b = share[peak], c = share[peak + 1];
  const double curvature = a - 2.0 * b + c;
  return double(peak) + (curvature < 0.0 ? 0.5 * (a - c) / curvature : 0.0);
}

/// From a peak to where its mode has fallen to half, on the side where that is nearer [bins].
double half_width(const std::vector<double>& share, std::size_t peak) {
  const auto is_low = [&](double value) { return value <= 0.5 * share[peak]; };
  const auto top = share.begin() + std::ptrdiff_t(peak);
  const auto above = std::find_if(top, share.end(), is_low) - top;
  const auto below = std::find_if(std::make_reverse_iterator(top), share.rend(), is_low) -
                     std::make_reverse_iterator(top) + 1;
  // A mode at the end of the range has one side.
  if (std::size_t(below) > peak) return double(above);
  if (std::size_t(above) == share.size() - peak) return double(below);
  return double(std::min(above, below));
}

/// Values and shares, from the darkest to the brightest.
using Tissues = std::vector<std::pair<float, double>>;

/// From the brightest tissue down, the first that is common among those of its kind, not air or
/// lung.
///
/// @param lumen    the value that their kind is counted down from
std::optional<std::size_t> brightest_common(const Tissues& tissues, float lumen) {
  constexpr float kKindReach = 3.0f;  // of the way down from blood: fat and muscle, not air
  for (std::size_t n = tissues.size(); n-- > 0;) {
    double most = 0.0;
    for (const auto& [value, part] : tissues)
      if (lumen - value < kKindReach * (lumen - tissues[n].first)) most = std::max(most, part);
    if (tissues[n].second >= kCommonPart * most) return n;
  }
  return std::nullopt;
}

/// The modes among even places, below a value, with a least share of the places.
Tissues tissues_below(float top, std::vector<float> even, float scale, double least_share) {
  Tissues tissues;
  const Histogram histogram = histogram_of(std::move(even), scale);
  if (!(histogram.bin > 0.0f)) return tissues;
  const std::vector<double> share = smoothed(histogram.share, kLeastSmoothing);
  for (const Mode& mode : modes_of(share, least_share)) {
    const float value = histogram.low + histogram.bin * float(0.5 + peak_place(share, mode.peak));
    if (value < top) tissues.emplace_back(value, mode.share);
  }
  return tissues;
}

BloodLevel even_level(float lumen, float tissue) {
  BloodLevel level;
  level.lumen = lumen;
  level.tissue = tissue;
  level.is_told = level.is_even = true;
  return level;
}

/// @param lumen   of even tubes or pools
/// @param tissue  where no other is common
BloodLevel level_above_tissue(float lumen, std::vector<float> even, float tissue) {
  const Tissues tissues =
      tissues_below(0.5f * (lumen + tissue), std::move(even), lumen, kLeastShare);
  const auto common = brightest_common(tissues, lumen);
  return even_level(lumen, common ? tissues[*common].first : tissue);
}

/// Intensities on axes between two values, with their lengths [mm].
struct OnAxes {
  std::vector<std::pair<float, double>> intensities;
  double length = 0.0;  ///< in all
};

OnAxes on_axes_between(const std::vector<TubeAxis>& axes, float low, float high) {
  OnAxes on;
  for (const TubeAxis& axis : axes)
    for (const float intensity : axis.intensity)
      if (intensity > low && intensity < high) {
        on.intensities.emplace_back(intensity, axis.length_share);
        on.length += axis.length_share;
      }
  return on;
}

/// The median over axes between two values, by length; none if there are less than 10 mm.
std::optional<float> level_on(const std::vector<TubeAxis>& axes, float low, float high) {
  OnAxes on = on_axes_between(axes, low, high);
  if (on.length < kLeastLength) return std::nullopt;
  return weighted_quantile(on.intensities, 0.5);
}

/// Whether pools are organs beside brighter vessels, as kidneys beside an aorta: the even tubes
/// above a value are longer than those at the pools' level (heart and aorta have their own), and
/// stand out of tissue no more than blood does out of what it flows through, unlike metal.
bool are_organs(const BloodLevel& pools, const std::vector<TubeAxis>& axes, float top) {
  constexpr float kMostContrasts = 4.0f;
  OnAxes above = on_axes_between(axes, top, 1e30f);
  if (above.length < std::max(kLeastLength, on_axes_between(axes, pools.half(), top).length))
    return false;
  const float vessels = weighted_quantile(above.intensities, 0.5);
  return vessels < pools.tissue + kMostContrasts * pools.contrast();
}

/// Of the even tubes that stand out of the brightest common tissue.
BloodLevel level_of_darker_tubes(const std::vector<TubeAxis>& axes, std::vector<float> even,
                                 float top) {
  const Tissues tissues = tissues_below(top, std::move(even), top, kLeastShare);
  const auto common = brightest_common(tissues, top);
  if (!common) return {};
  const float tissue = tissues[*common].first;
  const auto lumen = level_on(axes, tissue + kStandsOut * (top - tissue), top);
  if (!lumen) return {};
  BloodLevel level = even_level(*lumen, tissue);
  level.is_of_pools = true;
  return level;
}

/// The largest pool above half of what tubes show.
std::optional<float> level_of_bright_pool(std::vector<float> even, double place_mm3,
                                          const BloodLevel& rough) {
  const double least_share = kLeastPool / (place_mm3 * double(even.size()));
  Tissues pools = tissues_below(1e30f, std::move(even), rough.lumen, least_share);
  std::erase_if(pools, [&](const auto& pool) { return pool.first < rough.half(); });
  if (pools.empty()) return std::nullopt;
  return std::max_element(pools.begin(), pools.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// The largest pool of something rarer than the brightest common tissue.
BloodLevel level_of_pools(std::vector<float> even, double place_mm3, float top) {
  const double all_mm3 = place_mm3 * double(even.size());
  const Tissues tissues = tissues_below(top, std::move(even), top, kLeastPool / all_mm3);
  if (tissues.size() < 2) return {};
  const auto common = brightest_common({tissues.begin(), tissues.end() - 1}, tissues.back().first);
  const auto& [tissue, tissue_share] = tissues[common.value()];
  const auto& [lumen, lumen_share] =
      *std::max_element(tissues.begin() + std::ptrdiff_t(*common) + 1, tissues.end(),
                        [](const auto& a, const auto& b) { return a.second < b.second; });
  if (lumen_share >= kCommonPart * tissue_share) return {};
  BloodLevel level = even_level(lumen, tissue);
  level.is_of_pools = true;
  return level;
}

}  // namespace

float weighted_quantile(std::vector<std::pair<float, double>>& values, double share) {
  std::sort(values.begin(), values.end());
  double total = 0.0, sum = 0.0;
  for (const auto& entry : values) total += entry.second;
  for (const auto& entry : values)
    if ((sum += entry.second) >= share * total) return entry.first;
  return values.empty() ? 0.0f : values.back().first;
}

BloodLevel find_blood_level(const std::vector<TubeAxis>& axes, const Volume<float>& volume,
                            double noise) {
  BloodLevel level;
  if (axes.empty()) return level;
  std::vector<std::pair<float, double>> on_axes = intensities(axes);
  level.lumen = weighted_quantile(on_axes, 0.5);
  const Histogram histogram = histogram_of(sample_of(volume), level.lumen);
  if (!(histogram.bin > 0.0f)) return level;
  const double sigma = std::max(kLeastSmoothing, 0.7 * noise / double(histogram.bin));
  const std::vector<double> share = smoothed(histogram.share, sigma);
  const std::vector<Mode> modes = modes_of(share);
  const float upper =
      weighted_quantile(on_axes, 0.75);  // blood's, though half of the tubes are thin
  bool is_found = false;
  for (std::size_t m = modes.size(); m-- > 0 && !is_found;) {
    const auto value_of = [&](std::size_t n) {
      return histogram.low + histogram.bin * float(0.5 + peak_place(share, modes[n].peak));
    };
    const float mode = value_of(m);
    const float reach =
        m > 0 ? std::min(kOwnReach * (mode - value_of(m - 1)),
                         kOwnWidths * histogram.bin * float(half_width(share, modes[m].peak)))
              : 0.0f;
    if (m > 0 && part_within(on_axes, mode - reach, mode + reach) > kOwnPart) {
      level.lumen = mode;
      level.tissue = value_of(m - 1);
      is_found = true;
    } else if (mode < level.lumen || mode + reach < upper) {
      level.tissue = mode;
      // Vessels darker than tissue are thin ones in lung, whose voxels are part of it.
      std::erase_if(on_axes, [&](const auto& value) { return value.first <= mode; });
      level.lumen = weighted_quantile(on_axes, 0.5);
      is_found = true;
    }
  }
  if (!is_found) return level;
  level.is_told = level.contrast() > 3.0f * float(noise);
  return level;
}

BloodLevel find_even_level(const std::vector<TubeAxis>& axes, std::vector<float> even,
                           double place_mm3, const BloodLevel& rough) {
  if (even.empty()) return {};
  const BloodLevel of_pools = level_of_pools(even, place_mm3, rough.half());
  if (of_pools.is_told && rough.tissue > of_pools.half() &&
      !are_organs(of_pools, axes, rough.half()))
    return of_pools;  // blood, not tissue
  if (const auto tubes = level_on(axes, rough.half(), 1e30f))
    return level_above_tissue(*tubes, std::move(even), rough.tissue);
  if (const auto pool = level_of_bright_pool(even, place_mm3, rough))
    return level_above_tissue(*pool, std::move(even), rough.tissue);
  if (of_pools.is_told) return of_pools;
  return level_of_darker_tubes(axes, std::move(even), rough.half());
}

}  // namespace angio::segmentation::detail
