#include "reconstruction/detail/ramp_filter.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/units.hpp"
#include "reconstruction/detail/row_ends.hpp"

namespace angio::reconstruction::detail {
namespace {

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

}  // namespace

std::vector<float> ramp_response(int length, double spacing_mm, FilterWindow window) {
  std::vector<float> kernel(std::size_t(length), 0.0F);
  std::vector<float> spectrum = kernel;
  {
    const std::lock_guard lock(planner());
    fftwf_plan plan =
        fftwf_plan_r2r_1d(length, kernel.data(), spectrum.data(), FFTW_R2HC, FFTW_ESTIMATE);
    kernel[0] = float(1.0 / (4.0 * spacing_mm));
    for (int n = 1; n <= length / 2; n += 2)
      kernel[std::size_t(n)] = kernel[std::size_t(length - n)] =
          float(-1.0 / (units::kPi * units::kPi * n * n * spacing_mm));
    fftwf_execute(plan);
    fftwf_destroy_plan(plan);
  }
  std::vector<float> response;
  for (int f = 0; f <= length / 2; ++f)  // h is even: its spectrum is real, and comes first
    response.push_back(
        float(double(spectrum[std::size_t(f)]) * window_at(window, 2.0 * f / length) / length));
  return response;
}

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
      spacing_mm_(spacing_mm),
      response_(ramp_response(length_, spacing_mm, window)) {
  const Workspace buffers(*this);
  float* values = buffers.buffers_->values;
  fftwf_complex* spectrum = buffers.buffers_->spectrum;
  const std::lock_guard lock(planner());
  // ESTIMATE, so that the same plan, hence the same bits, comes every time.
  plans_->forward = fftwf_plan_dft_r2c_1d(length_, values, spectrum, FFTW_ESTIMATE);
  plans_->backward = fftwf_plan_dft_c2r_1d(length_, spectrum, values, FFTW_ESTIMATE);
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
  const auto pixel = [row](int i) { return row[i]; };
  const WaterEdge first = water_edge(row_end(pixel, columns_, false), spacing_mm_),
                  last = water_edge(row_end(pixel, columns_, true), spacing_mm_);
  for (int i = 0; i < beyond_; ++i) {
    values[beyond_ - 1 - i] = first.beyond(i, spacing_mm_);
    values[beyond_ + columns_ + i] = last.beyond(i, spacing_mm_);
  }
  fftwf_execute_dft_r2c(plans_->forward, values, spectrum);
  for (int f = 0; f <= length_ / 2; ++f) {
    spectrum[f][0] *= response_[std::size_t(f)];
    spectrum[f][1] *= response_[std::size_t(f)];
  }
  fftwf_execute_dft_c2r(plans_->backward, spectrum, values);
  std::copy_n(values + beyond_, columns_, row);
}

bool is_truncated(const float* row, int columns) {
  const auto pixel = [row](int i) { return row[i]; };
  return is_within_body(row_end(pixel, columns, false)) ||
         is_within_body(row_end(pixel, columns, true));
}

}  // namespace angio::reconstruction::detail
