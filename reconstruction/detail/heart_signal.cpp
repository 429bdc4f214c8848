#include "reconstruction/detail/heart_signal.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/line_integrals.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kWidestMm = 8.0;    ///< of what is followed, in a row
constexpr double kFarthestMm = 5.0;  ///< that vessels go from a frame to the next
constexpr int kHarmonics = 3;
constexpr double kSlowPerSecond = 0.5;
constexpr double kSlowestBeat = 45.0 / 60.0, kFastestBeat = 180.0 / 60.0;
constexpr double kSlowestSearched = 36.0 / 60.0;
constexpr double kMostCarriedOver = 0.98;
constexpr int kPasses = 2;
constexpr double kRestWidth = 0.2;

/// The least (of std::less) or greatest value of each window of `width`, [from, from + width).
///
/// In two runs over blocks of a window: van Herk, Pattern Recognit. Lett. 13 (1992) 517.
template <class Better>
std::vector<float> best_in_windows(const std::vector<float>& values, int width, Better is_better) {
  const int count = int(values.size());
  const auto best = [&](float a, float b) { return is_better(b, a) ? b : a; };
  std::vector<float> since = values, until = values;
  for (int i = 1; i < count; ++i)
    if (i % width != 0)
      since[std::size_t(i)] = best(since[std::size_t(i)], since[std::size_t(i) - 1]);
  for (int i = count - 2; i >= 0; --i)
    if ((i + 1) % width != 0)
      until[std::size_t(i)] = best(until[std::size_t(i)], until[std::size_t(i) + 1]);
  std::vector<float> result;
  for (int i = 0; i + width <= count; ++i)
    result.push_back(best(until[std::size_t(i)], since[std::size_t(i + width - 1)]));
  return result;
}

/// What stands out of its row and is narrower than a width, row by row: the white top-hat
/// (Serra, Image analysis and mathematical morphology, 1982), to which wider things, as bones and
/// the body's edge, add nothing.
std::vector<double> profile_of(const float* picture, int columns, int rows, int width) {
  std::vector<double> profile(static_cast<std::size_t>(rows));
  for (int r = 0; r < rows; ++r) {
    const std::vector<float> row(picture + std::size_t(r) * std::size_t(columns),
                                 picture + std::size_t(r + 1) * std::size_t(columns));
    const std::vector<float> opened =
        best_in_windows(best_in_windows(row, width, std::less<>()), width, std::greater<>());
    double sum = 0.0;  // of what windows cover from all sides
    for (std::size_t i = 0; i < opened.size(); ++i)
      sum += double(row[i + std::size_t(width) - 1] - opened[i]);
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

/// How much of a residual is left of the one before: an autoregression of the first order.
double carried_over(const Eigen::VectorXd& residual) {
  const Eigen::Index n = residual.size() - 1;
  const double squares = residual.head(n).squaredNorm();
  return squares > 0.0
             ? std::clamp(residual.head(n).dot(residual.tail(n)) / squares, 0.0, kMostCarriedOver)
             : 0.0;
}

/// Rows less what is carried over from the row before.
Eigen::MatrixXd whitened(const Eigen::MatrixXd& rows, double carried) {
  const Eigen::Index n = rows.rows() - 1;
  return rows.bottomRows(n) - carried * rows.topRows(n);
}

/// Least squares of a signal by slow changes, then by those and a beat, under errors that go on
/// from frame to frame (Cochrane, Orcutt, J. Am. Stat. Assoc. 44, 1949, 32).
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
  }

  Beat fit(const std::vector<double>& phases) {
    for (Eigen::Index n = 0; n < signal_.size(); ++n)
      for (int h = 1; h <= kHarmonics; ++h) {
        const double angle = 2.0 * units::kPi * h * phases[std::size_t(n)];
        terms_(n, slow_ + 2 * h - 2) = std::cos(angle);
        terms_(n, slow_ + 2 * h - 1) = std::sin(angle);
      }
    const double freedom = double(signal_.size() - 1 - terms_.cols());
    Beat beat;
    if (freedom < 1.0) return beat;
    Eigen::VectorXd fit = terms_.colPivHouseholderQr().solve(signal_);
    double squares = 0.0, left = 0.0;  // of the whitened signal: by slow changes, and all terms
    for (int pass = 0; pass < kPasses; ++pass) {
      const double carried = carried_over(signal_ - terms_ * fit);
      const Eigen::MatrixXd terms = whitened(terms_, carried);
      const Eigen::VectorXd signal = whitened(signal_, carried);
      const auto slow = terms.leftCols(slow_);
      fit = terms.colPivHouseholderQr().solve(signal);
      left = (signal - terms * fit).squaredNorm();
      squares = (signal - slow * slow.colPivHouseholderQr().solve(signal)).squaredNorm();
    }
    beat.f_ratio = (squares - left) / (2 * kHarmonics) / std::max(left / freedom, 1e-12);
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
};

}  // namespace

std::vector<double> axial_shifts(const RotationalRun& run, double air, const Orbit& orbit,
                                 double pixel_mm, const Progress& progress) {
  const angiogram::ConeBeamFrame& first = run.frames.front();
  const int count = int(run.frames.size());
  const std::size_t pixels = std::size_t(first.columns) * std::size_t(first.rows);
  const int width = std::clamp(int(kWidestMm / pixel_mm), 3, std::max(3, first.columns / 3));
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
          profile_of(integrals.data() + std::size_t(n) * pixels, first.columns, first.rows, width);
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
  std::vector<Beat> beats;
  std::vector<double> phases(times_s.size());
  for (double rate = kSlowestSearched; rate <= kFastestBeat; rate += step) {
    for (std::size_t n = 0; n < phases.size(); ++n) phases[n] = rate * (times_s[n] - times_s[0]);
    beats.push_back(fit.fit(phases));
    beats.back().rate_per_s = rate;
  }
  Beat best;
  for (std::size_t n = 1; n + 1 < beats.size(); ++n)
    if (beats[n].rate_per_s >= kSlowestBeat && beats[n].f_ratio > best.f_ratio &&
        beats[n].f_ratio >= std::max(beats[n - 1].f_ratio, beats[n + 1].f_ratio))
      best = beats[n];
  return best;
}

}  // namespace angio::reconstruction::detail
