#include "air_mesh/tet_refill.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace angio::air_mesh {
namespace {

constexpr int kMostVertices = 40;
constexpr double kLeastQuality = 1e-9;  // less is flat: rounding

constexpr int choose2(int n) { return n * (n - 1) / 2; }
constexpr int choose3(int n) { return n * (n - 1) * (n - 2) / 6; }
constexpr int choose4(int n) { return n * (n - 1) * (n - 2) / 6 * (n - 3) / 4; }

double side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a);
}

// Is the segment (p, q) cut by the triangle's inside?
bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double at_p = side(a, b, c, p), at_q = side(a, b, c, q);
  if ((at_p > 0.0) == (at_q > 0.0) || at_p == 0.0 || at_q == 0.0) return false;
  const double s = side(p, q, a, b), t = side(p, q, b, c), u = side(p, q, c, a);
  return (s > 0.0 && t > 0.0 && u > 0.0) || (s < 0.0 && t < 0.0 && u < 0.0);
}

bool contains(const Triangle& f, int v) { return f[0] == v || f[1] == v || f[2] == v; }

int edge_index(int p, int q) { return choose2(std::max(p, q)) + std::min(p, q); }
int face_index(Triangle f) {
  std::sort(f.begin(), f.end());
  return choose3(f[2]) + choose2(f[1]) + f[0];
}
// +1 or -1: which way the face turns, against its ascending order.
std::int8_t turn(const Triangle& f) {
  return (f[0] < f[1]) + (f[1] < f[2]) + (f[2] < f[0]) == 2 ? 1 : -1;
}

// Which tets over the hollow's vertices may be part of a filling at all.
class PossibleTets {
 public:
  PossibleTets(std::vector<Vec3> x, std::vector<Triangle> outside)
      : x_(std::move(x)), outside_(std::move(outside)) {
    const int n = count();
    tets_.assign(std::size_t(choose4(n)), kUnknown);
    edges_.assign(std::size_t(choose2(n)), -1);
    faces_.assign(std::size_t(choose3(n)), -1);
    for (const Triangle& f : outside_) {
      faces_[std::size_t(face_index(f))] = 1;
      for (std::size_t k = 0; k < 3; ++k) edges_[std::size_t(edge_index(f[k], f[(k + 1) % 3]))] = 1;
    }
  }

  [[nodiscard]] int count() const { return int(x_.size()); }
  [[nodiscard]] const std::vector<Triangle>& outside() const { return outside_; }

  // Quality of the tet with these corners in this order; 0 where it cannot be part of the filling.
  double quality(Tet t) {
    bool even = true;
    for (std::size_t i = 1; i < 4; ++i)
      for (std::size_t j = i; j > 0 && t[j - 1] > t[j]; --j) {
        std::swap(t[j - 1], t[j]);
        even = !even;
      }
    float& stored = tets_[std::size_t(choose4(t[3]) + choose3(t[2]) + choose2(t[1]) + t[0])];
    if (stored == kUnknown) stored = float(evaluate(t));
    return even ? double(stored) : -double(stored);
  }

 private:
  static constexpr float kUnknown = -2.0F;

  double evaluate(const Tet& t) {
    const Vec3 &a = at(t[0]), &b = at(t[1]), &c = at(t[2]), &d = at(t[3]);
    const double q = tet_quality(a, b, c, d);
    if (std::abs(q) < kLeastQuality) return 0.0;
    const double sign = q > 0.0 ? 1.0 : -1.0;
    for (int v = 0; v < count(); ++v) {
      if (v == t[0] || v == t[1] || v == t[2] || v == t[3]) continue;
      const Vec3& p = at(v);
      if (sign * side(p, b, c, d) > 0.0 && sign * side(a, p, c, d) > 0.0 &&
          sign * side(a, b, p, d) > 0.0 && sign * side(a, b, c, p) > 0.0)
        return 0.0;
    }
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (!edge_is_free(t[i], t[j])) return 0.0;
    for (const Triangle& f : kTetFace)
      if (!face_is_free({t[std::size_t(f[0])], t[std::size_t(f[1])], t[std::size_t(f[2])]}))
        return 0.0;
    return q;
  }

  bool edge_is_free(int p, int q) {
    std::int8_t& stored = edges_[std::size_t(edge_index(p, q))];
    if (stored >= 0) return stored != 0;
    stored = 1;
    for (const Triangle& f : outside_)
      if (!contains(f, p) && !contains(f, q) &&
          crosses(at(p), at(q), at(f[0]), at(f[1]), at(f[2]))) {
        stored = 0;
        break;
      }
    return stored != 0;
  }

  bool face_is_free(const Triangle& face) {
    std::int8_t& stored = faces_[std::size_t(face_index(face))];
    if (stored >= 0) return stored != 0;
    stored = 1;
    for (const Triangle& f : outside_)
      for (std::size_t k = 0; k < 3 && stored != 0; ++k) {
        const int p = f[k], q = f[(k + 1) % 3];
        if (p > q || contains(face, p) || contains(face, q)) continue;
        if (crosses(at(p), at(q), at(face[0]), at(face[1]), at(face[2]))) stored = 0;
      }
    return stored != 0;
  }

  [[nodiscard]] const Vec3& at(int v) const { return x_[std::size_t(v)]; }

  std::vector<Vec3> x_;
  std::vector<Triangle> outside_;
  std::vector<float> tets_;
  std::vector<std::int8_t> edges_, faces_;  // 1 free, 0 not, -1 not known
};

// The search. A face is directed: (face, apex of the tet that is to fill it) is right-handed.
class Filling {
 public:
  Filling(PossibleTets& possible, int most_steps)
      : possible_(possible),
        steps_(most_steps),
        state_(std::size_t(choose3(possible.count())), kAbsent) {}

  bool run() {
    for (const Triangle& f : possible_.outside())
      if (!open(f)) return false;
    return fill();
  }
  [[nodiscard]] const std::vector<Tet>& tets() const { return tets_; }

 private:
  static constexpr std::int8_t kAbsent = 0, kClosed = 2;  // else the turn of an open face

  [[nodiscard]] bool is_open(const Triangle& f) const {
    return state_[std::size_t(face_index(f))] == turn(f);
  }
  [[nodiscard]] bool can_open(const Triangle& f) const {
    const std::int8_t state = state_[std::size_t(face_index(f))];
    return state == kAbsent || state == -turn(f);
  }
  // A face that meets its other side is closed.
  bool open(const Triangle& f) {
    if (!can_open(f)) return false;
    std::int8_t& state = state_[std::size_t(face_index(f))];
    if (state == kAbsent) {
      state = turn(f);
      faces_.push_back(f);
    } else {
      state = kClosed;
    }
    return true;
  }

  [[nodiscard]] bool fits(const Triangle& f, int apex) {
    if (contains(f, apex) || possible_.quality({f[0], f[1], f[2], apex}) < kLeastQuality)
      return false;
    for (std::size_t k = 0; k < 3; ++k)
      if (!can_open({f[k], f[(k + 1) % 3], apex})) return false;
    return true;
  }

  // The open face with the fewest tets that fit; false if none is open.
  bool hardest_face(Triangle& hardest) {
    int fewest = possible_.count() + 1;
    for (const Triangle& f : faces_) {
      if (!is_open(f)) continue;
      int count = 0;
      for (int v = 0; v < possible_.count() && count < fewest; ++v) count += fits(f, v) ? 1 : 0;
      if (count >= fewest) continue;
      fewest = count;
      hardest = f;
      if (fewest == 0) break;
    }
    return fewest <= possible_.count();
  }

  bool fill() {
    Triangle f{};
    if (!hardest_face(f)) return true;
    std::vector<int> apexes;
    for (int v = 0; v < possible_.count(); ++v)
      if (fits(f, v)) apexes.push_back(v);
    std::stable_sort(apexes.begin(), apexes.end(), [&](int a, int b) {
      return possible_.quality({f[0], f[1], f[2], a}) > possible_.quality({f[0], f[1], f[2], b});
    });
    const std::vector<std::int8_t> state = state_;
    const std::size_t face_count = faces_.size(), tet_count = tets_.size();
    for (const int apex : apexes) {
      if (--steps_ < 0) return false;
      tets_.push_back({f[0], f[1], f[2], apex});
      state_[std::size_t(face_index(f))] = kClosed;
      bool placed = true;
      for (std::size_t k = 0; k < 3; ++k) placed = placed && open({f[k], f[(k + 1) % 3], apex});
      if (placed && fill()) return true;
      state_ = state;
      faces_.resize(face_count);
      tets_.resize(tet_count);
    }
    return false;
  }

  PossibleTets& possible_;
  int steps_;
  std::vector<std::int8_t> state_;
  std::vector<Triangle> faces_;
  std::vector<Tet> tets_;
};

}  // namespace

std::vector<Tet> refill(const TetTopology& mesh, const std::vector<Vec3>& x,
                        const std::vector<int>& old, int most_steps, int without) {
  std::vector<int> vertices;
  for (const int t : old) vertices.insert(vertices.end(), mesh.tet(t).begin(), mesh.tet(t).end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::erase(vertices, without);
  if (int(vertices.size()) > kMostVertices) return {};
  const auto local = [&](int v) {
    return int(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
  };
  std::vector<int> ordered = old;
  std::sort(ordered.begin(), ordered.end());
  std::vector<Triangle> outside;
  for (const int t : ordered)
    for (int c = 0; c < 4; ++c) {
      const TetFace other = mesh.across(t, c);
      if (other.tet >= 0 && std::binary_search(ordered.begin(), ordered.end(), other.tet)) continue;
      const Triangle f = mesh.face(t, c);
      if (contains(f, without)) return {};  // beside a gap: the hollow would be open there
      outside.push_back({local(f[0]), local(f[1]), local(f[2])});
    }
  std::vector<Vec3> points;
  for (const int v : vertices) points.push_back(x[std::size_t(v)]);
  PossibleTets possible(std::move(points), std::move(outside));
  Filling filling(possible, most_steps);
  if (!filling.run()) return {};
  std::vector<Tet> tets = filling.tets();
  for (Tet& t : tets)
    for (int& v : t) v = vertices[std::size_t(v)];
  return tets;
}

Refilling refill_around(const TetTopology& mesh, const std::vector<Vec3>& x, int t) {
  constexpr int kMostOld = 30, kMostSteps = 300;
  Refilling result{{t}, {}};
  std::vector<int>& old = result.old;
  while (result.fresh.empty()) {
    const std::size_t layer = old.size();
    for (std::size_t i = 0; i < layer; ++i)
      for (int c = 0; c < 4; ++c) {
        const int next = mesh.across(old[i], c).tet;
        if (next >= 0 && std::find(old.begin(), old.end(), next) == old.end()) old.push_back(next);
      }
    if (old.size() == layer || old.size() > std::size_t(kMostOld)) break;
    result.fresh = refill(mesh, x, old, kMostSteps);
  }
  return result;
}

}  // namespace angio::air_mesh
