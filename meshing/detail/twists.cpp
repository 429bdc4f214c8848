#include "meshing/detail/twists.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "meshing/detail/edge_table.hpp"

namespace angio::meshing::detail {
namespace {

/// Two triangles at an edge that no other one has.
struct Neighbors {
  int a = 0, b = 0;
  bool is_alike = true;   ///< they go round the same way
  double flatness = 0.0;  ///< cosine of their turn about the edge, 1: flat, -1: folded back
};

std::vector<Neighbors> find_neighbors(const TriangleMesh& mesh) {
  std::vector<Vec3> normals;
  for (const Triangle& t : mesh.triangles)
    normals.push_back(normalized(area_vector_doubled(mesh, t)));
  std::vector<Neighbors> all;
  for (const auto& [key, at] : EdgeTable(mesh)) {
    if (at.size() != 2) continue;
    const auto first = [&](int side) {
      return mesh.triangles[std::size_t(side / 3)][std::size_t(side % 3)];
    };
    Neighbors pair{at[0] / 3, at[1] / 3, first(at[0]) != first(at[1])};
    pair.flatness = (pair.is_alike ? 1.0 : -1.0) *
                    dot(normals[std::size_t(pair.a)], normals[std::size_t(pair.b)]);
    all.push_back(pair);
  }
  return all;
}

/// Triangles joined to sheets, each with its side: whether it goes round as the sheet's first one.
class Sides {
 public:
  explicit Sides(std::size_t count) : parent_(count), size_(count, 1), is_turned_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  /// @return false if both are of one sheet already, and turned otherwise there
  bool join(const Neighbors& pair) {
    auto [root, turned] = find(pair.a);
    auto [other, other_turned] = find(pair.b);
    const bool differ = turned != other_turned;
    if (root == other) return differ != pair.is_alike;
    if (size_[std::size_t(root)] < size_[std::size_t(other)]) std::swap(root, other);
    parent_[std::size_t(other)] = root;
    size_[std::size_t(root)] += size_[std::size_t(other)];
    is_turned_[std::size_t(other)] = char(differ == pair.is_alike);
    return true;
  }

 private:
  /// The sheet's first triangle, and whether this one is turned against it.
  [[nodiscard]] std::pair<int, bool> find(int t) const {
    bool turned = false;
    for (; parent_[std::size_t(t)] != t; t = parent_[std::size_t(t)])
      turned = turned != (is_turned_[std::size_t(t)] != 0);
    return {t, turned};
  }

  std::vector<int> parent_, size_;
  std::vector<char> is_turned_;  ///< against the parent
};

double extent_of(const TriangleMesh& mesh) {
  Vec3 low{1e300, 1e300, 1e300}, high = -1.0 * low;
  for (const Triangle& t : mesh.triangles)
    for (const int v : t)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], mesh.vertices[std::size_t(v)][axis]);
        high[axis] = std::max(high[axis], mesh.vertices[std::size_t(v)][axis]);
      }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

/// The ways over the edges that are no twists, from middle to middle.
class Ways {
 public:
  Ways(const TriangleMesh& mesh, const std::vector<Neighbors>& sound) : mesh_(mesh) {
    for (const Neighbors& pair : sound) {
      next_[pair.a].push_back(pair.b);
      next_[pair.b].push_back(pair.a);
    }
  }
  /// Whether there is one no longer than `most` (Dijkstra).
  [[nodiscard]] bool has(int from, int to, double most) const {
    std::map<int, double> length{{from, 0.0}};
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    queue.emplace(0.0, from);
    while (!queue.empty()) {
      const auto [here, t] = queue.top();
      queue.pop();
      if (t == to) return true;
      const auto around = next_.find(t);
      if (here > length.at(t) || around == next_.end()) continue;
      for (const int u : around->second) {
        const double there = here + distance(middle(t), middle(u));
        const auto [known, is_new] = length.try_emplace(u, there);
        if (there > most || (!is_new && known->second <= there)) continue;
        known->second = there;
        queue.emplace(there, u);
      }
    }
    return false;
  }

 private:
  [[nodiscard]] Vec3 middle(int t) const {
    Vec3 sum;
    for (std::size_t c = 0; c < 3; ++c) sum += corner(mesh_, std::size_t(t), c) / 3.0;
    return sum;
  }
  const TriangleMesh& mesh_;
  std::map<int, std::vector<int>> next_;
};

}  // namespace

Count cut_out_twists(TriangleMesh& mesh) {
  constexpr double kShort = 0.25;  // of the surface's extent
  std::vector<Neighbors> sound = find_neighbors(mesh), twists;
  std::stable_sort(sound.begin(), sound.end(),
                   [](const Neighbors& x, const Neighbors& y) { return x.flatness > y.flatness; });
  Sides sides(mesh.triangles.size());
  std::erase_if(sound, [&](const Neighbors& pair) {
    if (sides.join(pair)) return false;
    twists.push_back(pair);
    return true;
  });
  Count cut;
  if (twists.empty()) return cut;
  const Ways ways(mesh, sound);
  const double most = kShort * extent_of(mesh);
  const auto area = [&](int t) {
    return norm(area_vector_doubled(mesh, mesh.triangles[std::size_t(t)]));
  };
  std::vector<char> keep(mesh.triangles.size(), 1);
  for (const Neighbors& pair : twists) {
    if (keep[std::size_t(pair.a)] == 0 || keep[std::size_t(pair.b)] == 0) continue;
    if (!ways.has(pair.a, pair.b, most)) return {};
    const int smaller = area(pair.a) < area(pair.b) ? pair.a : pair.b;
    keep[std::size_t(smaller)] = 0;
    cut.add(corner(mesh, std::size_t(smaller), 0));
  }
  mesh = part_of(mesh, keep);
  return cut;
}

}  // namespace angio::meshing::detail
