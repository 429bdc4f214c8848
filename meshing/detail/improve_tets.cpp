#include "meshing/detail/improve_tets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "air_mesh/build/tet_shape.hpp"

namespace angio::meshing::detail {
namespace {

class TetImprover {
 public:
  TetImprover(TetMesh& mesh, int fixed_count, double goal_degrees)
      : mesh_(mesh),
        fixed_count_(fixed_count),
        goal_(std::sin(goal_degrees * std::numbers::pi / 180.0)),
        tets_(mesh.tets),
        alive_(mesh.tets.size(), 1),
        around_(mesh.vertices.size()) {
    for (std::size_t t = 0; t < tets_.size(); ++t) {
      quality_.push_back(quality(tets_[t]));
      for (const int v : tets_[t]) around_[std::size_t(v)].push_back(int(t));
    }
    collect_boundary_edges();
  }

  void run() {
    constexpr int kPasses = 30;
    for (int pass = 0; pass < kPasses; ++pass) {
      std::vector<int> poor = poor_tets();
      if (poor.empty()) break;
      int done = 0;
      for (const int t : poor)
        if (alive_[std::size_t(t)] && quality_[std::size_t(t)] < goal_)
          done += improve(t, pass >= 2) ? 1 : 0;
      if (done == 0 && pass >= 2) break;
    }
    store();
  }

 private:
  [[nodiscard]] const Vec3& at(int v) const { return mesh_.vertices[std::size_t(v)]; }
  [[nodiscard]] double quality(const Tet& t) const {
    return air_mesh::least_dihedral_sine(at(t[0]), at(t[1]), at(t[2]), at(t[3]));
  }
  [[nodiscard]] bool is_fixed(int v) const { return v < fixed_count_; }

  /// The worst first; ties by index.
  [[nodiscard]] std::vector<int> poor_tets() const {
    std::vector<int> poor;
    for (std::size_t t = 0; t < tets_.size(); ++t)
      if (alive_[t] && quality_[t] < goal_) poor.push_back(int(t));
    std::stable_sort(poor.begin(), poor.end(), [&](int a, int b) {
      return quality_[std::size_t(a)] < quality_[std::size_t(b)];
    });
    return poor;
  }

  void collect_boundary_edges() {
    std::vector<std::array<int, 3>> faces;
    for (const Tet& t : tets_)
      for (const auto& f : air_mesh::kTetFaces) {
        std::array<int, 3> face{t[std::size_t(f[0])], t[std::size_t(f[1])], t[std::size_t(f[2])]};
        std::sort(face.begin(), face.end());
        faces.push_back(face);
      }
    std::sort(faces.begin(), faces.end());
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (i + 1 < faces.size() && faces[i] == faces[i + 1]) {
        ++i;
        continue;
      }
      const auto& [a, b, c] = faces[i];
      for (const auto& edge : {std::array<int, 2>{a, b}, {b, c}, {a, c}})
        boundary_edges_.push_back(edge);
    }
    std::sort(boundary_edges_.begin(), boundary_edges_.end());
  }
  [[nodiscard]] bool is_boundary_edge(int a, int b) const {
    return is_fixed(a) && is_fixed(b) &&
           std::binary_search(boundary_edges_.begin(), boundary_edges_.end(),
                              std::array<int, 2>{std::min(a, b), std::max(a, b)});
  }

  // === Bookkeeping ===

  void remove(int t) {
    alive_[std::size_t(t)] = 0;
    for (const int v : tets_[std::size_t(t)]) std::erase(around_[std::size_t(v)], t);
  }
  void add(const Tet& t) {
    for (const int v : t) around_[std::size_t(v)].push_back(int(tets_.size()));
    tets_.push_back(t);
    alive_.push_back(1);
    quality_.push_back(quality(t));
  }
  void replace(const std::vector<int>& old_tets, const std::vector<Tet>& new_tets) {
    for (const int t : old_tets) remove(t);
    for (const Tet& t : new_tets) add(t);
  }
  [[nodiscard]] double least_quality(const std::vector<int>& tets) const {
    double least = 1.0;
    for (const int t : tets) least = std::min(least, quality_[std::size_t(t)]);
    return least;
  }
  static bool holds(const Tet& t, int v) { return std::find(t.begin(), t.end(), v) != t.end(); }
  [[nodiscard]] std::vector<int> tets_at_edge(int a, int b) const {
    std::vector<int> found;
    for (const int t : around_[std::size_t(a)])
      if (holds(tets_[std::size_t(t)], b)) found.push_back(t);
    return found;
  }
  /// With `from` replaced by `to`.
  static Tet renamed(Tet t, int from, int to) {
    std::replace(t.begin(), t.end(), from, to);
    return t;
  }
  static constexpr double kGain = 1e-4;  // a step must raise the least sine by this

  // === Steps ===

  bool improve(int t, bool with_insertion) {
    const Tet corners = tets_[std::size_t(t)];
    for (const int v : corners) {
      move(v);
      if (quality_[std::size_t(t)] >= goal_) return true;
    }
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (remove_edge(corners[i], corners[j])) return true;
    for (std::size_t f = 0; f < 4; ++f)
      if (remove_face(t, f)) return true;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (i != j && contract(corners[i], corners[j])) return true;
    return with_insertion && split_some_edge(t);
  }

  /// Pattern search for the place of an inner vertex that is best for its worst tetrahedron.
  bool move(int v) {
    if (is_fixed(v)) return false;
    const std::vector<int>& star = around_[std::size_t(v)];
    Vec3& x = mesh_.vertices[std::size_t(v)];
    const double start = least_quality(star);
    double best = start;
    double reach = std::numeric_limits<double>::infinity();
    for (const int t : star)
      for (const int u : tets_[std::size_t(t)])
        if (u != v) reach = std::min(reach, distance(x, at(u)));
    constexpr double kDirections[14][3] = {
        {1, 0, 0},  {-1, 0, 0}, {0, 1, 0},  {0, -1, 0},  {0, 0, 1},   {0, 0, -1},  {1, 1, 1},
        {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}};
    for (double step = 0.3 * reach; step > 0.01 * reach;) {
      const Vec3 from = x;
      Vec3 best_place = from;
      for (const auto& d : kDirections) {
        x = from + step * normalized(Vec3{d[0], d[1], d[2]});
        double least = 1.0;
        for (const int t : star) {
          least = std::min(least, quality(tets_[std::size_t(t)]));
          if (least <= best) break;
        }
        if (least <= best) continue;
        best = least;
        best_place = x;
      }
      x = best_place;
      if (best_place == from) step *= 0.5;
    }
    for (const int t : star) quality_[std::size_t(t)] = quality(tets_[std::size_t(t)]);
    return best > start + kGain;
  }

  /// The vertices around an edge in the order in which a right hand turns from a to b; empty if the
  /// tetrahedra there do not close a ring.
  [[nodiscard]] std::vector<int> ring(int a, int b, const std::vector<int>& tets) const {
    std::vector<std::array<int, 2>> steps;
    for (const int t : tets) {
      std::array<int, 2> others{};
      std::size_t count = 0;
      for (const int v : tets_[std::size_t(t)])
        if (v != a && v != b) others[count++] = v;
      if (tet_volume(at(a), at(b), at(others[0]), at(others[1])) < 0.0)
        std::swap(others[0], others[1]);
      steps.push_back(others);
    }
    std::vector<int> result{steps.front()[0]};
    int next = steps.front()[1];
    for (std::size_t i = 1; i < steps.size(); ++i) {
      result.push_back(next);
      const auto step =
          std::find_if(steps.begin(), steps.end(), [&](const auto& s) { return s[0] == next; });
      if (step == steps.end()) return {};
      next = (*step)[1];
    }
    if (next != result.front()) return {};
    return result;
  }

  /// The best triangulation of the ring around an inner edge takes the edge's place.
  bool remove_edge(int a, int b) {
    constexpr std::size_t kLargestRing = 9;
    if (is_boundary_edge(a, b)) return false;
    const std::vector<int> tets = tets_at_edge(a, b);
    const std::size_t n = tets.size();
    if (n < 3 || n > kLargestRing) return false;
    const std::vector<int> r = ring(a, b, tets);
    if (r.size() != n) return false;
    // best[i][j]: of the part between ring vertices i and j (Klincsek's dynamic program).
    double best[kLargestRing][kLargestRing];
    std::size_t middle[kLargestRing][kLargestRing];
    for (std::size_t i = 0; i + 1 < n; ++i) best[i][i + 1] = 1.0;
    for (std::size_t width = 2; width < n; ++width)
      for (std::size_t i = 0; i + width < n; ++i) {
        const std::size_t j = i + width;
        best[i][j] = -2.0;
        middle[i][j] = i + 1;
        for (std::size_t k = i + 1; k < j; ++k) {
          double least = std::min(best[i][k], best[k][j]);
          if (least <= best[i][j]) continue;
          least = std::min({least, quality({a, r[i], r[k], r[j]}), quality({b, r[i], r[j], r[k]})});
          if (least <= best[i][j]) continue;
          best[i][j] = least;
          middle[i][j] = k;
        }
      }
    if (best[0][n - 1] <= least_quality(tets) + kGain) return false;
    std::vector<Tet> new_tets;
    std::vector<std::array<std::size_t, 2>> stack{{0, n - 1}};
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      if (j - i < 2) continue;
      const std::size_t k = middle[i][j];
      new_tets.push_back({a, r[i], r[k], r[j]});
      new_tets.push_back({b, r[i], r[j], r[k]});
      stack.push_back({i, k});
      stack.push_back({k, j});
    }
    replace(tets, new_tets);
    return true;
  }

  /// Two tetrahedra at a face become three around the edge between their tips.
  bool remove_face(int t, std::size_t face) {
    const Tet corners = tets_[std::size_t(t)];
    const int tip = corners[face];
    const int a = corners[std::size_t(air_mesh::kTetFaces[face][0])];
    const int b = corners[std::size_t(air_mesh::kTetFaces[face][1])];
    const int c = corners[std::size_t(air_mesh::kTetFaces[face][2])];
    for (const int other : around_[std::size_t(a)]) {
      const Tet& far = tets_[std::size_t(other)];
      if (other == t || !holds(far, b) || !holds(far, c)) continue;
      const int far_tip = far[0] + far[1] + far[2] + far[3] - a - b - c;
      if (!tets_at_edge(tip, far_tip).empty()) return false;
      const std::vector<Tet> new_tets{
          {tip, a, b, far_tip}, {tip, b, c, far_tip}, {tip, c, a, far_tip}};
      double after = 1.0;
      for (const Tet& n : new_tets) after = std::min(after, quality(n));
      if (after <= least_quality({t, other}) + kGain) return false;
      replace({t, other}, new_tets);
      return true;
    }
    return false;
  }

  /// An inner vertex goes into its neighbour.
  bool contract(int from, int to) {
    if (is_fixed(from)) return false;
    const std::vector<int> star = around_[std::size_t(from)];
    double after = 1.0;
    std::vector<Tet> new_tets;
    for (const int t : star) {
      if (holds(tets_[std::size_t(t)], to)) continue;
      new_tets.push_back(renamed(tets_[std::size_t(t)], from, to));
      after = std::min(after, quality(new_tets.back()));
      if (after <= kGain) return false;
    }
    if (after <= least_quality(star) + kGain) return false;
    replace(star, new_tets);
    return true;
  }

  /// A new vertex in the middle of the inner edge where it helps most, then moved.
  bool split_some_edge(int t) {
    const Tet corners = tets_[std::size_t(t)];
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (!is_boundary_edge(corners[i], corners[j]) && split(corners[i], corners[j])) return true;
    return false;
  }

  bool split(int a, int b) {
    const std::vector<int> tets = tets_at_edge(a, b);
    const double before = least_quality(tets);
    const int v = int(mesh_.vertices.size());
    mesh_.vertices.push_back(0.5 * (at(a) + at(b)));
    around_.emplace_back();
    std::vector<Tet> old_tets;
    std::vector<Tet> new_tets;
    for (const int t : tets) {
      old_tets.push_back(tets_[std::size_t(t)]);
      new_tets.push_back(renamed(old_tets.back(), a, v));
      new_tets.push_back(renamed(old_tets.back(), b, v));
    }
    const std::size_t first = tets_.size();
    replace(tets, new_tets);
    move(v);
    double after = 1.0;
    for (std::size_t t = first; t < tets_.size(); ++t) after = std::min(after, quality_[t]);
    if (after > before + kGain) return true;
    std::vector<int> added;
    for (std::size_t t = first; t < tets_.size(); ++t) added.push_back(int(t));
    replace(added, old_tets);
    return false;
  }

  // === Result ===

  void store() {
    std::vector<int> index(mesh_.vertices.size(), -1);
    std::vector<Vec3> vertices;
    for (std::size_t v = 0; v < index.size(); ++v) {
      if (!is_fixed(int(v)) && around_[v].empty()) continue;
      index[v] = int(vertices.size());
      vertices.push_back(mesh_.vertices[v]);
    }
    mesh_.vertices = std::move(vertices);
    mesh_.tets.clear();
    for (std::size_t t = 0; t < tets_.size(); ++t) {
      if (!alive_[t]) continue;
      Tet tet = tets_[t];
      for (int& v : tet) v = index[std::size_t(v)];
      mesh_.tets.push_back(tet);
    }
  }

  TetMesh& mesh_;
  int fixed_count_;
  double goal_;  ///< sine
  std::vector<Tet> tets_;
  std::vector<char> alive_;
  std::vector<double> quality_;
  std::vector<std::vector<int>> around_;            ///< tets of each vertex
  std::vector<std::array<int, 2>> boundary_edges_;  ///< ascending
};

}  // namespace

void improve_tets(TetMesh& mesh, int fixed_count, double goal_degrees) {
  TetImprover(mesh, fixed_count, goal_degrees).run();
}

}  // namespace angio::meshing::detail
