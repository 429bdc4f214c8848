#include "centerline/detail/lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

#include "core/units.hpp"

namespace angio::centerline::detail {
namespace {

constexpr double kShortest = 0.45, kLongest = 2.4;  ///< [mean edges] periods that are looked for
constexpr double kWindow = 400.0;                   ///< [mean edges] of the axis that is looked at
constexpr double kBins = 4.0;                       ///< of the shortest period
constexpr double kLeastHeight = 0.05;
constexpr double kLeastMedians = 5.0;
constexpr double kBase = 0.25;   ///< of a peak at half its frequency: it is the peak's overtone
constexpr double kBlocks = 0.9;  ///< all vertices lie on the grid or half way in it
constexpr std::size_t kParts = 3;
constexpr double kInPhase = 0.25;  ///< of what each part would give if all gave the same
constexpr double kAlike = 0.01;    ///< of a period: two are the same
constexpr std::size_t kLeastVertices = 300;

double mean_edge(const TriangleMesh& surface) {
  double sum = 0.0;
  for (const Triangle& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum += distance(surface.vertices[std::size_t(t[k])],
                      surface.vertices[std::size_t(t[(k + 1) % 3])]);
  return sum / (3.0 * double(surface.triangles.size()));
}

/// How many vertices lie in each of the bins along an axis, around their median.
struct Histogram {
  std::vector<double> share;
  double bin_mm = 0.0;
  /// Of each of equal parts of the vertices along the axis, its part of S at a frequency [1/mm].
  [[nodiscard]] std::array<std::complex<double>, kParts> parts(double frequency) const {
    const std::complex<double> step = std::polar(1.0, 2.0 * units::kPi * frequency * bin_mm);
    std::array<std::complex<double>, kParts> sums{};
    std::complex<double> turn = 1.0;
    double before = 0.0;
    for (const double value : share) {
      sums[std::min(std::size_t(before * double(kParts)), kParts - 1)] += value * turn;
      before += value;
      turn *= step;
    }
    return sums;
  }
  /// S at a frequency [1/mm].
  [[nodiscard]] double spectrum(double frequency) const {
    std::complex<double> sum = 0.0;
    for (const std::complex<double>& part : parts(frequency)) sum += part;
    return std::abs(sum);
  }
  /// Whether all parts of the axis have the period, in one phase, as a grid does from end to end.
  [[nodiscard]] bool is_in_phase(double frequency) const {
    const auto all = parts(frequency);
    std::complex<double> sum = 0.0;
    for (const std::complex<double>& part : all) sum += part;
    const double least = kInPhase * std::abs(sum) / double(kParts);
    return std::all_of(all.begin(), all.end(), [&](const std::complex<double>& part) {
      return std::real(part * std::conj(sum)) >= least * std::abs(sum);
    });
  }
  [[nodiscard]] double length_mm() const { return bin_mm * double(share.size()); }
};

Histogram histogram_of(std::vector<double> x, double edge) {
  const auto middle = x.begin() + std::ptrdiff_t(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  const auto [least, most] = std::minmax_element(x.begin(), x.end());
  const double low = std::max(*least, *middle - 0.5 * kWindow * edge);
  const double high = std::min(*most, *middle + 0.5 * kWindow * edge);
  Histogram histogram;
  histogram.bin_mm = kShortest * edge / kBins;
  histogram.share.assign(std::size_t((high - low) / histogram.bin_mm) + 1, 0.0);
  double count = 0.0;
  for (const double value : x)
    if (value >= low && value <= high) {
      histogram.share[std::size_t((value - low) / histogram.bin_mm)] += 1.0;
      count += 1.0;
    }
  for (double& share : histogram.share) share /= count;
  return histogram;
}

struct Period {
  double mm = 0.0;
  double slack_mm = 0.0;  ///< to which it is known
  bool is_of_blocks = false;
};

std::optional<Period> find_period(const Histogram& histogram, double edge) {
  const double step = 0.25 / histogram.length_mm();
  std::vector<double> heights;
  double highest = 0.0, frequency = 0.0;
  for (double f = 1.0 / (kLongest * edge); f < 1.0 / (kShortest * edge); f += step) {
    heights.push_back(histogram.spectrum(f));
    if (heights.back() > highest) {
      highest = heights.back();
      frequency = f;
    }
  }
  if (heights.empty()) return {};
  const auto middle = heights.begin() + std::ptrdiff_t(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  const double least = std::max(kLeastHeight, kLeastMedians * *middle);
  for (double f = frequency - step, last = frequency + step; f < last; f += 0.1 * step)
    if (const double height = histogram.spectrum(f); height > highest) {
      highest = height;
      frequency = f;
    }
  if (highest < least || !histogram.is_in_phase(frequency)) return {};
  if (histogram.spectrum(0.5 * frequency) > std::max(least, kBase * highest)) frequency *= 0.5;
  return Period{1.0 / frequency, step / (frequency * frequency), highest > kBlocks};
}

bool are_alike(const Period& a, const Period& b) {
  return std::abs(a.mm - b.mm) <=
         kAlike * std::min(a.mm, b.mm) + 4.0 * std::max(a.slack_mm, b.slack_mm);
}

/// The lattice along the axes that vertices are given in.
std::optional<Lattice> lattice_along(const std::vector<Vec3>& vertices, double edge) {
  std::array<Period, 3> periods;
  for (int a = 0; a < 3; ++a) {
    std::vector<double> x;
    x.reserve(vertices.size());
    for (const Vec3& vertex : vertices) x.push_back(vertex[a]);
    const std::optional<Period> period = find_period(histogram_of(std::move(x), edge), edge);
    if (!period) return {};
    periods[std::size_t(a)] = *period;
  }
  const auto& [i, j, k] = periods;
  if (!are_alike(i, j) && !are_alike(j, k) && !are_alike(i, k)) return {};
  return Lattice{{i.mm, j.mm, k.mm}, i.is_of_blocks && j.is_of_blocks && k.is_of_blocks};
}

/// A triangle's normal, and its share of the surface.
struct Facing {
  Vec3 normal;
  double share = 0.0;
};

std::vector<Facing> facings_of(const TriangleMesh& surface) {
  std::vector<Facing> facings;
  double sum = 0.0;
  for (const Triangle& t : surface.triangles) {
    const Vec3 doubled = area_vector_doubled(surface, t);
    const double area = norm(doubled);
    if (!(area > 0.0)) continue;
    facings.push_back({doubled / area, area});
    sum += area;
  }
  for (Facing& facing : facings) facing.share /= sum;
  return facings;
}

constexpr double kSameWay = 0.9986;  ///< cosine of 3 degrees

/// The direction, either way, that the most of the surface faces, of those across another (zero:
/// of all): the mean of what faces the way of one of some triangles, evenly spread over them.
Vec3 most_faced(const std::vector<Facing>& facings, const Vec3& across) {
  constexpr std::size_t kTried = 500;
  constexpr double kAcross = 0.05;
  double most = 0.0;
  Vec3 best;
  const std::size_t step = std::max<std::size_t>(1, facings.size() / kTried);
  for (std::size_t n = 0; n < facings.size(); n += step) {
    const Vec3& way = facings[n].normal;
    if (std::abs(dot(way, across)) > kAcross) continue;
    double share = 0.0;
    Vec3 mean;
    for (const Facing& facing : facings) {
      const double cosine = dot(facing.normal, way);
      if (std::abs(cosine) < kSameWay) continue;
      share += facing.share;
      mean += (cosine < 0.0 ? -facing.share : facing.share) * facing.normal;
    }
    if (share <= most) continue;
    most = share;
    best = mean;
  }
  return most > 0.0 ? normalized(best) : Vec3{};
}

/// Three axes at right angles along which a stepped surface faces; nothing of another.
std::optional<std::array<Vec3, 3>> axes_of_steps(const TriangleMesh& surface) {
  constexpr double kLeastShare = 0.25;  // of a smooth tube along an axis a seventh faces them
  const std::vector<Facing> facings = facings_of(surface);
  const Vec3 first = most_faced(facings, {});
  Vec3 second = most_faced(facings, first);
  if (norm(first) == 0.0 || norm(second) == 0.0) return {};
  second = normalized(second - dot(second, first) * first);
  const std::array<Vec3, 3> axes{first, second, cross(first, second)};
  std::array<double, 3> shares{};
  for (const Facing& facing : facings)
    for (std::size_t a = 0; a < 3; ++a)
      if (std::abs(dot(facing.normal, axes[a])) > kSameWay) shares[a] += facing.share;
  constexpr double kLeastOfEach = 0.03;
  const bool is_stepped =
      shares[0] + shares[1] + shares[2] > kLeastShare &&
      std::all_of(shares.begin(), shares.end(), [](double s) { return s > kLeastOfEach; });
  return is_stepped ? std::optional(axes) : std::nullopt;
}

}  // namespace

std::optional<Lattice> find_lattice(const TriangleMesh& surface) {
  if (surface.vertices.size() < kLeastVertices || surface.triangles.empty()) return {};
  const double edge = mean_edge(surface);
  if (!(edge > 0.0)) return {};
  if (const auto along = lattice_along(surface.vertices, edge)) return along;
  const auto axes = axes_of_steps(surface);
  if (!axes) return {};
  std::vector<Vec3> turned;
  turned.reserve(surface.vertices.size());
  for (const Vec3& v : surface.vertices)
    turned.push_back({dot(v, (*axes)[0]), dot(v, (*axes)[1]), dot(v, (*axes)[2])});
  return lattice_along(turned, edge);
}

}  // namespace angio::centerline::detail
