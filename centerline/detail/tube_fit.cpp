#include "centerline/detail/tube_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kDegree = 2;  // of the polynomial along the line

constexpr int kPowers = kDegree + 1;

int term_count(int order) { return (2 * order + 1) * kPowers; }

/// 1, cos, sin, cos 2, sin 2, ... of a sample's angle.
template <int Order>
struct Harmonics {
  std::array<double, 2 * Order + 1> value;
  Harmonics(const Sample& sample, int order) {
    double c = 1.0, d = 0.0;
    value[0] = 1.0;
    for (std::size_t m = 1; m <= std::size_t(order); ++m) {
      const double next = c * sample.cos - d * sample.sin;
      d = d * sample.cos + c * sample.sin;
      c = next;
      value[2 * m - 1] = c;
      value[2 * m] = d;
    }
  }
};

/// The weighted normal equations of the harmonics times powers of s. Products of two harmonics are
/// sums of two others, so few sums over the samples tell the whole matrix:
///
///     2 cos m cos n = cos(m - n) + cos(m + n),  2 sin m sin n = cos(m - n) - cos(m + n),
///     2 sin m cos n = sin(m + n) + sin(m - n)
class NormalEquations {
 public:
  NormalEquations(int order, double window) : order_(order), window_(window) {}

  void add(const Sample& sample, double weight) {
    const Harmonics<2 * kMostOrder> harmonics(sample, 2 * order_);
    const double s = sample.s / window_;
    std::array<double, kSums> powers{};
    double power = weight;
    for (std::size_t k = 0; k <= 2 * kDegree; ++k, power *= s) powers[k] = power;
    for (std::size_t f = 0; f <= 4 * std::size_t(order_); ++f)
      for (std::size_t k = 0; k < kSums; ++k) sums_[f][k] += harmonics.value[f] * powers[k];
    for (std::size_t f = 0; f <= 2 * std::size_t(order_); ++f)
      for (std::size_t k = 0; k < kPowers; ++k)
        right_[f][k] += harmonics.value[f] * (powers[k] * sample.radius);
  }

  [[nodiscard]] Eigen::MatrixXd matrix() const {
    Eigen::MatrixXd normal(term_count(order_), term_count(order_));
    for (int f = 0; f <= 2 * order_; ++f)
      for (int g = 0; g <= f; ++g)
        for (int k = 0; k < kPowers; ++k)
          for (int l = 0; l < kPowers; ++l)
            normal(f * kPowers + k, g * kPowers + l) = product(f, g, std::size_t(k + l));
    return normal;
  }
  [[nodiscard]] Eigen::VectorXd right() const {
    Eigen::VectorXd values(term_count(order_));
    for (int c = 0; c < values.size(); ++c)
      values[c] = right_[std::size_t(c / kPowers)][std::size_t(c % kPowers)];
    return values;
  }

 private:
  static constexpr std::size_t kSums = 2 * kDegree + 2;  // one more than needed: an even number
  [[nodiscard]] double cosine(int m, std::size_t power) const {
    return sums_[m == 0 ? 0 : std::size_t(2 * m - 1)][power];
  }
  [[nodiscard]] double sine(int m, std::size_t power) const {
    return m == 0 ? 0.0 : (m < 0 ? -1.0 : 1.0) * sums_[std::size_t(2 * std::abs(m))][power];
  }
  /// Of harmonics number f >= g.
  [[nodiscard]] double product(int f, int g, std::size_t power) const {
    const int m = (f + 1) / 2, n = (g + 1) / 2;
    const bool is_sine_f = f > 0 && f % 2 == 0, is_sine_g = g > 0 && g % 2 == 0;
    if (is_sine_f != is_sine_g)
      return 0.5 * (sine(m + n, power) + (is_sine_f ? sine(m - n, power) : sine(n - m, power)));
    return 0.5 * (cosine(m - n, power) + (is_sine_f ? -1.0 : 1.0) * cosine(m + n, power));
  }

  int order_;
  double window_;
  std::array<std::array<double, kSums>, 4 * kMostOrder + 1> sums_{};
  std::array<std::array<double, kPowers>, 2 * kMostOrder + 1> right_{};
};

double kernel(const Sample& sample, double window) {
  const double t = sample.s / window;
  return t * t < 1.0 ? 1.0 - t * t : 0.0;
}

/// How many samples err together, as seen: the square of a cell's sum of residuals over the sum of
/// their squares, on average over cells of two correlation lengths, longer than what errs
/// together.
double samples_per_error(const std::vector<Sample>& samples, const std::vector<std::size_t>& inside,
                         const Eigen::VectorXd& residual, double length, double radius) {
  const double turn = 2.0 * units::kPi;
  const int around = std::max(3, int(turn * radius / length));
  const auto along = [&](const Sample& sample) { return int(std::floor(sample.s / length)); };
  int first = 0, last = 0;
  for (std::size_t n : inside) {
    first = std::min(first, along(samples[n]));
    last = std::max(last, along(samples[n]));
  }
  std::vector<std::pair<double, double>> cells(std::size_t((last - first + 1) * around));
  for (std::size_t n = 0; n < inside.size(); ++n) {
    const Sample& sample = samples[inside[n]];
    const double r = sample.weight * residual[Eigen::Index(n)];
    const double part = sample.angle / turn + 0.5;
    auto& [sum, squares] = cells[std::size_t((along(sample) - first) * around +
                                             std::min(int(part * around), around - 1))];
    sum += r;
    squares += r * r;
  }
  double together = 0.0, alone = 0.0;
  for (const auto& [sum, squares] : cells) {
    together += sum * sum;
    alone += squares;
  }
  return alone > 0.0 ? together / alone : 1.0;
}

/// Standard errors of the terms and the score of the fit. Errors go together within a patch of the
/// correlation length, so there are fewer independent samples than points.
void set_errors(Fit& fit, double seen_together, const std::vector<double>& residual,
                const Eigen::VectorXd& weight, const Eigen::VectorXd& robust,
                const Eigen::VectorXd& inverse_diagonal, const WallErrors& errors, double radius) {
  double rss = 0.0;
  for (Eigen::Index n = 0; n < weight.size(); ++n)
    rss += robust[n] * weight[n] * residual[std::size_t(n)] * residual[std::size_t(n)];
  const double sum = weight.sum();
  fit.count = sum * sum / weight.squaredNorm();
  const double density = fit.count / (2.0 * units::kPi * radius * 1.3 * fit.window);
  const double patch = std::max(1.0, density * 1.4 * errors.correlation * errors.correlation);
  const double samples = fit.count / patch, terms = double(fit.terms.size());
  // What the terms took up is missing in the residuals.
  const double left_over = std::max(1.0 - terms / fit.count, 0.25);
  fit.sd = fit.noise / std::sqrt(left_over);
  const double noise = std::max(fit.sd, errors.least_sd);
  const double variance = noise * noise * std::max(patch, seen_together);
  fit.error = (variance * inverse_diagonal).cwiseMax(0.0).cwiseSqrt();
  // Akaike's criterion, of known errors or of such as the residuals tell.
  const double known = errors.least_sd * errors.least_sd;
  fit.score = known > 0.0 ? samples * rss / (sum * known) + 2.0 * terms
                          : samples * std::log(std::max(rss / sum, 1e-18 * radius * radius)) +
                                2.0 * terms * (1.0 + terms / samples);
}

/// Whether a longer window changes nothing but noise. It holds the shorter one's samples: where
/// each errs by itself, the variance of the change is the difference of the variances (Hausman,
/// Econometrica 46(6), 1978); where errors go together it is not known and bounded by the sum.
bool agrees(const Fit& shorter, const Fit& longer, bool is_independent) {
  const auto error_of_change = [&](int c) {
    const double a = shorter.error[c], b = longer.error[c];
    return is_independent ? std::sqrt(std::max(a * a - b * b, 1e-3 * a * a)) : a + b;
  };
  // Level, middle and flatness.
  for (const int c :
       {0, first_term(1, false), first_term(1, true), first_term(2, false), first_term(2, true)})
    if (std::abs(shorter.terms[c] - longer.terms[c]) > kConfidence * error_of_change(c))
      return false;
  return true;
}

}  // namespace

int first_term(int harmonic, bool sine) {  // harmonic 0 has no sine
  return (harmonic == 0 ? 0 : 2 * harmonic - (sine ? 0 : 1)) * (kDegree + 1);
}

double predict(const Fit& fit, const Sample& sample) {
  const Harmonics<kMostOrder> harmonics(sample, fit.order);
  const double s = sample.s / fit.window;
  double radius = 0.0;
  for (int f = 0; f <= 2 * fit.order; ++f) {
    const double* terms = fit.terms.data() + f * kPowers;
    double power = 0.0;
    for (int k = kDegree; k >= 0; --k) power = power * s + terms[k];
    radius += harmonics.value[std::size_t(f)] * power;
  }
  return radius;
}

Fit fit_window(std::vector<Sample>& samples, double window, int order, int passes,
               const WallErrors& errors, double radius) {
  Fit fit;
  fit.order = order;
  fit.window = window;
  const int terms = term_count(order);
  std::vector<std::size_t> inside;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (std::abs(samples[i].s) < window) inside.push_back(i);
  const auto count = Eigen::Index(inside.size());
  if (count < std::max(12, terms)) return fit;
  Eigen::VectorXd weight(count), robust(count), left(count);
  std::vector<double> residual(inside.size());
  Eigen::LLT<Eigen::MatrixXd> factor;
  for (int pass = 0; pass < passes; ++pass) {
    double total = 0.0;
    NormalEquations equations(order, window);
    for (Eigen::Index n = 0; n < count; ++n) {
      const Sample& sample = samples[inside[std::size_t(n)]];
      total += weight[n] = sample.weight * kernel(sample, window);
      if (weight[n] > 0.0) equations.add(sample, weight[n]);
    }
    Eigen::MatrixXd normal = equations.matrix();
    // Rings of vertices far apart do not tell a bend from a level: then there is no bend.
    for (int c = 0; c < terms; ++c)
      normal(c, c) += total * (c % kPowers > 0 ? 1e-6 : (c > 0 ? 1e-9 : 0.0));
    factor.compute(normal);
    if (factor.info() != Eigen::Success) return fit;
    fit.terms = factor.solve(equations.right());
    for (Eigen::Index n = 0; n < count; ++n) {
      const Sample& sample = samples[inside[std::size_t(n)]];
      left[n] = sample.radius - predict(fit, sample);
      residual[std::size_t(n)] = std::abs(left[n]);
    }
    std::vector<double> sorted;
    for (std::size_t n = 0; n < residual.size(); ++n)
      if (weight[Eigen::Index(n)] > 0.0) sorted.push_back(residual[n]);
    if (sorted.size() < std::size_t(std::max(12, terms))) return fit;
    fit.noise = 1.4826 * quantile(sorted, 0.5);
    const double cut = 4.685 * std::max(fit.noise, 2e-3 * radius);
    for (std::size_t n = 0; n < residual.size(); ++n) {
      const double t = residual[n] / cut;
      const double keep = t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
      samples[inside[n]].weight = robust[Eigen::Index(n)] = keep;
    }
  }
  const double together =
      errors.correlation > 0.0
          ? samples_per_error(samples, inside, left, 2.0 * errors.correlation, radius)
          : 1.0;
  const Eigen::MatrixXd root = factor.matrixL().solve(Eigen::MatrixXd::Identity(terms, terms));
  set_errors(fit, together, residual, weight, robust, root.colwise().squaredNorm().transpose(),
             errors, radius);
  fit.valid = fit.terms.allFinite() && fit.terms[0] > 0.0;
  return fit;
}

void shrink_harmonics(Fit& fit) {
  for (int m = 0; m <= fit.order; ++m)
    for (int k = m < 2 ? 1 : 0; k <= kDegree; ++k) {
      const int c = first_term(m, false) + k, d = first_term(m, true) + k;
      double power = fit.terms[c] * fit.terms[c], expected = fit.error[c] * fit.error[c];
      if (m > 0) {
        power += fit.terms[d] * fit.terms[d];
        expected += fit.error[d] * fit.error[d];
      }
      const double part = power > 0.0 ? kSignificant * expected / power : 0.0;
      const double keep = std::max(0.0, 1.0 - part * part);
      fit.terms[c] *= keep;
      if (m > 0) fit.terms[d] *= keep;
    }
}

Fit choose_window(std::vector<Sample>& samples, double radius, const WallErrors& errors) {
  constexpr double kSamplesPerTerm = 3.0;  // with fewer the errors are not known
  std::vector<Fit> kept;
  for (const double factor : kWindows) {
    Fit fit = fit_window(samples, factor * radius, 2, 2, errors, radius);
    if (!fit.valid || fit.count < kSamplesPerTerm * term_count(2)) continue;
    for (const Fit& shorter : kept)
      if (!agrees(shorter, fit, errors.correlation <= 0.0)) return kept.back();
    kept.push_back(std::move(fit));
  }
  if (kept.empty())
    return fit_window(samples, kWindows[std::size(kWindows) - 1] * radius, 2, 2, errors, radius);
  return kept.back();
}

Fit choose_order(std::vector<Sample>& samples, Fit best, int most_order, const WallErrors& errors,
                 double radius) {
  for (int order = 4; order <= most_order; order += 2) {
    Fit fit = fit_window(samples, best.window, order, 2, errors, radius);
    if (!fit.valid || fit.score >= best.score) break;
    best = std::move(fit);
  }
  return best;
}

}  // namespace angio::centerline
