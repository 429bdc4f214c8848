#include "segmentation/detail/depth.hpp"

#include <itkImportImageFilter.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

/// A plane of voxels.
struct Plane {
  std::size_t first = 0;              ///< its first voxel
  std::array<std::size_t, 2> step{};  ///< to the next one along each side
  std::array<int, 2> size{};
  [[nodiscard]] std::size_t count() const { return std::size_t(size[0]) * std::size_t(size[1]); }
  [[nodiscard]] std::size_t voxel(std::size_t n) const {
    return first + n % std::size_t(size[0]) * step[0] + n / std::size_t(size[0]) * step[1];
  }
};

/// Voxels of the plane's holes, hole by hole.
std::vector<std::size_t> holes_in(const Volume<std::uint8_t>& mask, const Plane& plane,
                                  std::size_t most) {
  std::vector<std::uint8_t> is_seen(plane.count());
  for (std::size_t n = 0; n < is_seen.size(); ++n) is_seen[n] = mask.values[plane.voxel(n)];
  std::vector<std::size_t> holes, piece;
  for (std::size_t start = 0; start < is_seen.size(); ++start) {
    if (is_seen[start]) continue;
    bool is_open = false;
    piece.assign(1, start);
    is_seen[start] = 1;
    for (std::size_t at = 0; at < piece.size(); ++at) {
      const int x = int(piece[at] % std::size_t(plane.size[0])),
                y = int(piece[at] / std::size_t(plane.size[0]));
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const int u = x + dx, v = y + dy;
        if (u < 0 || v < 0 || u >= plane.size[0] || v >= plane.size[1]) {
          is_open = true;
          continue;
        }
        const std::size_t n = std::size_t(v) * std::size_t(plane.size[0]) + std::size_t(u);
        if (std::exchange(is_seen[n], std::uint8_t{1})) continue;
        piece.push_back(n);
      }
    }
    if (is_open || piece.size() > most) continue;
    for (const std::size_t n : piece) holes.push_back(plane.voxel(n));
  }
  return holes;
}

}  // namespace

void fill_holes(Volume<std::uint8_t>& mask, double most_mm2) {
  const VolumeGeometry& grid = mask.geometry;
  const std::array<std::size_t, 3> step{1, std::size_t(grid.size[0]),
                                        std::size_t(grid.size[0]) * std::size_t(grid.size[1])};
  std::vector<std::vector<std::size_t>> holes;
  for (std::size_t across = 0; across < 3; ++across) {
    const std::size_t a = across == 0 ? 1 : 0, b = across == 2 ? 1 : 2;
    const auto most = std::size_t(most_mm2 / (grid.spacing[int(a)] * grid.spacing[int(b)]));
    const std::size_t before = holes.size();
    holes.resize(before + std::size_t(grid.size[across]));
    parallel_for(grid.size[across], [&](std::ptrdiff_t n) {
      const Plane plane{
          std::size_t(n) * step[across], {step[a], step[b]}, {grid.size[a], grid.size[b]}};
      holes[before + std::size_t(n)] = holes_in(mask, plane, most);
    });
  }
  for (const auto& plane : holes)
    for (const std::size_t v : plane) mask.values[v] = 1;
}

Volume<float> depth_in(const Volume<std::uint8_t>& mask) {
  const VolumeGeometry& grid = mask.geometry;
  using Mask = itk::Image<unsigned char, 3>;
  using Distance = itk::Image<float, 3>;
  // The filter measures the way to voxels that are set, from outside of them: those beyond.
  std::vector<unsigned char> beyond(mask.values.size());
  std::transform(mask.values.begin(), mask.values.end(), beyond.begin(),
                 [](std::uint8_t set) { return static_cast<unsigned char>(set == 0); });
  const auto import = itk::ImportImageFilter<unsigned char, 3>::New();
  Mask::SizeType size;
  double spacing[3];
  for (unsigned a = 0; a < 3; ++a) {
    size[a] = static_cast<Mask::SizeValueType>(grid.size[a]);
    spacing[a] = grid.spacing[int(a)];
  }
  import->SetRegion(Mask::RegionType(size));
  import->SetSpacing(spacing);
  import->SetImportPointer(beyond.data(), beyond.size(), false);
  const auto filter = itk::SignedMaurerDistanceMapImageFilter<Mask, Distance>::New();
  filter->SetInput(import->GetOutput());
  filter->SetUseImageSpacing(true);
  filter->SetSquaredDistance(false);
  filter->SetInsideIsPositive(false);
  filter->Update();
  Volume<float> depth(grid);
  const float* distance = filter->GetOutput()->GetBufferPointer();
  std::transform(distance, distance + depth.values.size(), depth.values.begin(),
                 [](float d) { return std::max(d, 0.0f); });
  return depth;
}

}  // namespace angio::segmentation::detail
