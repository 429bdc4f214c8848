#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "centerline/detail/bridge_shape.hpp"
#include "centerline/detail/fronts.hpp"
#include "core/parallel.hpp"

namespace angio::centerline {
namespace {

/// Marks the voxels near the paths: within 1.5 radii and two voxels of their middle.
std::vector<char> mark_covered(const LumenVoxels& lumen,
                               const std::vector<std::vector<int>>& paths) {
  struct Ball {
    std::array<int, 3> middle;
    double reach;
  };
  const Vec3 h = lumen.geometry.spacing;
  const double voxel = lumen.geometry.longest_spacing();
  std::vector<char> covered(std::size_t(lumen.count()), 0), done(std::size_t(lumen.count()), 0);
  std::vector<std::vector<Ball>> balls_of_slice(std::size_t(lumen.size[2]));
  for (const std::vector<int>& path : paths)
    for (const int v : path) {
      if (std::exchange(done[std::size_t(v)], char(1)) != 0) continue;
      const Ball ball{lumen.index(v), 1.5 * double(lumen.depth[std::size_t(v)]) + 2.0 * voxel};
      const int span = int(ball.reach / h.z);
      for (int k = std::max(0, ball.middle[2] - span);
           k <= std::min(lumen.size[2] - 1, ball.middle[2] + span); ++k)
        balls_of_slice[std::size_t(k)].push_back(ball);
    }
  const auto ni = std::size_t(lumen.size[0]), nj = std::size_t(lumen.size[1]);
  parallel_for_uneven(lumen.size[2], [&](std::ptrdiff_t k) {
    if (balls_of_slice[std::size_t(k)].empty()) return;
    std::vector<char> cells(ni * nj, 0);
    for (const Ball& ball : balls_of_slice[std::size_t(k)]) {
      const double dz = (int(k) - ball.middle[2]) * h.z;
      const int rows = int(ball.reach / h.y);
      for (int j = std::max(0, ball.middle[1] - rows);
           j <= std::min(lumen.size[1] - 1, ball.middle[1] + rows); ++j) {
        const double dy = (j - ball.middle[1]) * h.y;
        const double rest = ball.reach * ball.reach - dy * dy - dz * dz;
        if (rest < 0.0) continue;
        const int span = int(std::sqrt(rest) / h.x);
        const auto row = cells.begin() + std::ptrdiff_t(std::size_t(j) * ni);
        std::fill(row + std::max(0, ball.middle[0] - span),
                  row + std::min(lumen.size[0], ball.middle[0] + span + 1), char(1));
      }
    }
    const int* voxel_of = &lumen.voxel_of_cell[std::size_t(k) * ni * nj];
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (cells[c] != 0 && voxel_of[c] >= 0) covered[std::size_t(voxel_of[c])] = 1;
  });
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
  return farthest - nearest > std::max(4.0 * radius, 6.0 * lumen.geometry.longest_spacing());
}

/// The tightest places of the widest ways through a piece from one of its contacts to each other:
/// depths [mm], shape [contact].
std::vector<double> widest_ways(const LumenVoxels& lumen, std::vector<int> piece,
                                const std::vector<std::vector<int>>& contacts, std::size_t first) {
  std::unordered_map<int, std::size_t> contact_of;
  for (std::size_t c = 0; c < contacts.size(); ++c)
    for (const int v : contacts[c]) {
      contact_of[v] = c;
      piece.push_back(v);
    }
  std::sort(piece.begin(), piece.end(), [&](int a, int b) {
    const float da = lumen.depth[std::size_t(a)], db = lumen.depth[std::size_t(b)];
    return da != db ? da > db : a < b;
  });
  // Voxels are added from the deepest on, in connected parts; a part is known by its root.
  std::vector<int> parent(std::size_t(lumen.count()), -1);  // by voxel; -1: not added
  std::set<int> with_first;
  std::unordered_map<int, std::set<std::size_t>> waiting;  // contacts that have not met the first
  const auto root = [&](int v) {
    while (parent[std::size_t(v)] != v)
      v = parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
    return v;
  };
  const auto join = [&](int above, int below) {
    parent[std::size_t(above)] = below;
    if (with_first.erase(above) > 0) with_first.insert(below);
    if (auto node = waiting.extract(above); !node.empty())
      waiting[below].merge(std::move(node.mapped()));
  };
  std::vector<double> depths(contacts.size(), 0.0);
  for (const int v : piece) {
    parent[std::size_t(v)] = v;
    if (const auto at = contact_of.find(v); at != contact_of.end()) {
      if (at->second == first)
        with_first.insert(v);
      else
        waiting[v].insert(at->second);
    }
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(v, n);
      if (w >= 0 && parent[std::size_t(w)] >= 0 && root(w) != v) join(root(w), v);
    }
    if (with_first.count(v) == 0) continue;
    if (const auto node = waiting.extract(v); !node.empty())
      for (const std::size_t c : node.mapped())
        depths[c] = std::max(depths[c], double(lumen.depth[std::size_t(v)]));
  }
  return depths;
}

/// A place where two stretches of vessel touch, and a path goes over from one to the other.
struct Bridge {
  Vec3 middle, along;  ///< where it is tightest; the path's direction there
  int voxel = -1;
  double radius = 0.0;  ///< [mm]
};

/// The bridge on a path's way past a piece, if there is one: tighter (0.6) than the way through the
/// piece, shorter than 1.25 of that way's diameters, and with a turn of over 80 degrees, 25 at
/// least on either side, as from one vessel into the one beside it. A stenosed vessel runs on.
/// @param from  index of the path's first voxel that may be the bridge's
std::optional<Bridge> find_bridge(const LumenVoxels& lumen, const std::vector<int>& path,
                                  double other_way, std::size_t from = 0) {
  constexpr double kTighter = 0.6;
  const auto depth = [&](std::size_t i) { return double(lumen.depth[std::size_t(path[i])]); };
  const auto at = [&](std::size_t i) { return lumen.position(path[i]); };
  if (path.size() < from + 3) return std::nullopt;
  std::size_t neck = std::max(from, std::size_t(1));  // not in the caps at either end
  for (std::size_t i = neck; i + 1 < path.size(); ++i)
    if (depth(i) < depth(neck)) neck = i;
  if (depth(neck) >= kTighter * other_way) return std::nullopt;
  std::size_t begin = neck, end = neck;
  while (begin > 0 && depth(begin) < kTighter * other_way) --begin;
  while (end + 1 < path.size() && depth(end) < kTighter * other_way) ++end;
  if (distance(at(begin), at(end)) > kBridgeFromAxisToAxis * 2.0 * other_way) return std::nullopt;
  const auto away = [&](int direction, double reach) {
    auto i = std::ptrdiff_t(neck);
    while (i + direction >= 0 && i + direction < std::ptrdiff_t(path.size()) &&
           distance(at(std::size_t(i)), at(neck)) < reach)
      i += direction;
    return at(std::size_t(i));
  };
  const Vec3 across = normalized(away(1, other_way) - away(-1, other_way));
  const auto turn = [&](int direction) {
    const Vec3 chord = away(direction, 3.0 * other_way) - away(direction, other_way);
    if (norm(chord) == 0.0) return 0.0;
    return std::acos(std::clamp(double(direction) * dot(normalized(chord), across), -1.0, 1.0));
  };
  const double before = turn(-1), behind = turn(1);
  if (before + behind < kBridgeTurning || std::min(before, behind) < kBridgeLeastTurn)
    return std::nullopt;
  return Bridge{at(neck), across, path[neck], depth(neck)};
}

/// Cuts the links over the plane across a bridge, around its middle.
std::vector<int> cut_bridge(LumenVoxels& lumen, const Bridge& bridge) {
  const double reach = 2.0 * bridge.radius + 2.0 * lumen.geometry.longest_spacing();
  std::vector<int> near{bridge.voxel};
  std::set<int> seen{bridge.voxel};
  for (std::size_t next = 0; next < near.size(); ++next)
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(near[next], n);
      if (w >= 0 && distance(lumen.position(w), bridge.middle) < reach && seen.insert(w).second)
        near.push_back(w);
    }
  const auto is_behind = [&](int v) {
    return dot(lumen.position(v) - bridge.middle, bridge.along) >= 0.0;
  };
  std::vector<int> at_cut;
  for (const int v : near)
    for (int n = 0; n < kNeighborCount && !is_behind(v); ++n) {
      const int w = lumen.neighbor(v, n);
      if (w < 0 || !is_behind(w)) continue;
      lumen.cut(v, n);
      at_cut.insert(at_cut.end(), {v, w});
    }
  return at_cut;
}

/// The way along the paths from one contact of a piece to another.
std::vector<int> way_between(const Front& front, int from, int to) {
  std::vector<int> first = trace(front, from), second = trace(front, to);
  std::size_t shared = 0;
  while (shared < first.size() && shared < second.size() && first[shared] == second[shared])
    ++shared;
  std::vector<int> way(first.rbegin(), first.rend() - std::ptrdiff_t(shared));
  if (shared > 0) way.push_back(first[shared - 1]);
  way.insert(way.end(), second.begin() + std::ptrdiff_t(shared), second.end());
  return way;
}

/// The deepest voxel: there a contact is best centred.
int deepest(const LumenVoxels& lumen, const std::vector<int>& voxels) {
  return *std::max_element(voxels.begin(), voxels.end(), [&](int a, int b) {
    return lumen.depth[std::size_t(a)] < lumen.depth[std::size_t(b)];
  });
}

/// The voxel that lies a way [mm] back on the path to a voxel.
int behind(const LumenVoxels& lumen, const Front& front, int voxel, double way) {
  const Vec3 from = lumen.position(voxel);
  int v = voxel;
  while (front.previous[std::size_t(v)] >= 0 && distance(lumen.position(v), from) < way)
    v = front.previous[std::size_t(v)];
  return v;
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
    const std::vector<double> other_ways = widest_ways(lumen, piece, contacts, first);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      if (c == first) continue;
      const auto bridge = find_bridge(
          lumen, way_between(front, deepest(lumen, contacts[first]), deepest(lumen, contacts[c])),
          other_ways[c]);
      if (bridge) {
        const std::vector<int> cut = cut_bridge(lumen, *bridge);
        at_cut.insert(at_cut.end(), cut.begin(), cut.end());
        continue;
      }
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

double radius_behind(const LumenVoxels& lumen, const Front& front, int tip) {
  double deepest = 0.0;
  for (int v = tip; v >= 0; v = front.previous[std::size_t(v)]) {
    deepest = std::max(deepest, double(lumen.depth[std::size_t(v)]));
    if (distance(lumen.position(v), lumen.position(tip)) >
        2.0 * deepest + lumen.geometry.longest_spacing())
      break;
  }
  return deepest;
}

std::optional<int> meeting_front(const LumenVoxels& lumen, const Front& front, int tip) {
  constexpr double kAround = 3.0;                           // voxels
  constexpr double kBack = 4.0, kApart = 2.0, kOwn = 10.0;  // radii
  const Vec3 at = lumen.position(tip);
  const double radius = radius_behind(lumen, front, tip);
  std::vector<int> own;  // as far as what lies behind its surroundings can be near it
  for (int v = tip; v >= 0 && distance(lumen.position(v), at) < kOwn * radius;
       v = front.previous[std::size_t(v)])
    own.push_back(v);
  const auto comes_from_elsewhere = [&](int v) {
    const Vec3 from = lumen.position(behind(lumen, front, v, kBack * radius));
    return std::none_of(own.begin(), own.end(),
                        [&](int w) { return distance(lumen.position(w), from) < kApart * radius; });
  };
  const double reach = kAround * lumen.geometry.longest_spacing();
  std::vector<int> near{tip};
  for (std::size_t next = 0; next < near.size(); ++next) {
    if (comes_from_elsewhere(near[next])) return near[next];
    for (int n = 0; n < kNeighborCount; ++n) {
      const int w = lumen.neighbor(near[next], n);
      if (w >= 0 && distance(lumen.position(w), at) < reach &&
          std::find(near.begin(), near.end(), w) == near.end())
        near.push_back(w);
    }
  }
  return std::nullopt;
}

std::vector<int> cut_bridge_behind(LumenVoxels& lumen, const Front& front, int tip, int met) {
  std::vector<int> ways[] = {trace(front, tip), trace(front, met)};
  std::size_t shared = 0;
  while (shared < ways[0].size() && shared < ways[1].size() && ways[0][shared] == ways[1][shared])
    ++shared;
  const double reach_of_tip = 2.0 * radius_behind(lumen, front, tip);
  for (std::vector<int>& way : ways) {  // without the tip, where both are near the wall
    const int last = behind(lumen, front, way.back(), reach_of_tip);
    way.erase(std::find(way.begin(), way.end(), last), way.end());
    if (way.size() <= shared) return {};
  }
  const auto least_depth = [&](const std::vector<int>& way) {
    double least = 1e300;
    for (std::size_t i = shared; i < way.size(); ++i)
      least = std::min(least, double(lumen.depth[std::size_t(way[i])]));
    return least;
  };
  for (const int w : {0, 1})
    if (const auto bridge = find_bridge(lumen, ways[w], least_depth(ways[1 - w]), shared))
      return cut_bridge(lumen, *bridge);
  return {};
}

}  // namespace angio::centerline
