#include "segmentation/detail/label_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "core/parallel.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr std::size_t kMostLabels = 256;
constexpr double kLeastAlike = 0.9;  ///< of neighbours that are both no background
constexpr double kMostRamps = 0.05;  ///< of the changes along an axis

/// Each value with its count; empty if there are too many for labels.
std::map<float, std::size_t> values_of(const Volume<float>& volume) {
  std::map<float, std::size_t> counts;
  auto last = counts.end();
  for (const float value : volume.values) {
    if (!std::isfinite(value)) return {};
    if (last == counts.end() || last->first != value) {
      last = counts.try_emplace(value, 0).first;
      if (counts.size() > kMostLabels) return {};
    }
    ++last->second;
  }
  return counts;
}

/// How values change from voxel to voxel.
struct Changes {
  std::size_t pairs = 0, alike = 0;  ///< of neighbours that are both no background
  std::size_t jumps = 0, ramps = 0;  ///< of three in a row: two alike; one between the others
  void add(const Changes& other) {
    pairs += other.pairs;
    alike += other.alike;
    jumps += other.jumps;
    ramps += other.ramps;
  }
};

Changes changes_of(const Volume<float>& volume, float background) {
  const auto& size = volume.geometry.size;
  std::vector<Changes> slices(static_cast<std::size_t>(size[2]));
  parallel_for(size[2], [&](std::ptrdiff_t slice) {
    const auto k = int(slice);
    Changes& changes = slices[std::size_t(k)];
    const auto look = [&](float a, float b, float c) {
      if (b != background && c != background) {
        ++changes.pairs;
        changes.alike += b == c;
      }
      changes.jumps += (a == b) != (b == c);
      changes.ramps += (a < b && b < c) || (a > b && b > c);
    };
    for (int j = 1; j + 1 < size[1]; ++j)
      for (int i = 1; i + 1 < size[0]; ++i) {
        const float here = volume.at(i, j, k);
        look(volume.at(i - 1, j, k), here, volume.at(i + 1, j, k));
        look(volume.at(i, j - 1, k), here, volume.at(i, j + 1, k));
        if (k > 0 && k + 1 < size[2]) look(volume.at(i, j, k - 1), here, volume.at(i, j, k + 1));
      }
  });
  Changes all;
  for (const Changes& part : slices) all.add(part);
  return all;
}

}  // namespace

std::vector<Label> find_labels(const Volume<float>& volume) {
  const std::map<float, std::size_t> counts = values_of(volume);
  if (counts.size() < 2) return {};
  const float background = counts.contains(0.0f) ? 0.0f : counts.begin()->first;
  if (counts.size() > 2) {
    for (const auto& entry : counts)
      if (entry.first != std::round(entry.first)) return {};
    const Changes changes = changes_of(volume, background);
    if (double(changes.alike) < kLeastAlike * double(changes.pairs) ||
        double(changes.ramps) > kMostRamps * double(changes.ramps + changes.jumps))
      return {};
  }
  std::vector<Label> labels;
  for (const auto& [value, count] : counts)
    if (value != background) labels.push_back({double(value), count});
  return labels;
}

}  // namespace angio::segmentation::detail
