#include "reconstruction/detail/heart_signal.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/line_integrals.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kSurroundingsMm = 6.0;  ///< to both sides, in a row
constexpr double kFarthestMm = 5.0;      ///< that vessels go from a frame to the next
constexpr int kHarmonics = 3;
constexpr double kSlowPerSecond = 0.5;
constexpr double kSlowestBeat = 40.0 / 60.0, kFastestBeat = 180.0 / 60.0;
constexpr double kRestWidth = 0.2;

/// What stands out of the row around it, row by row.
std::vector<double> profile_of(const float* picture, int columns, int rows, int half) {
  std::vector<double> profile(static_cast<std::size_t>(rows)), sums(std::size_t(columns) + 1);
  for (int r = 0; r < rows; ++r) {
    const float* row = picture + std::size_t(r) * std::size_t(columns);
    for (int c = 0; c < columns; ++c)
      sums[std::size_t(c) + 1] = sums[std::size_t(c)] + double(row[c]);
    double sum = 0.0;
    for (int c = 0; c < columns; ++c) {
      const int from = std::max(0, c - half), to = std::min(columns, c + half + 1);
      const double mean = (sums[std::size_t(to)] - sums[std::size_t(from)]) / (to - from);
      sum += std::max(0.0, double(row[c]) - mean);
    }
    profile[std::size_t(r)] = sum;
  }
  return profile;
}

/// The correlation of a[r] and b[r + shift].
double correlation(const std::vector<double>& a, const std::vector<double>& b, int shift) {
  const int count = int(a.size()), from = std::max(0, -shift), to = std::min(count, count - shift);
  double sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (int r = from; r < to; ++r) {
    const double x = a[std::size_t(r)], y = b[std::size_t(r + shift)];
    sum_a += x;
    sum_b += y;
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  const double n = to - from;
  const double variance = (aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n);
  return variance > 0.0 ? (ab - sum_a * sum_b / n) / std::sqrt(variance) : 0.0;
}

/// By how many rows b lies further down than a.
double shift_between(const std::vector<double>& a, const std::vector<double>& b, int farthest) {
  std::vector<double> fits;
  for (int s = -farthest; s <= farthest; ++s) fits.push_back(correlation(a, b, s));
  const auto best = std::max_element(fits.begin(), fits.end());
  const double whole = double(best - fits.begin()) - farthest;
  if (best == fits.begin() || best + 1 == fits.end()) return 0.0;  // nothing that fits
  const double bend = best[-1] - 2.0 * best[0] + best[1];
  return whole + (bend < 0.0 ? 0.5 * (best[-1] - best[1]) / bend : 0.0);
}

/// Least squares of a signal by slow changes, then by those and a beat.
class BeatFit {
 public:
  BeatFit(const std::vector<double>& signal, const std::vector<double>& times)
      : signal_(Eigen::Map<const Eigen::VectorXd>(signal.data(), Eigen::Index(signal.size()))) {
    const double length = times.back() - times.front();
    slow_ = 1 + int(2.0 * length * kSlowPerSecond);
    terms_.resize(signal_.size(), slow_ + 2 * kHarmonics);
    for (Eigen::Index n = 0; n < signal_.size(); ++n)
      for (int k = 0; k < slow_; ++k)
        terms_(n, k) = std::cos(units::kPi * k * (times[std::size_t(n)] - times.front()) / length);
    const auto slow = terms_.leftCols(slow_);
    slow_squares_ = (signal_ - slow * slow.colPivHouseholderQr().solve(signal_)).squaredNorm();
  }

  Beat fit(const std::vector<double>& phases) {
    for (Eigen::Index n = 0; n < signal_.size(); ++n)
      for (int h = 1; h <= kHarmonics; ++h) {
        const double angle = 2.0 * units::kPi * h * phases[std::size_t(n)];
        terms_(n, slow_ + 2 * h - 2) = std::cos(angle);
        terms_(n, slow_ + 2 * h - 1) = std::sin(angle);
      }
    const double freedom = double(signal_.size() - terms_.cols());
    Beat beat;
    if (freedom < 1.0) return beat;
    const Eigen::VectorXd fit = terms_.colPivHouseholderQr().solve(signal_);
    const double left = (signal_ - terms_ * fit).squaredNorm();
    beat.f_ratio = (slow_squares_ - left) / (2 * kHarmonics) / std::max(left / freedom, 1e-12);
    const Eigen::VectorXd waves = fit.tail(2 * kHarmonics);
    beat.amplitude_mm = std::sqrt(0.5 * waves.squaredNorm());
    beat.resting_phase = rest(waves);
    return beat;
  }

 private:
  /// Where the wave's range within a part of the beat is least.
  static double rest(const Eigen::VectorXd& waves) {
    constexpr int kSteps = 100;
    const int half = int(0.5 * kRestWidth * kSteps);
    const auto wave = [&](int step) {
      double sum = 0.0;
      for (int h = 1; h <= kHarmonics; ++h) {
        const double angle = 2.0 * units::kPi * h * step / kSteps;
        sum += waves[2 * h - 2] * std::cos(angle) + waves[2 * h - 1] * std::sin(angle);
      }
      return sum;
    };
    double least = 0.0, phase = 0.0;
    for (int middle = 0; middle < kSteps; ++middle) {
      double low = wave(middle), high = low;
      for (int step = middle - half; step <= middle + half; ++step) {
        low = std::min(low, wave(step));
        high = std::max(high, wave(step));
      }
      if (middle == 0 || high - low < least) {
        least = high - low;
        phase = double(middle) / kSteps;
      }
    }
    return phase;
  }

  Eigen::VectorXd signal_;
  Eigen::MatrixXd terms_;
  int slow_ = 1;
  double slow_squares_ = 0.0;
};

}  // namespace

std::vector<double> axial_shifts(const RotationalRun& run, double air, const Orbit& orbit,
                                 double pixel_mm, const Progress& progress) {
  const angiogram::ConeBeamFrame& first = run.frames.front();
  const int count = int(run.frames.size());
  const std::size_t pixels = std::size_t(first.columns) * std::size_t(first.rows);
  const int half = std::max(1, int(kSurroundingsMm / pixel_mm));
  const int farthest = std::min(first.rows / 4, int(std::ceil(kFarthestMm / pixel_mm)));
  std::vector<std::vector<double>> profiles(static_cast<std::size_t>(count));
  constexpr int kAtATime = 8;
  for (int from = 0; from < count; from += kAtATime) {
    const int number = std::min(kAtATime, count - from);
    progress.report(double(from) / count,
                    fmt::format("looking for the heartbeat, frame {} of {}", from + 1, count));
    const std::vector<float> integrals = read_line_integrals(run, from, number, air);
    parallel_for(number, [&](std::ptrdiff_t n) {
      profiles[std::size_t(from) + std::size_t(n)] =
          profile_of(integrals.data() + std::size_t(n) * pixels, first.columns, first.rows, half);
    });
  }
  // Rows that go down the detector go along the axis or against it.
  const double along = dot(first.row_step, orbit.axis) > 0.0 ? pixel_mm : -pixel_mm;
  std::vector<double> shifts(static_cast<std::size_t>(count), 0.0);
  for (std::size_t f = 1; f < shifts.size(); ++f)
    shifts[f] = shifts[f - 1] + along * shift_between(profiles[f - 1], profiles[f], farthest);
  return shifts;
}

Beat beat_of(const std::vector<double>& signal, const std::vector<double>& times_s,
             const std::vector<double>& phases) {
  return BeatFit(signal, times_s).fit(phases);
}

Beat find_beat(const std::vector<double>& signal, const std::vector<double>& times_s) {
  BeatFit fit(signal, times_s);
  const double length = times_s.back() - times_s.front();
  const double step = 0.1 / length;  // a tenth of a beat over the run
  Beat best;
  std::vector<double> phases(times_s.size());
  for (double rate = kSlowestBeat; rate <= kFastestBeat; rate += step) {
    for (std::size_t n = 0; n < phases.size(); ++n) phases[n] = rate * (times_s[n] - times_s[0]);
    Beat beat = fit.fit(phases);
    beat.rate_per_s = rate;
    if (beat.f_ratio > best.f_ratio) best = beat;
  }
  return best;
}

}  // namespace angio::reconstruction::detail
