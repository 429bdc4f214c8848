#include "reconstruction/detail/ramp_filter.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/units.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kWater = 0.0206;     ///< [1/mm] at 60 keV (NIST, Hubbell, Seltzer, NISTIR 5632)
constexpr int kEdge = 8;              ///< pixels that tell a row's value and slope at its end
constexpr double kWithinBody = 0.15;  ///< a line integral of 7 mm of water

std::mutex& planner() {  // FFTW plans one at a time
  static std::mutex mutex;
  return mutex;
}

/// The next length whose only factors are 2, 3 and 5.
int good_length(int least) {
  for (int length = least + least % 2;; length += 2) {
    int rest = length;
    for (const int factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return length;
  }
}

double window_at(FilterWindow window, double part) {  // of the highest frequency
  const double x = 0.5 * units::kPi * part;
  switch (window) {
    case FilterWindow::ram_lak:
      return 1.0;
    case FilterWindow::shepp_logan:
      return x > 0.0 ? std::sin(x) / x : 1.0;
    case FilterWindow::hann:
      return 0.5 * (1.0 + std::cos(units::kPi * part));
  }
  return 1.0;
}

/// A row's value and its slope outward at an end, by a line through the last pixels.
struct RowEnd {
  double value = 0.0, slope = 0.0;
};
RowEnd row_end(const float* row, int columns, bool is_last) {
  const int count = std::min(kEdge, columns);
  double mean = 0.0, rise = 0.0, spread = 0.0;
  const auto at = [&](int i) { return double(row[is_last ? columns - 1 - i : i]); };
  for (int i = 0; i < count; ++i) mean += at(i) / count;
  const double middle = 0.5 * (count - 1);
  for (int i = 0; i < count; ++i) {
    rise += (middle - i) * at(i);  // i grows inward
    spread += (i - middle) * (i - middle);
  }
  const double slope = spread > 0.0 ? rise / spread : 0.0;
  return {mean + slope * middle, slope};
}

/// Fills `beyond` pixels outward from a row's end.
template <class Put>
void go_on(const RowEnd& end, double spacing_mm, int beyond, const Put& put) {
  const double value = std::max(end.value, 0.0), slope = std::min(end.slope / spacing_mm, 0.0);
  const double scale = 1.0 / (4.0 * kWater * kWater);
  const double x = -value * slope * scale;  // of the end, from the cylinder's axis
  const double radius_squared = value * value * scale + x * x;
  for (int i = 0; i < beyond; ++i) {
    const double at = x + (i + 1) * spacing_mm, left = radius_squared - at * at;
    put(i, left > 0.0 ? float(2.0 * kWater * std::sqrt(left)) : 0.0F);
  }
}

}  // namespace

struct RampFilter::Plans {
  fftwf_plan forward = nullptr, backward = nullptr;
};

struct RampFilter::Workspace::Buffers {
  float* values = nullptr;
  fftwf_complex* spectrum = nullptr;
};

RampFilter::Workspace::Workspace(const RampFilter& filter) : buffers_(std::make_unique<Buffers>()) {
  buffers_->values = fftwf_alloc_real(std::size_t(filter.length_));
  buffers_->spectrum = fftwf_alloc_complex(std::size_t(filter.length_ / 2 + 1));
}

RampFilter::Workspace::~Workspace() {
  fftwf_free(buffers_->values);
  fftwf_free(buffers_->spectrum);
}

RampFilter::RampFilter(int columns, double spacing_mm, FilterWindow window)
    : plans_(std::make_unique<Plans>()),
      columns_(columns),
      beyond_(columns / 2),
      length_(good_length(3 * columns)),
      spacing_mm_(spacing_mm) {
  const Workspace buffers(*this);
  float* values = buffers.buffers_->values;
  fftwf_complex* spectrum = buffers.buffers_->spectrum;
  {
    const std::lock_guard lock(planner());
    // ESTIMATE, so that the same plan, hence the same bits, comes every time.
    plans_->forward = fftwf_plan_dft_r2c_1d(length_, values, spectrum, FFTW_ESTIMATE);
    plans_->backward = fftwf_plan_dft_c2r_1d(length_, spectrum, values, FFTW_ESTIMATE);
  }
  std::fill_n(values, length_, 0.0F);
  const double a = spacing_mm;
  values[0] = float(1.0 / (4.0 * a));
  for (int n = 1; n <= length_ / 2; n += 2) {
    const double h = -1.0 / (units::kPi * units::kPi * n * n * a);
    values[n] = values[length_ - n] = float(h);
  }
  fftwf_execute(plans_->forward);
  for (int f = 0; f <= length_ / 2; ++f)  // h is even: its spectrum is real
    response_.push_back(
        float(double(spectrum[f][0]) * window_at(window, 2.0 * f / length_) / length_));
}

RampFilter::~RampFilter() {
  const std::lock_guard lock(planner());
  fftwf_destroy_plan(plans_->forward);
  fftwf_destroy_plan(plans_->backward);
}

void RampFilter::filter(float* row, Workspace& workspace) const {
  float* values = workspace.buffers_->values;
  fftwf_complex* spectrum = workspace.buffers_->spectrum;
  std::fill_n(values, length_, 0.0F);
  std::copy_n(row, columns_, values + beyond_);
  go_on(row_end(row, columns_, false), spacing_mm_, beyond_,
        [&](int i, float value) { values[beyond_ - 1 - i] = value; });
  go_on(row_end(row, columns_, true), spacing_mm_, beyond_,
        [&](int i, float value) { values[beyond_ + columns_ + i] = value; });
  fftwf_execute_dft_r2c(plans_->forward, values, spectrum);
  for (int f = 0; f <= length_ / 2; ++f) {
    spectrum[f][0] *= response_[std::size_t(f)];
    spectrum[f][1] *= response_[std::size_t(f)];
  }
  fftwf_execute_dft_c2r(plans_->backward, spectrum, values);
  std::copy_n(values + beyond_, columns_, row);
}

bool is_truncated(const float* row, int columns) {
  return row_end(row, columns, false).value > kWithinBody ||
         row_end(row, columns, true).value > kWithinBody;
}

}  // namespace angio::reconstruction::detail
