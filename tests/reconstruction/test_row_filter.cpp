#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/units.hpp"
#include "reconstruction/detail/ramp_filter.hpp"
#include "reconstruction/detail/row_filter.hpp"

/// What the GPU does to rows, on the CPU.
namespace angio::reconstruction::detail {
namespace {

/// A team of one.
struct OneThread {
  template <class Each>
  void each(int count, const Each& body) const {
    for (int i = 0; i < count; ++i) body(i);
  }
};

/// A response, by frequency, in the order that the transform leaves.
std::vector<float> in_place(const std::vector<float>& response, int length) {
  std::vector<float> placed;
  for (int place = 0; place < length; ++place) {
    const int f = frequency_at(place, length);
    placed.push_back(response[std::size_t(std::min(f, length - f))]);
  }
  return placed;
}

TEST(Fourier, PutsAWaveAtItsFrequency) {
  for (const int length : {4, 8, 16, 32, 256, 512}) {
    const std::vector<Complex> roots = fourier_roots(length);
    for (const int frequency : {0, 1, length / 2, length - 1}) {
      // exp(2 pi i f n / N) is N at f alone: a response that keeps only f keeps all of it.
      std::vector<float> only(std::size_t(length), 0.0F);
      for (int place = 0; place < length; ++place)
        if (frequency_at(place, length) == frequency)
          only[std::size_t(place)] = 1.0F / float(length);
      std::vector<Complex> wave;
      for (int n = 0; n < length; ++n) {
        const double angle = 2.0 * units::kPi * frequency * n / length;
        wave.push_back({float(std::cos(angle)), float(std::sin(angle))});
      }
      std::vector<Complex> kept = wave;
      convolve(OneThread{}, kept.data(), length, only.data(), roots.data());
      for (std::size_t n = 0; n < wave.size(); ++n) {
        ASSERT_NEAR(kept[n].re, wave[n].re, 1e-5) << length << ", " << frequency;
        ASSERT_NEAR(kept[n].im, wave[n].im, 1e-5) << length << ", " << frequency;
      }
    }
  }
}

TEST(Fourier, ConvolvesAsTheSumDoes) {
  constexpr int kLength = 32;
  // sum_n h(n) x(i - n), with h even: 2 at 0, -1 at +-1.
  std::vector<float> response;
  for (int f = 0; f <= kLength / 2; ++f)
    response.push_back(float((2.0 - 2.0 * std::cos(2.0 * units::kPi * f / kLength)) / kLength));
  std::vector<Complex> x;
  for (int i = 0; i < kLength; ++i) x.push_back({float(i * i % 7), float(i * 5 % 11)});
  std::vector<Complex> y = x;
  convolve(OneThread{}, y.data(), kLength, in_place(response, kLength).data(),
           fourier_roots(kLength).data());
  for (int i = 0; i < kLength; ++i) {
    const auto at = [&](int k) { return x[std::size_t((k + kLength) % kLength)]; };
    EXPECT_NEAR(y[std::size_t(i)].re, 2 * at(i).re - at(i - 1).re - at(i + 1).re, 1e-5);
    EXPECT_NEAR(y[std::size_t(i)].im, 2 * at(i).im - at(i - 1).im - at(i + 1).im, 1e-5);
  }
}

struct Case {
  int columns;
  FilterWindow window;
};
class RowPair : public testing::TestWithParam<Case> {};

/// Both filters leave the same of two rows, one of which ends within the body. A window is applied
/// to other frequencies where the lengths differ: what that leaves far off is under 1e-4.
TEST_P(RowPair, IsFilteredAsByFftw) {
  const auto [columns, window] = GetParam();
  constexpr double kSpacing = 0.4;
  std::vector<float> rows[2];
  for (int i = 0; i < columns; ++i) {
    const double x = 2.0 * i / (columns - 1) - 1.0;
    rows[0].push_back(float(1.5 * std::sqrt(1.0 - 0.7 * x * x) + 0.3 * std::sin(40.0 * x)));
    rows[1].push_back(std::abs(x) < 0.5 ? 1.0F : 0.0F);
  }
  RowFilter filter;
  filter.columns = columns;
  filter.beyond = columns / 2;
  filter.length = fourier_length(3 * columns);
  filter.spacing_mm = kSpacing;
  const std::vector<float> response =
      in_place(ramp_response(filter.length, kSpacing, window), filter.length);
  const std::vector<Complex> roots = fourier_roots(filter.length);
  filter.response = response.data();
  filter.roots = roots.data();
  std::vector<Complex> values(std::size_t(filter.length), Complex{1e9F, -1e9F});
  std::vector<Complex> pair;
  RowPairEnds ends;
  filter_row_pair(
      OneThread{}, filter,
      [&](int i) {
        return Complex{rows[0][std::size_t(i)], rows[1][std::size_t(i)]};
      },
      [](int i) {
        return Complex{1.0F + 0.001F * float(i), 1.0F};
      },
      [&](int, const Complex& both) { pair.push_back(both); }, values.data(), ends);
  EXPECT_EQ(ends.truncated_rows(), 1);
  const RampFilter ramp(columns, kSpacing, window);
  RampFilter::Workspace workspace(ramp);
  for (int i = 0; i < columns; ++i) rows[0][std::size_t(i)] *= 1.0F + 0.001F * float(i);
  for (std::vector<float>& row : rows) ramp.filter(row.data(), workspace);
  ASSERT_EQ(pair.size(), std::size_t(columns));
  const double tolerance = window == FilterWindow::ram_lak ? 1e-5 : 1e-4;
  for (std::size_t i = 0; i < pair.size(); ++i) {
    ASSERT_NEAR(pair[i].re, rows[0][i], tolerance) << i;
    ASSERT_NEAR(pair[i].im, rows[1][i], tolerance) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(OfSomeWidths, RowPair,
                         testing::Values(Case{80, FilterWindow::ram_lak},
                                         Case{96, FilterWindow::shepp_logan},
                                         Case{333, FilterWindow::hann},
                                         Case{341, FilterWindow::ram_lak}));

}  // namespace
}  // namespace angio::reconstruction::detail
