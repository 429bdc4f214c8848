#include "centerline/detail/tube_fit.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "core/units.hpp"

namespace angio::centerline {
namespace {

constexpr int kDegree = 2;            // of the polynomial along the line
constexpr double kSignificant = 3.0;  // -log 5 %: noise alone rarely has more times its mean power

int term_count(int order) { return (2 * order + 1) * (kDegree + 1); }
/// Harmonics 1, cos, sin, cos 2, ... of an angle times powers of s, one row of the fit.
template <class Row>
void fill_row(int order, double cosine, double sine, double s, double scale, Row&& row) {
  double c = 1.0, d = 0.0;
  int at = 0;
  const auto put = [&](double value) {
    double power = scale * value;
    for (int k = 0; k <= kDegree; ++k, power *= s) row(at++) = power;
  };
  put(1.0);
  for (int m = 1; m <= order; ++m) {
    const double next = c * cosine - d * sine;
    d = d * cosine + c * sine;
    c = next;
    put(c);
    put(d);
  }
}

double kernel(const Sample& sample, double window) {
  const double t = sample.s / window;
  return t * t < 1.0 ? 1.0 - t * t : 0.0;
}

/// Of a positive definite matrix given by its lower half.
Eigen::VectorXd inverse_diagonal(const Eigen::MatrixXd& lower) {
  const Eigen::LLT<Eigen::MatrixXd> factor(lower);
  const Eigen::MatrixXd root =
      factor.matrixL().solve(Eigen::MatrixXd::Identity(lower.rows(), lower.cols()));
  return root.colwise().squaredNorm().transpose();
}

/// How many samples err together, as seen: the square of a cell's sum of residuals over the sum of
/// their squares, on average over cells of two correlation lengths, longer than what errs
/// together.
double samples_per_error(const std::vector<Sample>& samples, const std::vector<std::size_t>& inside,
                         const Eigen::VectorXd& residual, double length, double radius) {
  const double turn = 2.0 * units::kPi;
  const int around = std::max(3, int(turn * radius / length));
  std::map<std::pair<int, int>, std::pair<double, double>> cells;  // sum, sum of squares
  for (std::size_t n = 0; n < inside.size(); ++n) {
    const Sample& sample = samples[inside[n]];
    const double r = sample.weight * residual[Eigen::Index(n)];
    const double part = std::atan2(sample.sin, sample.cos) / turn + 0.5;
    auto& [sum, squares] =
        cells[{int(std::floor(sample.s / length)), std::min(int(part * around), around - 1)}];
    sum += r;
    squares += r * r;
  }
  double together = 0.0, alone = 0.0;
  for (const auto& [key, cell] : cells) {
    together += cell.first * cell.first;
    alone += cell.second;
  }
  return alone > 0.0 ? together / alone : 1.0;
}

/// Standard errors of the terms and the score of the fit. Errors go together within a patch of the
/// correlation length, so there are fewer independent samples than points.
void set_errors(Fit& fit, double seen_together, const std::vector<double>& residual,
                const Eigen::VectorXd& weight, const Eigen::VectorXd& robust,
                const Eigen::MatrixXd& normal, double correlation, double radius) {
  double rss = 0.0;
  for (Eigen::Index n = 0; n < weight.size(); ++n)
    rss += robust[n] * weight[n] * residual[std::size_t(n)] * residual[std::size_t(n)];
  const double sum = weight.sum();
  fit.count = sum * sum / weight.squaredNorm();
  const double density = fit.count / (2.0 * units::kPi * radius * 1.3 * fit.window);
  const double patch = std::max(1.0, density * 1.4 * correlation * correlation);
  const double samples = fit.count / patch, terms = double(fit.terms.size());
  // What the terms took up is missing in the residuals.
  const double left_over = std::max(1.0 - terms / fit.count, 0.25);
  const double variance = fit.noise * fit.noise / left_over * std::max(patch, seen_together);
  fit.error = (variance * inverse_diagonal(normal)).cwiseMax(0.0).cwiseSqrt();
  fit.score = samples * std::log(std::max(rss / sum, 1e-18 * radius * radius)) +
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
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, (2 * kMostOrder + 1) * (kDegree + 1), 1> row(
      fit.terms.size());
  fill_row(fit.order, sample.cos, sample.sin, sample.s / fit.window, 1.0,
           [&](int c) -> double& { return row(c); });
  return row.dot(fit.terms);
}

Fit fit_window(std::vector<Sample>& samples, double window, int order, int passes,
               double correlation, double radius) {
  Fit fit;
  fit.order = order;
  fit.window = window;
  const int terms = term_count(order);
  std::vector<std::size_t> inside;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (std::abs(samples[i].s) < window) inside.push_back(i);
  const auto count = Eigen::Index(inside.size());
  if (count < std::max(12, terms)) return fit;
  Eigen::MatrixXd rows(terms, count);
  Eigen::VectorXd value(count), weight(count), robust(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const Sample& sample = samples[inside[std::size_t(n)]];
    fill_row(order, sample.cos, sample.sin, sample.s / window, 1.0,
             [&](int c) -> double& { return rows(c, n); });
    value[n] = sample.radius;
  }
  std::vector<double> residual(inside.size());
  Eigen::VectorXd left;
  Eigen::MatrixXd normal;
  for (int pass = 0; pass < passes; ++pass) {
    double total = 0.0;
    for (Eigen::Index n = 0; n < count; ++n) {
      const Sample& sample = samples[inside[std::size_t(n)]];
      total += weight[n] = sample.weight * kernel(sample, window);
    }
    const Eigen::MatrixXd weighted = rows * weight.cwiseSqrt().asDiagonal();
    normal.setZero(terms, terms);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
    // Rings of vertices far apart do not tell a bend from a level: then there is no bend.
    for (int c = 0; c < terms; ++c)
      normal(c, c) += total * (c % (kDegree + 1) > 0 ? 1e-6 : (c > 0 ? 1e-9 : 0.0));
    fit.terms =
        normal.selfadjointView<Eigen::Lower>().ldlt().solve(rows * weight.cwiseProduct(value));
    left = value - rows.transpose() * fit.terms;
    for (Eigen::Index n = 0; n < count; ++n) residual[std::size_t(n)] = std::abs(left[n]);
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
      correlation > 0.0 ? samples_per_error(samples, inside, left, 2.0 * correlation, radius) : 1.0;
  set_errors(fit, together, residual, weight, robust, normal, correlation, radius);
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

Fit choose_window(std::vector<Sample>& samples, double radius, double correlation) {
  constexpr double kSamplesPerTerm = 3.0;  // with fewer the errors are not known
  std::vector<Fit> kept;
  for (const double factor : kWindows) {
    Fit fit = fit_window(samples, factor * radius, 2, 2, correlation, radius);
    if (!fit.valid || fit.count < kSamplesPerTerm * term_count(2)) continue;
    for (const Fit& shorter : kept)
      if (!agrees(shorter, fit, correlation <= 0.0)) return kept.back();
    kept.push_back(std::move(fit));
  }
  if (kept.empty())
    return fit_window(samples, kWindows[std::size(kWindows) - 1] * radius, 2, 2, correlation,
                      radius);
  return kept.back();
}

Fit choose_order(std::vector<Sample>& samples, Fit best, int most_order, double correlation,
                 double radius) {
  for (int order = 4; order <= most_order; order += 2) {
    Fit fit = fit_window(samples, best.window, order, 2, correlation, radius);
    if (!fit.valid || fit.score >= best.score) break;
    best = std::move(fit);
  }
  return best;
}

}  // namespace angio::centerline
