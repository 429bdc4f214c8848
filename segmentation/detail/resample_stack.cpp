#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "segmentation/detail/stack_geometry.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr float kUncovered = std::numeric_limits<float>::quiet_NaN();
constexpr double kWholePixel = 1e-3;  ///< a shift this near to whole pixels is taken as whole

/// Index of a sample beyond the ends, mirrored at the last ones.
int mirrored(int index, int count) {
  if (count == 1) return 0;
  const int period = 2 * (count - 1);
  index = ((index % period) + period) % period;
  return index < count ? index : period - index;
}

/// Cubic B-spline coefficients of samples, in place.
/// Source: Unser, "Splines", IEEE Signal Processing Magazine 16(6), 1999, Eq. 21 to 24 (pole
/// sqrt(3) - 2, mirrored ends).
void to_spline(std::vector<double>& c) {
  if (c.size() < 2) return;
  const double pole = std::sqrt(3.0) - 2.0;
  const std::size_t count = c.size();
  for (double& value : c) value *= 6.0;
  const std::size_t horizon = std::min<std::size_t>(count, 30);  // pole^30 is below 1e-17
  double power = pole;
  double sum = c[0];
  for (std::size_t n = 1; n < horizon; ++n, power *= pole) sum += power * c[n];
  c[0] = sum;
  for (std::size_t n = 1; n < count; ++n) c[n] += pole * c[n - 1];
  c[count - 1] = (pole / (pole * pole - 1.0)) * (c[count - 1] + pole * c[count - 2]);
  for (std::size_t n = count - 1; n-- > 0;) c[n] = pole * (c[n + 1] - c[n]);
}

/// A row of pixels moved by a shift onto a longer row.
class LineShift {
 public:
  /// @param shift  of the first pixel along the new row [pixels], >= 0
  LineShift(int count, double shift, int new_count)
      : count_(count),
        whole_(std::abs(shift - std::round(shift)) < kWholePixel),
        shift_(whole_ ? std::round(shift) : shift),
        first_(std::max(0, int(std::ceil(shift_ - 0.5)))),
        last_(std::min(new_count - 1, int(std::floor(shift_ + count - 0.5)))) {}

  /// The new pixels that the row covers.
  [[nodiscard]] int first() const { return first_; }
  [[nodiscard]] int last() const { return last_; }

  /// @param line  the row; used up
  /// @param put   put(index, value) for each new pixel that is covered
  template <class Put>
  void apply(std::vector<double>& line, const Put& put) const {
    if (whole_) {
      for (int n = first_; n <= last_; ++n) put(n, line[std::size_t(n - int(shift_))]);
      return;
    }
    to_spline(line);
    for (int n = first_; n <= last_; ++n) {
      const double x = double(n) - shift_;
      const int base = int(std::floor(x));
      const double t = x - double(base);
      const double s = 1.0 - t;
      const auto c = [&](int offset) { return line[std::size_t(mirrored(base + offset, count_))]; };
      put(n, (s * s * s * c(-1) + (4.0 - 6.0 * t * t + 3.0 * t * t * t) * c(0) +
              (4.0 - 6.0 * s * s + 3.0 * s * s * s) * c(1) + t * t * t * c(2)) /
                 6.0);
    }
  }

 private:
  int count_;
  bool whole_;
  double shift_;
  int first_;
  int last_;
};

/// One slice on the grid's plane; what it does not cover stays.
void shift_slice(const float* slice, int columns, int rows, const Vec3& place,
                 const VolumeGeometry& grid, float* out) {
  const int width = grid.size[0];
  const LineShift along_i(columns, place.x / grid.spacing.x, width);
  const LineShift along_j(rows, place.y / grid.spacing.y, grid.size[1]);
  std::vector<double> shifted(std::size_t(width) * std::size_t(rows));
  std::vector<double> line;
  for (int j = 0; j < rows; ++j) {
    const float* row = slice + std::size_t(j) * std::size_t(columns);
    line.assign(row, row + columns);
    along_i.apply(line, [&](int i, double value) {
      shifted[std::size_t(j) * std::size_t(width) + std::size_t(i)] = value;
    });
  }
  line.resize(std::size_t(rows));
  for (int i = along_i.first(); i <= along_i.last(); ++i) {
    line.resize(std::size_t(rows));
    for (int j = 0; j < rows; ++j)
      line[std::size_t(j)] = shifted[std::size_t(j) * std::size_t(width) + std::size_t(i)];
    along_j.apply(line, [&](int j, double value) {
      out[std::size_t(j) * std::size_t(width) + std::size_t(i)] = float(value);
    });
  }
}

/// The slope at knot k of the parabola through it and its neighbours.
double slope_at(const std::vector<double>& z, const std::vector<double>& y, std::size_t k) {
  const auto secant = [&](std::size_t a) { return (y[a + 1] - y[a]) / (z[a + 1] - z[a]); };
  const bool has_before = k > 0 && std::isfinite(y[k - 1]);
  const bool has_after = k + 1 < y.size() && std::isfinite(y[k + 1]);
  if (!has_before) return secant(k);
  if (!has_after) return secant(k - 1);
  const double before = z[k] - z[k - 1];
  const double after = z[k + 1] - z[k];
  return (after * secant(k - 1) + before * secant(k)) / (before + after);
}

/// Cubic Hermite polynomial between knots k and k + 1.
double between(const std::vector<double>& z, const std::vector<double>& y, std::size_t k,
               double height) {
  if (!std::isfinite(y[k]) || !std::isfinite(y[k + 1])) return double(kUncovered);
  const double step = z[k + 1] - z[k];
  const double t = (height - z[k]) / step;
  const double s = 1.0 - t;
  return y[k] * s * s * (1.0 + 2.0 * t) + y[k + 1] * t * t * (3.0 - 2.0 * t) +
         step * t * s * (s * slope_at(z, y, k) - t * slope_at(z, y, k + 1));
}

/// Brings slices at the heights of their places onto the grid's even heights.
std::vector<float> even_out(const std::vector<float>& slices, const StackGeometry& stack) {
  const VolumeGeometry& grid = stack.geometry;
  const std::size_t area = std::size_t(grid.size[0]) * std::size_t(grid.size[1]);
  std::vector<double> z;
  for (const Vec3& place : stack.places) z.push_back(place.z);
  std::vector<float> even(grid.voxel_count());
  parallel_for(grid.size[1], [&](std::ptrdiff_t j) {
    std::vector<double> y(z.size());
    for (int i = 0; i < grid.size[0]; ++i) {
      const std::size_t pixel = std::size_t(j) * std::size_t(grid.size[0]) + std::size_t(i);
      for (std::size_t k = 0; k < z.size(); ++k) y[k] = double(slices[k * area + pixel]);
      std::size_t interval = 0;
      for (int k = 0; k < grid.size[2]; ++k) {
        const double height = std::min(z.front() + k * grid.spacing.z, z.back());
        while (interval + 2 < z.size() && height > z[interval + 1]) ++interval;
        even[std::size_t(k) * area + pixel] = float(between(z, y, interval, height));
      }
    }
  });
  return even;
}

}  // namespace

std::vector<float> resample_stack(const std::vector<float>& slices, int columns, int rows,
                                  const StackGeometry& stack) {
  const VolumeGeometry& grid = stack.geometry;
  const std::size_t slice_size = std::size_t(columns) * std::size_t(rows);
  const std::size_t area = std::size_t(grid.size[0]) * std::size_t(grid.size[1]);
  const float lowest = *std::min_element(slices.begin(), slices.end());
  std::vector<float> shifted(area * stack.places.size(), kUncovered);
  parallel_for(std::ptrdiff_t(stack.places.size()), [&](std::ptrdiff_t k) {
    shift_slice(slices.data() + std::size_t(k) * slice_size, columns, rows,
                stack.places[std::size_t(k)], grid, shifted.data() + std::size_t(k) * area);
  });
  std::vector<float> values = stack.even_heights ? std::move(shifted) : even_out(shifted, stack);
  for (float& value : values)
    if (!std::isfinite(value)) value = lowest;
  return values;
}

}  // namespace angio::segmentation::detail
