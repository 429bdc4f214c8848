#include "segmentation/detail/thin_vessels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"
#include "segmentation/detail/components.hpp"
#include "segmentation/detail/fields.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kLeastSpanVoxels = 6.0;

/// The box of a piece, in voxels.
struct Span {
  std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30};
  std::array<int, 3> high{-1, -1, -1};
  Vec3 middle;  ///< of the middle run
  void add(const Pieces::Run& run) {
    low = {std::min(low[0], run.first), std::min(low[1], run.j), std::min(low[2], run.k)};
    high = {std::max(high[0], run.last - 1), std::max(high[1], run.j), std::max(high[2], run.k)};
  }
  [[nodiscard]] double length(const Vec3& h) const {
    return std::hypot((high[0] - low[0]) * h.x, (high[1] - low[1]) * h.y, (high[2] - low[2]) * h.z);
  }
};

/// What was seen and holds no lumen.
Volume<std::uint8_t> unheld(const Volume<std::uint8_t>& seen, const Volume<float>& level_set) {
  const VolumeGeometry& grid = seen.geometry;
  const double near = mean_spacing(grid);
  Volume<std::uint8_t> mask(grid, 0);
  parallel_for(grid.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!seen.at(i, j, int(k))) continue;
        const Vec3 place = grid.lps_from_index({double(i), double(j), double(k)});
        const Vec3 index = level_set.geometry.index_from_lps(place);
        bool is_outside = false;
        for (int a = 0; a < 3; ++a)
          is_outside |= index[a] < -0.5 || index[a] > level_set.geometry.size[std::size_t(a)] - 0.5;
        mask.at(i, j, int(k)) = is_outside || interpolate(level_set, place) > near;
      }
  });
  return mask;
}

}  // namespace

std::string warn_of_thin_vessels(const Volume<std::uint8_t>& seen, const Volume<float>& level_set) {
  const Volume<std::uint8_t> mask = unheld(seen, level_set);
  const Pieces pieces = find_pieces(mask, Connectivity::corners);
  std::vector<Span> spans(std::size_t(pieces.count()) + 1);
  std::vector<std::size_t> run_count(spans.size(), 0);
  for (const Pieces::Run& run : pieces.runs) {
    spans[std::size_t(run.label)].add(run);
    ++run_count[std::size_t(run.label)];
  }
  std::vector<std::size_t> passed(spans.size(), 0);
  for (const Pieces::Run& run : pieces.runs)
    if (passed[std::size_t(run.label)]++ == run_count[std::size_t(run.label)] / 2)
      spans[std::size_t(run.label)].middle = {0.5 * (run.first + run.last - 1), double(run.j),
                                              double(run.k)};
  const Vec3& h = seen.geometry.spacing;
  const double least = kLeastSpanVoxels * mean_spacing(seen.geometry);
  int count = 0;
  std::size_t longest = 0;
  double length = 0.0;
  for (std::size_t p = 1; p < spans.size(); ++p) {
    if (spans[p].length(h) < least) continue;
    ++count;
    if (spans[p].length(h) <= length) continue;
    length = spans[p].length(h);
    longest = p;
  }
  if (count == 0) return {};
  const Vec3 place = seen.geometry.lps_from_index(spans[longest].middle);
  return std::to_string(count) +
         (count == 1 ? " thin vessel or part of one" : " thin vessels or parts of them") +
         " can be seen but not measured (about as thin as a voxel, or lost in noise) and were left "
         "out, the longest of " +
         format_number(length) + " mm around " + format_place(place) +
         "; a seed there or a smaller least radius may find more "
         "(segmentation.seeds_lps_mm, segmentation.smallest_radius_mm)";
}

}  // namespace angio::segmentation::detail
