#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

namespace angio::air_mesh {

/// Quality of a tetrahedron: 1 regular, 0 flat, negative inverted.
///
///     q = 12 / sqrt(2) V / l_rms^3,    l_rms^2 = sum l_i^2 / 6
///
/// Source: the seed paper's Eqs. 21-22.
inline double tet_quality(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, ac = c - a, ad = d - a;
  const double squares = norm_squared(ab) + norm_squared(ac) + norm_squared(ad) +
                         norm_squared(c - b) + norm_squared(d - b) + norm_squared(d - c);
  const double mean = squares / 6.0;
  const double six_volumes = dot(cross(ab, ac), ad);
  return mean > 0.0 ? std::sqrt(2.0) * six_volumes / (mean * std::sqrt(mean)) : 0.0;
}

/// The corners of the face opposite each corner; with that corner they make a right-handed tet.
inline constexpr std::array<Triangle, 4> kTetFace{{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

/// A face of a tet: tet and the corner opposite.
struct TetFace {
  int tet = -1;  ///< -1: nothing, beyond the boundary
  int corner = 0;
};

/// Which tetrahedra share a face. Tets live in slots; those of removed ones are used again.
///
/// Faces of one tet only are the boundary: surfaces and caps. Nothing here changes them: what is
/// replaced must keep its outer faces.
class TetTopology {
 public:
  TetTopology() = default;
  /// @throws InputError if a face belongs to more than two tets
  explicit TetTopology(const std::vector<Tet>& tets);

  [[nodiscard]] int slot_count() const { return int(tets_.size()); }
  [[nodiscard]] int tet_count() const { return slot_count() - int(free_.size()); }
  [[nodiscard]] bool alive(int t) const { return tets_[std::size_t(t)][0] >= 0; }
  [[nodiscard]] const Tet& tet(int t) const { return tets_[std::size_t(t)]; }
  /// The same face, seen from the tet on its other side.
  [[nodiscard]] TetFace across(int t, int corner) const {
    const int link = links_[std::size_t(t)][std::size_t(corner)];
    return link < 0 ? TetFace{} : TetFace{link / 4, link % 4};
  }
  [[nodiscard]] TetFace across(const TetFace& face) const { return across(face.tet, face.corner); }
  /// Corners of a tet's face, turning so that (face, opposite corner) is right-handed.
  [[nodiscard]] Triangle face(int t, int corner) const {
    const Tet& v = tet(t);
    const Triangle& f = kTetFace[std::size_t(corner)];
    return {v[std::size_t(f[0])], v[std::size_t(f[1])], v[std::size_t(f[2])]};
  }
  [[nodiscard]] std::vector<Tet> tets() const;
  [[nodiscard]] std::vector<TetFace> boundary() const;

  /// Puts `fresh` in the place of `old`.
  ///
  /// @param slots  of the fresh ones, shape [fresh_count]
  /// @return false, with nothing changed, if the fresh ones do not have the same outer faces
  bool replace(const int* old, int old_count, const Tet* fresh, int fresh_count, int* slots);

  /// Takes tets out: the boundary goes around them.
  void remove(const std::vector<int>& tets);

 private:
  struct FaceEntry {
    Triangle key;  ///< ascending
    int link;      ///< of the outside, or -1; of a fresh tet: -2 - (4 index + corner)
  };
  bool pair_up(std::vector<FaceEntry>& entries) const;
  int take_slot();

  std::vector<Tet> tets_;
  std::vector<std::array<int, 4>> links_;  ///< 4 tet + corner of the other side, or -1
  std::vector<int> free_;
  std::vector<int> mark_;
  int stamp_ = 0;
  std::vector<FaceEntry> entries_;
};

}  // namespace angio::air_mesh
