#include "air_mesh/folds.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace angio::air_mesh {
namespace {

using Corners = std::array<Vec3, 4>;

struct BoxedTet {
  int slot;
  Corners corners;
  Vec3 low, high;
};

BoxedTet boxed(const TetTopology& air, const std::vector<Vec3>& x, int slot) {
  const Tet& t = air.tet(slot);
  const Vec3& first = x[std::size_t(t[0])];
  BoxedTet tet{slot, {}, first, first};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& p = tet.corners[i] = x[std::size_t(t[i])];
    for (int k = 0; k < 3; ++k) {
      tet.low[k] = std::min(tet.low[k], p[k]);
      tet.high[k] = std::max(tet.high[k], p[k]);
    }
  }
  return tet;
}

bool boxes_overlap(const BoxedTet& a, const BoxedTet& b) {
  for (int k = 0; k < 3; ++k)
    if (a.high[k] <= b.low[k] || b.high[k] <= a.low[k]) return false;
  return true;
}

/// Does a plane with this normal part them?
bool parts(const Vec3& normal, const Corners& a, const Corners& b) {
  constexpr double kRounding = 1e-9;   // [mm]
  constexpr double kNoNormal = 1e-20;  // of edges that are parallel
  const double length = norm(normal);
  if (!(length > kNoNormal)) return false;
  double a_least = dot(normal, a[0]), a_most = a_least, b_least = dot(normal, b[0]),
         b_most = b_least;
  for (std::size_t i = 1; i < 4; ++i) {
    const double on_a = dot(normal, a[i]), on_b = dot(normal, b[i]);
    a_least = std::min(a_least, on_a);
    a_most = std::max(a_most, on_a);
    b_least = std::min(b_least, on_b);
    b_most = std::max(b_most, on_b);
  }
  const double bearable = kRounding * length;
  return a_most <= b_least + bearable || b_most <= a_least + bearable;
}

bool a_face_parts(const Corners& a, const Corners& b) {
  return std::any_of(kTetFace.begin(), kTetFace.end(), [&](const Triangle& f) {
    const Vec3& p = a[std::size_t(f[0])];
    return parts(cross(a[std::size_t(f[1])] - p, a[std::size_t(f[2])] - p), a, b);
  });
}

constexpr std::array<std::array<std::size_t, 2>, 6> kTetEdge{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

bool edges_part(const Corners& a, const Corners& b) {
  for (const auto& [i, j] : kTetEdge)
    for (const auto& [k, l] : kTetEdge)
      if (parts(cross(a[j] - a[i], b[l] - b[k]), a, b)) return true;
  return false;
}

bool overlap(const BoxedTet& one, const BoxedTet& other) {
  const Corners &a = one.corners, &b = other.corners;
  return boxes_overlap(one, other) && !a_face_parts(a, b) && !a_face_parts(b, a) &&
         !edges_part(a, b);
}

}  // namespace

Folds find_folds(const TetTopology& air, const std::vector<Vec3>& x,
                 const std::vector<double>& quality) {
  Folds folds;
  std::vector<BoxedTet> inverted;
  for (int t = 0; t < air.slot_count(); ++t) {
    if (!air.alive(t) || quality[std::size_t(t)] > 0.0) continue;
    folds.inverted.push_back(t);
    inverted.push_back(boxed(air, x, t));
  }
  if (inverted.empty()) return folds;
  for (int t = 0; t < air.slot_count(); ++t) {
    if (!air.alive(t) || quality[std::size_t(t)] <= 0.0) continue;
    const BoxedTet tet = boxed(air, x, t);
    const std::size_t before = folds.pairs.size();
    for (const BoxedTet& other : inverted)
      if (overlap(tet, other)) folds.pairs.push_back({other.slot, t});
    if (folds.pairs.size() > before) folds.overlapping.push_back(t);
  }
  return folds;
}

std::vector<int> with_whole_folds(const TetTopology& air, const Folds& folds,
                                  std::vector<int> tets) {
  std::map<int, std::vector<int>> over;
  for (const int t : folds.inverted) over[t];
  for (const auto& [a, b] : folds.pairs) {
    over[a].push_back(b);
    over[b].push_back(a);
  }
  std::set<int> seen(tets.begin(), tets.end());
  const auto add = [&](int t) {
    if (seen.insert(t).second) tets.push_back(t);
  };
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const auto found = over.find(tets[i]);
    if (found == over.end()) continue;
    for (const int t : found->second) add(t);
    for (int c = 0; c < 4; ++c) {
      const int t = air.across(tets[i], c).tet;
      if (t >= 0 && over.count(t) > 0) add(t);
    }
  }
  return {seen.begin(), seen.end()};
}

}  // namespace angio::air_mesh
