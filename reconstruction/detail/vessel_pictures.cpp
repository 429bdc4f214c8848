#include "reconstruction/detail/vessel_pictures.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/detail/box_sum.hpp"
#include "reconstruction/detail/picture_size.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr int kTerms = 15;  ///< of a polynomial of the fourth degree in two variables
constexpr int kTurns = 4;
constexpr double kPictureAboveNoise = 3.0;
constexpr int kSkirt = 2;  ///< pixels around a vessel that its blur reaches
using Terms = Eigen::Matrix<double, kTerms, 1>;

/// Legendre's polynomials up to a total degree of four, at a place of the picture.
Terms terms_at(const PictureSize& size, int column, int row) {
  const auto legendre = [](double x) {
    const double xx = x * x;
    return std::array{1.0, x, 1.5 * xx - 0.5, x * (2.5 * xx - 1.5),
                      (4.375 * xx - 3.75) * xx + 0.375};
  };
  const auto x = legendre(2.0 * column / std::max(1, size.columns - 1) - 1.0),
             y = legendre(2.0 * row / std::max(1, size.rows - 1) - 1.0);
  Terms terms;
  int n = 0;
  for (std::size_t a = 0; a < 5; ++a)
    for (std::size_t b = 0; a + b < 5; ++b) terms[n++] = x[a] * y[b];
  return terms;
}

/// The polynomial that fits where the weight is one.
std::vector<double> wide_part(const std::vector<float>& p, const std::vector<double>& weight,
                              const PictureSize& size) {
  constexpr int kEvery = 3;
  Eigen::Matrix<double, kTerms, kTerms> normal;
  normal.setIdentity();
  normal *= 1e-6;
  Terms right = Terms::Zero();
  for (int row = 0; row < size.rows; row += kEvery)
    for (int column = 0; column < size.columns; column += kEvery) {
      const std::size_t i = size.at(column, row);
      if (!(weight[i] > 0.5)) continue;
      const Terms terms = terms_at(size, column, row);
      normal += terms * terms.transpose();
      right += double(p[i]) * terms;
    }
  const Terms fit = normal.ldlt().solve(right);
  std::vector<double> values(size.count());
  for (int row = 0; row < size.rows; ++row)
    for (int column = 0; column < size.columns; ++column)
      values[size.at(column, row)] = fit.dot(terms_at(size, column, row));
  return values;
}

/// What stands around a pixel's values, summed.
std::vector<double> summed(std::vector<double> values, const PictureSize& size, int half) {
  std::vector<double> above;
  box_sum(values, size.columns, size.rows, half, above);
  return values;
}

/// @param fits    where the polynomial is fitted
/// @param weight  of the box
std::vector<double> background(const std::vector<float>& p, const std::vector<double>& fits,
                               const std::vector<double>& weight, const PictureSize& size,
                               int half) {
  std::vector<double> wide = wide_part(p, fits, size), rest(size.count()), sum = weight;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    sum[i] = std::max(sum[i], 1e-6);
    rest[i] = sum[i] * (double(p[i]) - wide[i]);
  }
  for (int pass = 0; pass < 2; ++pass) {
    rest = summed(std::move(rest), size, half);
    sum = summed(std::move(sum), size, half);
  }
  for (std::size_t i = 0; i < rest.size(); ++i) wide[i] += rest[i] / sum[i];
  return wide;
}

/// From the median of the second differences along rows, which slopes do not change: 0.6745 sqrt(6)
/// sd.
double noise_of(const std::vector<float>& p, const PictureSize& size) {
  std::vector<float> bends;
  for (int row = 0; row < size.rows; row += 2)
    for (int column = 1; column + 1 < size.columns; column += 2) {
      const float* at = p.data() + size.at(column, row);
      bends.push_back(std::abs(at[-1] - 2.0F * at[0] + at[1]));
    }
  if (bends.empty()) return 0.0;
  const auto middle = bends.begin() + std::ptrdiff_t(bends.size() / 2);
  std::nth_element(bends.begin(), middle, bends.end());
  return double(*middle) / (0.6745 * std::sqrt(6.0));
}

/// What stands out, and what lies around it.
std::vector<std::uint8_t> bright(const std::vector<float>& excess, const PictureSize& size,
                                 double noise) {
  std::vector<double> smooth = summed(std::vector<double>(excess.begin(), excess.end()), size, 1);
  // Sums of nine pixels.
  const double least = std::max(kPictureAboveNoise * 3.0 * noise, 1e-9);
  for (double& value : smooth) value = value > least ? 1.0 : 0.0;
  smooth = summed(std::move(smooth), size, kSkirt);
  std::vector<std::uint8_t> is_bright(smooth.size());
  for (std::size_t i = 0; i < smooth.size(); ++i) is_bright[i] = smooth[i] > 0.5 ? 1 : 0;
  return is_bright;
}

/// Adds what holds a square of more than `half` to all sides, and its skirt: bone, the heart's and
/// the diaphragm's edges.
void add_wide(const std::vector<std::uint8_t>& is_bright, const PictureSize& size, int half,
              std::vector<std::uint8_t>& is_wide) {
  std::vector<double> outside(size.count());
  for (std::size_t i = 0; i < outside.size(); ++i) outside[i] = is_bright[i] ? 0.0 : 1.0;
  std::vector<double> wide = summed(std::move(outside), size, half);
  for (double& value : wide) value = value < 0.5 ? 1.0 : 0.0;
  wide = summed(std::move(wide), size, half + kSkirt);
  for (std::size_t i = 0; i < wide.size(); ++i)
    if (wide[i] > 0.5) is_wide[i] = 1;
}

}  // namespace

VesselPicture vessels_of(std::vector<float> line_integrals, int columns, int rows, double widest,
                         bool is_subtracted) {
  const PictureSize size{columns, rows};
  VesselPicture picture;
  picture.noise = noise_of(line_integrals, size);
  picture.line_integrals = line_integrals;
  if (!is_subtracted) {
    const int half = std::max(2, int(std::lround(0.5 * widest)));
    std::vector<double> fits(size.count(), 1.0), weight(size.count(), 1.0);
    std::vector<std::uint8_t> is_wide(size.count(), 0);
    for (int turn = 0; turn < kTurns; ++turn) {
      const std::vector<double> behind = background(line_integrals, fits, weight, size, half);
      for (std::size_t i = 0; i < behind.size(); ++i)
        picture.line_integrals[i] = float(double(line_integrals[i]) - behind[i]);
      picture.is_vessel = bright(picture.line_integrals, size, picture.noise);
      add_wide(picture.is_vessel, size, half + kSkirt, is_wide);
      for (std::size_t i = 0; i < behind.size(); ++i) {
        fits[i] = picture.is_vessel[i] || is_wide[i] ? 0.0 : 1.0;
        weight[i] = picture.is_vessel[i] && !is_wide[i] ? 0.0 : 1.0;
      }
    }
    // There may be vessels before what is wide.
    for (std::size_t i = 0; i < is_wide.size(); ++i)
      picture.is_vessel[i] = picture.is_vessel[i] || is_wide[i] ? 1 : 0;
    return picture;
  }
  picture.is_vessel = bright(picture.line_integrals, size, picture.noise);
  return picture;
}

}  // namespace angio::reconstruction::detail
