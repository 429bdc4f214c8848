#include "datasets/detail/scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"
#include "core/units.hpp"

namespace angio::datasets::detail {
namespace {

constexpr int kBlock = 16;  ///< voxels along a block that one thread fills
/// Cells at the wall are halved down to this part of the local radius; what is left of the wall's
/// bending changes the volume by less than 0.1 %.
constexpr double kCellOverRadius = 0.15;

/// The part of a box inside the lumen. The wall bends away from its tangent plane by k t^2 / 2 at
/// a distance t; over a cell of edge e that is k e^2 / 24 on average, by which the plane is moved.
///
/// @param axes   of the voxels: columns are i, j, k in LPS
/// @param edges  of the box along these
double box_fraction(const LumenShape& shape, const Mat3& axes, const Vec3& center,
                    const Vec3& edges) {
  const NearestWall wall = shape.nearest_wall(center);
  const double reach = 0.5 * norm(edges);
  if (wall.distance > reach + shape.margin_mm()) return 0.0;
  if (wall.distance < -reach - shape.margin_mm()) return 1.0;
  const double longest = std::max({edges.x, edges.y, edges.z});
  if (longest <= kCellOverRadius * wall.radius) {
    // In units of the edges, the box is the unit cube.
    Vec3 normal = transpose(axes) * wall.normal;
    for (int axis = 0; axis < 3; ++axis) normal[axis] *= edges[axis];
    const double bend = wall.curvature * norm_squared(edges) / 72.0;
    return fraction_below_plane(normal / norm(normal), (wall.distance + bend) / norm(normal));
  }
  double sum = 0.0;
  int count = 0;
  std::array<int, 3> parts{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    parts[axis] = edges[int(axis)] > 0.5 * longest ? 2 : 1;
  const Vec3 part{edges.x / parts[0], edges.y / parts[1], edges.z / parts[2]};
  for (int k = 0; k < parts[2]; ++k)
    for (int j = 0; j < parts[1]; ++j)
      for (int i = 0; i < parts[0]; ++i, ++count) {
        const Vec3 aside{(i + 0.5) * part.x - 0.5 * edges.x, (j + 0.5) * part.y - 0.5 * edges.y,
                         (k + 0.5) * part.z - 0.5 * edges.z};
        sum += box_fraction(shape, axes, center + axes * aside, part);
      }
  return sum / count;
}

/// Fills voxels [lo, hi), halving the box until it is far from the wall or one voxel.
void fill_box(const LumenShape& shape, Volume<float>& volume, const std::array<int, 3>& lo,
              const std::array<int, 3>& hi) {
  const Vec3& spacing = volume.geometry.spacing;
  const auto width = [&](std::size_t axis) { return hi[axis] - lo[axis]; };
  const Vec3 center_index{0.5 * (lo[0] + hi[0] - 1), 0.5 * (lo[1] + hi[1] - 1),
                          0.5 * (lo[2] + hi[2] - 1)};
  const Vec3 center = volume.geometry.lps_from_index(center_index);
  if (width(0) == 1 && width(1) == 1 && width(2) == 1) {
    volume.at(lo[0], lo[1], lo[2]) =
        float(box_fraction(shape, volume.geometry.direction, center, spacing));
    return;
  }
  const double reach =
      0.5 * norm(Vec3{width(0) * spacing.x, width(1) * spacing.y, width(2) * spacing.z});
  const double d = shape.signed_distance(center);
  if (d > reach + shape.margin_mm() || d < -reach - shape.margin_mm()) {
    const float value = d > 0.0 ? 0.0f : 1.0f;
    for (int k = lo[2]; k < hi[2]; ++k)
      for (int j = lo[1]; j < hi[1]; ++j)
        std::fill_n(volume.values.begin() + std::ptrdiff_t(volume.geometry.offset(lo[0], j, k)),
                    width(0), value);
    return;
  }
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < 3; ++axis)
    if (width(axis) > width(longest)) longest = axis;
  std::array<int, 3> middle_hi = hi, middle_lo = lo;
  middle_hi[longest] = middle_lo[longest] = lo[longest] + width(longest) / 2;
  fill_box(shape, volume, lo, middle_hi);
  fill_box(shape, volume, middle_lo, hi);
}

std::uint64_t mix(std::uint64_t z) {  // SplitMix64's output function (Steele et al., OOPSLA 2014)
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Convolves one line of `count` voxels, `stride` apart.
void blur_line(float* line, std::ptrdiff_t stride, int count, const std::vector<float>& kernel,
               std::vector<float>& padded) {
  const int reach = int(kernel.size()) - 1;
  padded.resize(std::size_t(count + 2 * reach));
  for (int i = -reach; i < count + reach; ++i)
    padded[std::size_t(i + reach)] = line[std::clamp(i, 0, count - 1) * stride];
  for (int i = 0; i < count; ++i) {
    const float* p = padded.data() + i + reach;
    float sum = kernel[0] * p[0];
    for (int r = 1; r <= reach; ++r) sum += kernel[std::size_t(r)] * (p[-r] + p[r]);
    line[i * stride] = sum;
  }
}

/// Half of a Gaussian kernel, from its middle; the whole sums to one.
std::vector<float> half_kernel(double sd) {
  const int reach = std::max(1, int(std::ceil(4.0 * sd)));
  std::vector<double> weight;
  double sum = 0.0;
  for (int r = 0; r <= reach; ++r) {
    weight.push_back(std::exp(-0.5 * r * r / (sd * sd)));
    sum += (r == 0 ? 1.0 : 2.0) * weight.back();
  }
  std::vector<float> kernel;
  for (double w : weight) kernel.push_back(float(w / sum));
  return kernel;
}

}  // namespace

VolumeGeometry grid_around(const LumenShape& shape, const Vec3& spacing_mm, double margin_mm,
                           const Mat3& direction) {
  VolumeGeometry geometry;
  geometry.direction = direction;
  Vec3 origin_along_axes;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [least, greatest] =
        shape.extent_along({direction(0, axis), direction(1, axis), direction(2, axis)});
    const int count = int(std::ceil((greatest - least + 2.0 * margin_mm) / spacing_mm[axis])) + 1;
    geometry.size[std::size_t(axis)] = count;
    origin_along_axes[axis] = 0.5 * (least + greatest) - 0.5 * (count - 1) * spacing_mm[axis];
  }
  geometry.origin = direction * origin_along_axes;
  geometry.spacing = spacing_mm;
  return geometry;
}

double fraction_below_plane(const Vec3& normal, double offset) {
  // Below kLeast the formula loses its digits; the cube's part changes by less than kLeast.
  constexpr double kLeast = 1e-4;
  const double a = std::max(std::abs(normal.x), kLeast);
  const double b = std::max(std::abs(normal.y), kLeast);
  const double c = std::max(std::abs(normal.z), kLeast);
  const double d = 0.5 * (a + b + c) - offset;
  if (d <= 0.0) return 0.0;
  if (d >= a + b + c) return 1.0;
  const auto cubed = [](double x) { return x > 0.0 ? x * x * x : 0.0; };
  const double sum = cubed(d) - cubed(d - a) - cubed(d - b) - cubed(d - c) + cubed(d - a - b) +
                     cubed(d - a - c) + cubed(d - b - c);
  return std::clamp(sum / (6.0 * a * b * c), 0.0, 1.0);
}

Volume<float> lumen_fraction(const LumenShape& shape, const VolumeGeometry& geometry,
                             const Progress& progress) {
  Volume<float> volume(geometry);
  const auto block_count = [&](std::size_t axis) {
    return (geometry.size[axis] + kBlock - 1) / kBlock;
  };
  const int count_i = block_count(0), count_j = block_count(1), count_k = block_count(2);
  for (int k = 0; k < count_k; ++k) {
    parallel_for_uneven(count_i * count_j, [&](std::ptrdiff_t ij) {
      const std::array<int, 3> lo{int(ij) % count_i * kBlock, int(ij) / count_i * kBlock,
                                  k * kBlock};
      std::array<int, 3> hi{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        hi[axis] = std::min(lo[axis] + kBlock, geometry.size[axis]);
      fill_box(shape, volume, lo, hi);
    });
    progress.report((k + 1.0) / count_k);
  }
  return volume;
}

void blur(Volume<float>& volume, const Vec3& sd_voxels) {
  if (sd_voxels.x <= 0.0) return;
  std::array<std::vector<float>, 3> kernel;
  for (std::size_t axis = 0; axis < 3; ++axis) kernel[axis] = half_kernel(sd_voxels[int(axis)]);
  const VolumeGeometry& g = volume.geometry;
  const std::ptrdiff_t row = g.size[0], slice = row * g.size[1];
  float* values = volume.values.data();
  parallel_for(g.size[2], [&](std::ptrdiff_t k) {
    std::vector<float> padded;
    for (int j = 0; j < g.size[1]; ++j)
      blur_line(values + k * slice + j * row, 1, g.size[0], kernel[0], padded);
    for (int i = 0; i < g.size[0]; ++i)
      blur_line(values + k * slice + i, row, g.size[1], kernel[1], padded);
  });
  parallel_for(g.size[1], [&](std::ptrdiff_t j) {
    std::vector<float> padded;
    for (int i = 0; i < g.size[0]; ++i)
      blur_line(values + j * row + i, slice, g.size[2], kernel[2], padded);
  });
}

double normal_number(std::uint64_t seed, std::uint64_t counter) {
  const std::uint64_t key = mix(seed);
  const std::uint64_t first = mix(key ^ mix(2 * counter));
  const std::uint64_t second = mix(key ^ mix(2 * counter + 1));
  const double u = (double(first >> 11) + 1.0) * 0x1.0p-53;  // (0, 1]
  const double v = double(second >> 11) * 0x1.0p-53;         // [0, 1)
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * units::kPi * v);
}

}  // namespace angio::datasets::detail
