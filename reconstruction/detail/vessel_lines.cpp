#include "reconstruction/detail/vessel_lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "reconstruction/detail/picture_size.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kRadiusOfScale = 1.0 / 0.6664;
constexpr double kFinestScale = 0.8;    ///< [pixels]
constexpr double kScaleStep = 1.18921;  ///< the fourth root of two
constexpr double kSure = 9.0, kLikely = 4.0;

/// Blurred by a Gaussian; the border's pixels go on outside.
std::vector<float> blurred(const std::vector<float>& picture, const PictureSize& size, double sd) {
  const int half = std::max(1, int(std::ceil(4.0 * sd)));
  std::vector<float> weight(std::size_t(half) + 1);
  float sum = 0.0F;
  for (int k = 0; k <= half; ++k) {
    weight[std::size_t(k)] = float(std::exp(-0.5 * k * k / (sd * sd)));
    sum += (k == 0 ? 1.0F : 2.0F) * weight[std::size_t(k)];
  }
  for (float& w : weight) w /= sum;
  std::vector<float> along(size.count()), both(size.count());
  parallel_for(size.rows, [&](std::ptrdiff_t row) {
    const float* from = picture.data() + size.at(0, int(row));
    for (int c = 0; c < size.columns; ++c) {
      float value = weight[0] * from[c];
      for (int k = 1; k <= half; ++k)
        value += weight[std::size_t(k)] *
                 (from[std::max(c - k, 0)] + from[std::min(c + k, size.columns - 1)]);
      along[size.at(c, int(row))] = value;
    }
  });
  parallel_for(size.rows, [&](std::ptrdiff_t row) {
    for (int c = 0; c < size.columns; ++c) {
      float value = weight[0] * along[size.at(c, int(row))];
      for (int k = 1; k <= half; ++k)
        value +=
            weight[std::size_t(k)] * (along[size.at(c, std::max(int(row) - k, 0))] +
                                      along[size.at(c, std::min(int(row) + k, size.rows - 1))]);
      both[size.at(c, int(row))] = value;
    }
  });
  return both;
}

/// Of each pixel, at the scale of its largest response.
struct Ridges {
  std::vector<float> response;            ///< R
  std::vector<float> sureness;            ///< l over its spread
  std::vector<float> scale;               ///< [pixels]
  std::vector<float> across_x, across_y;  ///< unit, across the ridge
};

void take_scale(const std::vector<float>& picture, const PictureSize& size, double scale,
                Ridges& ridges) {
  const std::vector<float> smooth = blurred(picture, size, scale);
  std::vector<float> least(size.count(), 0.0F), nx(size.count(), 1.0F), ny(size.count(), 0.0F);
  parallel_for(size.rows, [&](std::ptrdiff_t r) {
    const int row = int(r);
    if (row == 0 || row + 1 == size.rows) return;
    for (int c = 1; c + 1 < size.columns; ++c) {
      const auto value = [&](int dx, int dy) { return double(smooth[size.at(c + dx, row + dy)]); };
      const double middle = value(0, 0);
      const double xx = value(1, 0) - 2.0 * middle + value(-1, 0),
                   yy = value(0, 1) - 2.0 * middle + value(0, -1),
                   xy = 0.25 * (value(1, 1) - value(-1, 1) - value(1, -1) + value(-1, -1));
      const double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy), root = std::hypot(half, xy);
      const std::size_t i = size.at(c, row);
      least[i] = float(mean - root);
      const double angle = 0.5 * std::atan2(-xy, -half);  // of the eigenvector of the lesser one
      nx[i] = float(std::cos(angle));
      ny[i] = float(std::sin(angle));
    }
  });
  std::vector<double> magnitudes;
  for (std::size_t i = 0; i < least.size(); i += 3)
    if (least[i] != 0.0F) magnitudes.push_back(std::abs(double(least[i])));
  if (magnitudes.empty()) return;
  const float spread = std::max(float(median(std::move(magnitudes))), 1e-9F);
  const float weight = float(std::pow(scale, 1.5));
  for (std::size_t i = 0; i < least.size(); ++i)
    if (-weight * least[i] > ridges.response[i]) {
      ridges.response[i] = -weight * least[i];
      ridges.sureness[i] = -least[i] / spread;
      ridges.scale[i] = float(scale);
      ridges.across_x[i] = nx[i];
      ridges.across_y[i] = ny[i];
    }
}

float between(const std::vector<float>& values, const PictureSize& size, double column,
              double row) {
  const int c = std::clamp(int(std::floor(column)), 0, size.columns - 2),
            r = std::clamp(int(std::floor(row)), 0, size.rows - 2);
  const float x = float(std::clamp(column - c, 0.0, 1.0)), y = float(std::clamp(row - r, 0.0, 1.0));
  return (1.0F - y) * ((1.0F - x) * values[size.at(c, r)] + x * values[size.at(c + 1, r)]) +
         y * ((1.0F - x) * values[size.at(c, r + 1)] + x * values[size.at(c + 1, r + 1)]);
}

/// Where the response is the largest across the ridge.
std::vector<char> crests(const Ridges& ridges, const PictureSize& size) {
  std::vector<char> is_crest(size.count(), 0);
  for (int row = 2; row + 2 < size.rows; ++row)
    for (int c = 2; c + 2 < size.columns; ++c) {
      const std::size_t i = size.at(c, row);
      if (ridges.sureness[i] < kLikely) continue;
      const double x = ridges.across_x[i], y = ridges.across_y[i];
      is_crest[i] = ridges.response[i] >= between(ridges.response, size, c + x, row + y) &&
                    ridges.response[i] > between(ridges.response, size, c - x, row - y);
    }
  return is_crest;
}

/// Pixels of one crest, also across a gap of a pixel.
std::vector<std::size_t> joined_crest(const std::vector<char>& is_crest, const PictureSize& size,
                                      std::size_t from, std::vector<char>& was_seen) {
  constexpr int kReach = 2;
  std::vector<std::size_t> joined{from};
  was_seen[from] = 1;
  for (std::size_t n = 0; n < joined.size(); ++n) {
    const int c = int(joined[n] % std::size_t(size.columns)),
              row = int(joined[n] / std::size_t(size.columns));
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        if (!size.holds(c + dx, row + dy)) continue;
        const std::size_t next = size.at(c + dx, row + dy);
        if (!is_crest[next] || was_seen[next]) continue;
        was_seen[next] = 1;
        joined.push_back(next);
      }
  }
  return joined;
}

/// What is shorter is no vessel.
bool is_long(std::size_t pixels, std::vector<double> radii) {
  constexpr double kLeastLength = 4.0;  // radii
  constexpr double kFewest = 8.0;       // pixels
  return double(pixels) >= std::max(kFewest, kLeastLength * median(std::move(radii)));
}

bool is_line(const std::vector<std::size_t>& crest, const Ridges& ridges) {
  std::vector<double> sureness, radii;
  for (const std::size_t i : crest) {
    sureness.push_back(double(ridges.sureness[i]));
    radii.push_back(kRadiusOfScale * double(ridges.scale[i]));
  }
  return *std::max_element(sureness.begin(), sureness.end()) >= kSure &&
         is_long(crest.size(), std::move(radii));
}

/// The median of the radii around a line's pixel.
double radius_around(const std::vector<float>& radius, const PictureSize& size, int column, int row,
                     int reach) {
  std::vector<double> near;
  for (int y = std::max(0, row - reach); y <= std::min(size.rows - 1, row + reach); ++y)
    for (int x = std::max(0, column - reach); x <= std::min(size.columns - 1, column + reach); ++x)
      if (radius[size.at(x, y)] > 0.0F) near.push_back(double(radius[size.at(x, y)]));
  return median(std::move(near));
}

/// Each radius by what `change` makes of the one around it.
template <typename Change>
void change_radii(VesselLines& lines, int reach, const Change& change) {
  const PictureSize size{lines.columns, lines.rows};
  const std::vector<float> as_found = lines.radius;
  for (int row = 0; row < size.rows; ++row)
    for (int c = 0; c < size.columns; ++c)
      if (as_found[size.at(c, row)] > 0.0F)
        change(radius_around(as_found, size, c, row, reach), lines.radius[size.at(c, row)]);
}

/// Each radius by its neighbours' median: a scale is picked by pixels that are noisy.
void smooth_radii(VesselLines& lines) {
  constexpr int kReach = 4;
  change_radii(lines, kReach, [](double around, float& radius) { radius = float(around); });
}

}  // namespace

void leave_out_thin(VesselLines& lines, double least) {
  const int reach = std::max(4, int(std::lround(10.0 * least)));
  change_radii(lines, reach, [least](double around, float& radius) {
    if (around < least) radius = 0.0F;
  });
}

std::vector<std::vector<std::size_t>> pieces_of(const VesselLines& lines) {
  const PictureSize size{lines.columns, lines.rows};
  std::vector<char> is_on_line(size.count(), 0), was_seen(size.count(), 0);
  for (std::size_t i = 0; i < is_on_line.size(); ++i) is_on_line[i] = lines.radius[i] > 0.0F;
  std::vector<std::vector<std::size_t>> pieces;
  for (std::size_t i = 0; i < is_on_line.size(); ++i)
    if (is_on_line[i] && !was_seen[i])
      pieces.push_back(joined_crest(is_on_line, size, i, was_seen));
  return pieces;
}

void leave_out_short(VesselLines& lines) {
  for (const std::vector<std::size_t>& piece : pieces_of(lines)) {
    std::vector<double> radii;
    for (const std::size_t i : piece) radii.push_back(double(lines.radius[i]));
    if (is_long(piece.size(), std::move(radii))) continue;
    for (const std::size_t i : piece) lines.radius[i] = 0.0F;
  }
}

bool VesselLines::empty() const {
  return std::all_of(radius.begin(), radius.end(), [](float value) { return value <= 0.0F; });
}

VesselLines find_vessel_lines(const std::vector<float>& picture, int columns, int rows,
                              double widest) {
  const PictureSize size{columns, rows};
  Ridges ridges;
  ridges.response.assign(size.count(), 0.0F);
  ridges.sureness = ridges.scale = ridges.across_y = ridges.response;
  ridges.across_x.assign(size.count(), 1.0F);
  const double widest_radius = std::min(0.5 * widest, 0.2 * std::min(columns, rows));
  for (double scale = kFinestScale; kRadiusOfScale * scale <= widest_radius; scale *= kScaleStep)
    take_scale(picture, size, scale, ridges);
  const std::vector<char> is_crest = crests(ridges, size);
  VesselLines lines{columns, rows, std::vector<float>(size.count(), 0.0F)};
  std::vector<char> was_seen(size.count(), 0);
  for (std::size_t i = 0; i < is_crest.size(); ++i) {
    if (!is_crest[i] || was_seen[i]) continue;
    const std::vector<std::size_t> crest = joined_crest(is_crest, size, i, was_seen);
    if (!is_line(crest, ridges)) continue;
    for (const std::size_t j : crest) lines.radius[j] = float(kRadiusOfScale) * ridges.scale[j];
  }
  smooth_radii(lines);
  return lines;
}

}  // namespace angio::reconstruction::detail
