#include "reconstruction/detail/fit_noise.hpp"

#include <algorithm>
#include <cmath>

#include "core/statistics.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kNormal = 1.4826;  ///< sd of normal numbers over the median of their size

float median_size(const std::vector<float>& residual) {
  std::vector<float> size;
  size.reserve(residual.size());
  for (const float r : residual) size.push_back(std::abs(r));
  return median(std::move(size));
}

struct Products {
  double own = 0.0, neighbours = 0.0;
};

Products products_of(const FitFrame& frame, const std::vector<float>& residual) {
  constexpr int kSide = 2;
  constexpr float kMost = 4.0F;  // of the median; strangers count as that
  const float most = kMost * median_size(residual);
  const auto value = [&](std::size_t p) { return double(std::clamp(residual[p], -most, most)); };
  const auto& pixels = frame.pixels;
  Products products;
  for (int dy = 0; dy <= kSide; ++dy)
    for (int dx = dy == 0 ? 0 : -kSide; dx <= kSide; ++dx) {
      const int step = dy * frame.frame.columns + dx;
      for (std::size_t p = 0, q = 0; p < pixels.size(); ++p) {
        while (q < pixels.size() && pixels[q].index < pixels[p].index + step) ++q;
        if (q == pixels.size() || pixels[q].index != pixels[p].index + step) continue;
        (step == 0 ? products.own : products.neighbours) += value(p) * value(q);
      }
    }
  return products;
}

}  // namespace

double noise_of(const FrameEquations& equations) {
  constexpr double kLeast = 1e-6;
  const double count = double(equations.residual.size());
  const double left = std::max(0.5 * count, count - double(equations.own_start.size()));
  return std::max(kLeast,
                  kNormal * double(median_size(equations.residual)) * std::sqrt(count / left));
}

double correlation_of(const std::vector<FitFrame>& frames,
                      const std::vector<FrameEquations>& equations) {
  Products sum;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const Products products = products_of(frames[f], equations[f].residual);
    sum.own += products.own;
    sum.neighbours += products.neighbours;
  }
  return sum.own > 0.0 ? std::max(1.0, 1.0 + 2.0 * sum.neighbours / sum.own) : 1.0;
}

}  // namespace angio::reconstruction::detail
