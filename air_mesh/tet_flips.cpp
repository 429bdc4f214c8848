#include "air_mesh/tet_flips.hpp"

#include <algorithm>
#include <limits>

namespace angio::air_mesh {
namespace {

constexpr int kMostRing = 7;         // Shewchuk 2002: longer rings are seldom worth it
constexpr int kMostFaces = 10;       // removed at once
constexpr double kLeastGain = 1e-9;  // below it rounding decides
constexpr double kNone = std::numeric_limits<double>::infinity();

double quality(const std::vector<Vec3>& x, int a, int b, int c, int d) {
  return tet_quality(x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)], x[std::size_t(d)]);
}
double quality(const std::vector<Vec3>& x, const Tet& t) {
  return quality(x, t[0], t[1], t[2], t[3]);
}

int corner_of(const Tet& t, int vertex) {
  for (int c = 0; c < 4; ++c)
    if (t[std::size_t(c)] == vertex) return c;
  return -1;
}

// The tets around an edge (a, b) and their other vertices, counter-clockwise seen from b: tet i is
// (a, b, vertex[i], vertex[i + 1]).
struct Ring {
  int a = 0, b = 0, count = 0;
  std::array<int, kMostRing> vertex{}, tet{};
};

// count = 0 where the ring is open (the edge lies on the boundary) or too long.
Ring ring_around(const TetTopology& mesh, int t, int corner_a, int corner_b) {
  const Tet& v = mesh.tet(t);
  const Triangle& face = kTetFace[std::size_t(corner_a)];
  std::size_t k = 0;
  while (face[k] != corner_b) ++k;
  Ring ring{v[std::size_t(corner_a)], v[std::size_t(corner_b)], 0, {}, {}};
  // (face, a) is right-handed, so that (a, b, the next one, the last one) is left-handed.
  const int first = v[std::size_t(face[(k + 2) % 3])];
  int last = v[std::size_t(face[(k + 1) % 3])];
  ring.vertex[0] = first;
  ring.tet[0] = t;
  int count = 1, leaving = first, at = t;
  while (true) {
    const TetFace next = mesh.across(at, corner_of(mesh.tet(at), leaving));
    if (next.tet < 0) return ring;
    if (next.tet == t) break;
    if (count == kMostRing) return ring;
    ring.tet[std::size_t(count)] = next.tet;
    ring.vertex[std::size_t(count)] = last;
    ++count;
    leaving = last;
    last = mesh.tet(next.tet)[std::size_t(next.corner)];
    at = next.tet;
  }
  ring.count = last == first ? count : 0;
  return ring;
}

// Fills the ring's polygon with the best triangles (Klincsek's dynamic programme).
class RingFilling {
 public:
  RingFilling(const std::vector<Vec3>& x, const Ring& ring, double at_least)
      : x_(x), ring_(ring), least_(at_least) {
    for (int span = 2; span < ring.count; ++span)
      for (int i = 0; i + span < ring.count; ++i) choose(i, i + span);
  }
  [[nodiscard]] double value() const { return best_[0][std::size_t(ring_.count - 1)]; }
  void write(TetFlip& flip) const { write(flip, 0, ring_.count - 1); }

 private:
  // Of the polygon's part from i to j.
  void choose(int i, int j) {
    double& best = best_[std::size_t(i)][std::size_t(j)];
    best = -kNone;
    for (int k = i + 1; k < j; ++k) {
      double value = std::min(part(i, k), part(k, j));
      if (value <= std::max(best, least_)) continue;
      const int p = vertex(i), q = vertex(k), r = vertex(j);
      value = std::min(value, quality(x_, p, q, r, ring_.b));
      if (value <= best) continue;
      value = std::min(value, quality(x_, q, p, r, ring_.a));
      if (value <= best) continue;
      best = value;
      middle_[std::size_t(i)][std::size_t(j)] = k;
    }
  }
  void write(TetFlip& flip, int i, int j) const {
    if (j - i < 2) return;
    const int k = middle_[std::size_t(i)][std::size_t(j)];
    flip.fresh[std::size_t(flip.fresh_count++)] = {vertex(i), vertex(k), vertex(j), ring_.b};
    flip.fresh[std::size_t(flip.fresh_count++)] = {vertex(k), vertex(i), vertex(j), ring_.a};
    write(flip, i, k);
    write(flip, k, j);
  }
  [[nodiscard]] double part(int i, int j) const {
    return j - i < 2 ? kNone : best_[std::size_t(i)][std::size_t(j)];
  }
  [[nodiscard]] int vertex(int i) const { return ring_.vertex[std::size_t(i)]; }

  const std::vector<Vec3>& x_;
  const Ring& ring_;
  double least_;
  std::array<std::array<double, kMostRing>, kMostRing> best_{};
  std::array<std::array<int, kMostRing>, kMostRing> middle_{};
};

bool gains(const TetFlip& flip) { return flip.after > flip.before + kLeastGain; }

// The faces between two vertices a (on the face's right-handed side) and b that are removed.
struct Sandwich {
  const TetTopology& mesh;
  const std::vector<Vec3>& x;
  int a, b;
  TetFlip flip;
  double before;

  // What the edge (u, v) of a removed face of the tet `above` gives, w being the face's third
  // corner: a tet with a and b, or what lies beyond the edge when that is better.
  double beyond(int above, int u, int v, int w) {
    const double simple = quality(x, b, a, u, v);
    const int old_count = flip.old_count, fresh_count = flip.fresh_count;
    const double kept_before = before;
    const double extended = extend(above, u, v, w);
    if (extended > simple) return extended;
    flip.old_count = old_count;
    flip.fresh_count = fresh_count;
    before = kept_before;
    flip.fresh[std::size_t(flip.fresh_count++)] = {b, a, u, v};
    return simple;
  }

  // Takes the face beyond the edge (u, v) too, if it lies between a and b.
  double extend(int above, int u, int v, int w) {
    const TetFace upper = mesh.across(above, corner_of(mesh.tet(above), w));
    if (upper.tet < 0) return -kNone;
    const int next = mesh.tet(upper.tet)[std::size_t(upper.corner)];
    if (next == b) return -kNone;
    const TetFace lower = mesh.across(upper.tet, corner_of(mesh.tet(upper.tet), a));
    if (lower.tet < 0 || mesh.tet(lower.tet)[std::size_t(lower.corner)] != b) return -kNone;
    for (int i = 0; i < flip.old_count; ++i)
      if (flip.old[std::size_t(i)] == upper.tet || flip.old[std::size_t(i)] == lower.tet)
        return -kNone;
    if (flip.old_count + 2 > 2 * kMostFaces) return -kNone;
    flip.old[std::size_t(flip.old_count++)] = upper.tet;
    flip.old[std::size_t(flip.old_count++)] = lower.tet;
    before = std::min({before, quality(x, mesh.tet(upper.tet)), quality(x, mesh.tet(lower.tet))});
    const double first = beyond(upper.tet, u, next, v);
    return std::min(first, beyond(upper.tet, next, v, u));
  }
};

}  // namespace

TetFlip remove_edge(const TetTopology& mesh, const std::vector<Vec3>& x, int t, int corner_a,
                    int corner_b) {
  TetFlip flip;
  const Ring ring = ring_around(mesh, t, corner_a, corner_b);
  if (ring.count < 3) return flip;
  flip.before = kNone;
  for (int i = 0; i < ring.count; ++i)
    flip.before = std::min(flip.before, quality(x, mesh.tet(ring.tet[std::size_t(i)])));
  const RingFilling filling(x, ring, flip.before + kLeastGain);
  flip.after = filling.value();
  if (!gains(flip)) return flip;
  flip.old_count = ring.count;
  std::copy_n(ring.tet.begin(), ring.count, flip.old.begin());
  filling.write(flip);
  return flip;
}

TetFlip remove_faces(const TetTopology& mesh, const std::vector<Vec3>& x, int t, int corner) {
  const TetFace below = mesh.across(t, corner);
  if (below.tet < 0) return {};
  const int a = mesh.tet(t)[std::size_t(corner)];
  const int b = mesh.tet(below.tet)[std::size_t(below.corner)];
  if (a == b) return {};
  Sandwich sandwich{mesh, x, a, b, {}, 0.0};
  TetFlip& flip = sandwich.flip;
  flip.old[0] = t;
  flip.old[1] = below.tet;
  flip.old_count = 2;
  sandwich.before = std::min(quality(x, mesh.tet(t)), quality(x, mesh.tet(below.tet)));
  const Triangle f = mesh.face(t, corner);
  double after = kNone;
  for (std::size_t k = 0; k < 3 && after > sandwich.before; ++k)
    after = std::min(after, sandwich.beyond(t, f[k], f[(k + 1) % 3], f[(k + 2) % 3]));
  flip.before = sandwich.before;
  flip.after = after;
  return gains(flip) ? flip : TetFlip{};
}

TetFlip best_flip(const TetTopology& mesh, const std::vector<Vec3>& x, int t) {
  TetFlip best;
  best.after = -kNone;
  const auto consider = [&](const TetFlip& flip) {
    if (flip.old_count > 0 && flip.after > best.after) best = flip;
  };
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) consider(remove_edge(mesh, x, t, a, b));
  for (int c = 0; c < 4; ++c) consider(remove_faces(mesh, x, t, c));
  return best;
}

}  // namespace angio::air_mesh
