#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "centerline/detail/fronts.hpp"

namespace angio::centerline {
namespace {

/// Marks the voxels near the paths: within 1.5 radii and two voxels of their middle.
std::vector<char> mark_covered(const LumenVoxels& lumen,
                               const std::vector<std::vector<int>>& paths) {
  std::vector<char> covered(std::size_t(lumen.count()), 0), done(std::size_t(lumen.count()), 0);
  const Vec3 h = lumen.geometry.spacing;
  const double voxel = std::max({h.x, h.y, h.z});
  for (const std::vector<int>& path : paths)
    for (const int v : path) {
      if (done[std::size_t(v)] != 0) continue;
      done[std::size_t(v)] = 1;
      const double reach = 1.5 * double(lumen.depth[std::size_t(v)]) + 2.0 * voxel;
      const auto at = lumen.index(v);
      int low[3], high[3];
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = std::size_t(axis);
        const int span = int(reach / h[axis]);
        low[axis] = std::max(0, at[a] - span);
        high[axis] = std::min(lumen.size[a] - 1, at[a] + span);
      }
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int i = low[0]; i <= high[0]; ++i) {
            const Vec3 d{(i - at[0]) * h.x, (j - at[1]) * h.y, (k - at[2]) * h.z};
            const int w =
                lumen.voxel_of_cell[std::size_t((k * lumen.size[1] + j) * lumen.size[0] + i)];
            if (w >= 0 && norm_squared(d) <= reach * reach) covered[std::size_t(w)] = 1;
          }
    }
  return covered;
}

/// Connected voxels of the same mark, starting at `seed`; sets `seen`.
std::vector<int> gather(const LumenVoxels& lumen, const std::vector<char>& covered, int seed,
                        std::vector<char>& seen) {
  std::vector<int> piece{seed};
  seen[std::size_t(seed)] = 1;
  for (std::size_t next = 0; next < piece.size(); ++next)
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(piece[next], n);
      if (w < 0 || seen[std::size_t(w)] != 0 ||
          covered[std::size_t(w)] != covered[std::size_t(seed)])
        continue;
      seen[std::size_t(w)] = 1;
      piece.push_back(w);
    }
  return piece;
}

/// The covered voxels next to a piece, in connected contacts.
std::vector<std::vector<int>> find_contacts(const LumenVoxels& lumen,
                                            const std::vector<char>& covered,
                                            const std::vector<int>& piece) {
  std::map<int, bool> touched;  // voxel, visited
  for (const int v : piece)
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(v, n);
      if (w >= 0 && covered[std::size_t(w)] != 0) touched.emplace(w, false);
    }
  std::vector<std::vector<int>> contacts;
  for (auto& [seed, visited] : touched) {
    if (visited) continue;
    visited = true;
    std::vector<int> contact{seed};
    for (std::size_t next = 0; next < contact.size(); ++next)
      for (int n = 0; n < kNeighborCount; ++n) {
        const auto it = touched.find(lumen.neighbor(contact[next], n));
        if (it == touched.end() || it->second) continue;
        it->second = true;
        contact.push_back(it->first);
      }
    contacts.push_back(std::move(contact));
  }
  return contacts;
}

double mean_length(const Front& front, const std::vector<int>& voxels) {
  double sum = 0.0;
  for (const int v : voxels) sum += front.length[std::size_t(v)];
  return sum / double(voxels.size());
}

/// True when a piece is a vessel and no crumb between a path's tube and a ragged wall.
bool is_long(const LumenVoxels& lumen, const Front& front, const std::vector<int>& piece) {
  double nearest = front.length[std::size_t(piece.front())], farthest = nearest, radius = 0.0;
  for (const int v : piece) {
    nearest = std::min(nearest, front.length[std::size_t(v)]);
    farthest = std::max(farthest, front.length[std::size_t(v)]);
    radius = std::max(radius, double(lumen.depth[std::size_t(v)]));
  }
  const Vec3 h = lumen.geometry.spacing;
  return farthest - nearest > std::max(4.0 * radius, 6.0 * std::max({h.x, h.y, h.z}));
}

}  // namespace

std::vector<int> cut_loops(LumenVoxels& lumen, const Front& front,
                           const std::vector<std::vector<int>>& paths) {
  const std::vector<char> covered = mark_covered(lumen, paths);
  std::vector<char> seen(std::size_t(lumen.count()), 0);
  std::vector<int> at_cut;
  for (int seed = 0; seed < lumen.count(); ++seed) {
    if (covered[std::size_t(seed)] != 0 || seen[std::size_t(seed)] != 0) continue;
    const std::vector<int> piece = gather(lumen, covered, seed, seen);
    if (!is_long(lumen, front, piece)) continue;
    const auto contacts = find_contacts(lumen, covered, piece);
    if (contacts.size() < 2) continue;
    // Only the contact that was reached first stays.
    std::size_t first = 0;
    for (std::size_t c = 1; c < contacts.size(); ++c)
      if (mean_length(front, contacts[c]) < mean_length(front, contacts[first])) first = c;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      if (c == first) continue;
      for (const int v : contacts[c])
        for (int n = 0; n < kNeighborCount; ++n) {
          const int w = lumen.neighbor(v, n);
          if (w < 0 || covered[std::size_t(w)] != 0) continue;
          at_cut.push_back(w);
          lumen.cut(v, n);
        }
    }
  }
  std::sort(at_cut.begin(), at_cut.end());
  at_cut.erase(std::unique(at_cut.begin(), at_cut.end()), at_cut.end());
  return at_cut;
}

}  // namespace angio::centerline
