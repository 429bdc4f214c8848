#pragma once

#include "simulation/materials/wedge_tangent.hpp"

/// The wall's solid by columns: the copies of one lumen vertex through the wall are moved together,
/// by one Newton step in their own block of 3 x 3 blocks. Vertex by vertex the thin, nearly
/// incompressible layers hand a load on one sweep at a time.
///
/// The wedges' laws are evaluated only where they have been strained since the last time, their
/// slopes only where the law has changed (wedge_tangent.hpp). A column keeps its row of the sum of
/// all tangents, and its own block eliminated from the outside in, so that a sweep costs products
/// only; what varies from sweep to sweep, the contact, is on its first vertex.
namespace angio::simulation::detail {

inline constexpr int kMostColumnLevels = 8;
/// Strain since a wedge's force was taken above which it is taken again; a pressed point's change
/// of volume, as a share of it.
inline constexpr double kForceStrain = 2e-3, kForcePressed = 2e-2;
/// Strain since its slopes were taken above which they are taken again, and their law's change.
/// Slopes are renewed together, in the first sweep of a step and every kSlopePeriod ones: a column
/// adds up those of all its wedges. In between only what has changed much is renewed.
struct SlopeAge {
  double strain, stiffer;  ///< the second a share of the law's stiffness then
};
inline constexpr int kSlopePeriod = 8;
/// What slopes may be in a sweep of a step.
ANGIO_HOST_DEVICE constexpr SlopeAge oldest_slopes(int sweep) {
  return sweep % kSlopePeriod == 0 ? SlopeAge{1e-2, 0.1} : SlopeAge{4e-2, 0.4};
}
/// A move changes no point's volume to less than this share of it, nor to more than its inverse.
inline constexpr double kKeptInMove = 0.7;
/// A move adds no more than this to a point's exponent of stiffening: its fibres' stress grows to
/// no more than about seven times.
inline constexpr double kStiffenedInMove = 2.0;
/// A move that changes volumes by less, as their slopes have it, is not looked at.
inline constexpr double kSmallMove = 0.15;

/// A wedge at a column: it has the corners `corner` and corner + 3.
struct ColumnWedge {
  int wedge = 0, corner = 0;
  int link[2] = {0, 0};  ///< to the columns of the corners after it, corner + 1 and corner + 2
};

/// The columns of a solid whose vertices are numbered level by level, the lumen's first: the vertex
/// of column i at a level is level * stride + i.
struct SolidColumns {
  int levels = 0;  ///< vertices of a column; 0: there is no solid
  int stride = 0;
  const int* layer = nullptr;        ///< [wedge]
  const int* patch_begin = nullptr;  ///< [column + 1]
  const int* patches = nullptr;      ///< those with a wedge at the column
  const int* wedge_begin = nullptr;  ///< [column + 1]
  const ColumnWedge* wedges = nullptr;
  const int* link_begin = nullptr;  ///< [column + 1]
  const int* links = nullptr;       ///< the columns that share a wedge with it
};

/// What of a wedge's line has been taken anew; each with those before it.
enum class Renewed : char { nothing, force, slopes };

/// What the columns keep of the solid's tangents.
template <class Real>
struct ColumnRows {
  WedgePlace<Real>* places = nullptr;      ///< [wedge]
  WedgeTangent<Real>* tangents = nullptr;  ///< [wedge]
  WedgeForce<Real>* forces = nullptr;      ///< [wedge]
  Renewed* renewed = nullptr;              ///< [wedge] in this sweep
  Real* wedge_volume = nullptr;            ///< [wedge] by the tangent
  Real* patch_volume = nullptr;            ///< [patch] now; a column that moves adds its part
  Vec3T<Real>* constant = nullptr;         ///< [column][level]
  Mat3T<Real>* pivot = nullptr;  ///< [column][level], inverted but for the first, which has contact
  Mat3T<Real>* upper = nullptr;  ///< [column][level]: the Newton step's block (l, l + 1)
  Mat3T<Real>* above = nullptr;  ///< [column][level]: the gradient's block (l, l + 1)
  Slope* beside = nullptr;       ///< [link][level][3]: blocks to the link's levels l - 1, l, l + 1
  Vec3T<Real>* by_low = nullptr;  ///< [patch of a column] dv/dx of the patch at its lower level
  Vec3T<Real>* by_high = nullptr;
  Real* steepness = nullptr;  ///< [column] the largest of its wedges [1/mm]
};

/// Takes force and slopes of a wedge where it has been strained, and its volume.
/// @param most  age that slopes may have
template <class Real>
ANGIO_HOST_DEVICE inline void renew_wedge(const SolidView<Real>& view, const ColumnRows<Real>& rows,
                                          const SlopeAge& most, int w) {
  Vec3T<Real> x[6];
  view.gather(w, x);
  WedgePlace<Real>& t = rows.places[w];
  const SolidWedge<Real> wedge = view.wedge(w);
  rows.renewed[w] = Renewed::nothing;
  const bool was_pressed = t.is_pressed;
  if (!t.has_slopes || !t.has_force || has_moved(t.x, x, Real(kForceStrain)) ||
      (was_pressed && is_pressed_on(t, wedge.points, x, Real(kForcePressed)))) {
    const WedgeLaw<Real> law = evaluate_law(wedge, x);
    const bool is_old = !t.has_slopes || was_pressed || t.flowed > Real(most.strain) ||
                        has_moved(t.x_slopes, x, Real(most.strain)) ||
                        is_stiffer(t, law, Real(most.stiffer));
    if (is_old)
      take_slopes(wedge, law, patch_energy(view, view.patch[w]).d1, x, t, rows.tangents[w]);
    take_force(wedge, law, x, rows.tangents[w], t, rows.forces[w]);
    rows.renewed[w] = is_old ? Renewed::slopes : Renewed::force;
  }
  rows.wedge_volume[w] = tangent_volume(t, x);
}

template <class Real>
ANGIO_HOST_DEVICE inline void renew_patch(const SolidView<Real>& view, const ColumnRows<Real>& rows,
                                          int patch) {
  Real volume = 0;
  for (int m = view.patch_begin[patch]; m < view.patch_begin[patch + 1]; ++m)
    volume += rows.wedge_volume[view.patch_wedges[m]];
  rows.patch_volume[patch] = volume;
}

/// U' and U'' of a patch by its volume now.
template <class Real>
ANGIO_HOST_DEVICE inline VolumeEnergy<Real> patch_energy_now(const SolidView<Real>& view,
                                                             const ColumnRows<Real>& rows,
                                                             int patch) {
  const Real unloaded = view.patch_volume[patch];
  VolumeEnergy<Real> u = volume_energy(view.patch_bulk[patch], rows.patch_volume[patch] / unloaded);
  u.d2 /= unloaded;
  return u;
}

/// The inverse of a symmetric matrix whose eigenvalues below `least` are raised to it. Those of the
/// wall are above, as a rule: then no eigenvalues are needed.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> inverse_above(const Mat3T<Real>& a, Real least) {
  const Mat3T<Real> over = a + (-least) * Mat3T<Real>::identity();
  if (over(0, 0) > Real(0) && over(0, 0) * over(1, 1) > over(0, 1) * over(0, 1) &&
      determinant(over) > Real(0))
    return inverse(a);
  Eigen3<Real> e = eigen_decomposition(a);
  for (int k = 0; k < 3; ++k) e.value[k] = Real(1) / (e.value[k] > least ? e.value[k] : least);
  return recomposed(e);
}

/// The inverse of a column's pivot: its eigenvalues are kept above a small share of the trace.
template <class Real>
ANGIO_HOST_DEVICE inline Mat3T<Real> inverse_pivot(const Mat3T<Real>& pivot, Real trace) {
  constexpr Real kLeast = Real(1e-4);
  return inverse_above(Real(0.5) * (pivot + transpose(pivot)), kLeast * trace);
}

/// Which layers of a link's wedges have new slopes, a bit each.
template <class Real>
ANGIO_HOST_DEVICE inline unsigned renewed_layers(const SolidColumns& columns,
                                                 const ColumnRows<Real>& rows, int column,
                                                 int link) {
  unsigned layers = 0;
  for (int n = columns.wedge_begin[column]; n < columns.wedge_begin[column + 1]; ++n) {
    const ColumnWedge& at = columns.wedges[n];
    if (at.link[0] != link && at.link[1] != link) continue;
    if (rows.renewed[at.wedge] == Renewed::slopes) layers |= 1u << columns.layer[at.wedge];
  }
  return layers;
}

/// The blocks to the columns beside, a lane's part of them: where a wedge has new slopes, the sum
/// over its neighbours' is taken anew.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void gather_links(const SolidColumns& columns,
                                           const ColumnRows<Real>& rows, int column,
                                           const Lanes& lanes) {
  const int blocks = 3 * columns.levels;
  for (int link = columns.link_begin[column] + lanes.rank(); link < columns.link_begin[column + 1];
       link += lanes.size()) {
    const unsigned layers = renewed_layers(columns, rows, column, link);
    if (layers == 0) continue;
    const auto is_new = [&](int layer) { return layer >= 0 && (layers >> layer & 1u) != 0; };
    const auto is_new_at = [&](int level) { return is_new(level - 1) || is_new(level); };
    Slope* all = rows.beside + blocks * link;
    for (int l = 0; l < columns.levels; ++l) {
      if (is_new(l - 1)) all[3 * l] = {};
      if (is_new_at(l)) all[3 * l + 1] = {};
      if (is_new(l)) all[3 * l + 2] = {};
    }
    for (int n = columns.wedge_begin[column]; n < columns.wedge_begin[column + 1]; ++n) {
      const ColumnWedge& at = columns.wedges[n];
      if (at.link[0] != link && at.link[1] != link) continue;
      const int layer = columns.layer[at.wedge];
      if (!is_new_at(layer) && !is_new_at(layer + 1)) continue;
      const WedgeTangent<Real>& t = rows.tangents[at.wedge];
      Slope* beside = all + 3 * layer;
      const int a = at.corner, b = (a + (at.link[0] == link ? 1 : 2)) % 3;
      if (is_new_at(layer)) beside[1] += tangent_block(t, a, b);
      if (is_new_at(layer + 1)) beside[4] += tangent_block(t, a + 3, b + 3);
      if (!is_new(layer)) continue;
      beside[2] += tangent_block(t, a, b + 3);
      beside[3] += tangent_block(t, a + 3, b);
    }
  }
}

/// dv/dx of the patches around a column.
template <class Real>
ANGIO_HOST_DEVICE inline void gather_patch(const SolidView<Real>& view, const SolidColumns& columns,
                                           const ColumnRows<Real>& rows, int column, int e) {
  Vec3T<Real> low, high;
  const int patch = columns.patches[e];
  for (int m = view.patch_begin[patch]; m < view.patch_begin[patch + 1]; ++m) {
    const int w = view.patch_wedges[m];
    const int vertex = columns.layer[w] * columns.stride + column;
    int a = 0;
    while (a < 3 && view.corners[6 * w + a] != vertex) ++a;
    if (a == 3) continue;
    low += rows.places[w].by_volume[a];
    high += rows.places[w].by_volume[a + 3];
  }
  rows.by_low[e] = low;
  rows.by_high[e] = high;
}

/// The levels' constants. Positions enter as differences to the vertex itself (a wedge that moves
/// as a whole has no force), which keeps the digits.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void gather_constants(const SolidColumns& columns,
                                               const ColumnRows<Real>& rows, int column,
                                               const Lanes& lanes) {
  Vec3T<Real> constant[kMostColumnLevels];
  for (int n = columns.wedge_begin[column] + lanes.rank(); n < columns.wedge_begin[column + 1];
       n += lanes.size()) {
    const ColumnWedge& at = columns.wedges[n];
    const int layer = columns.layer[at.wedge];
    constant[layer] += rows.forces[at.wedge].constant[at.corner];
    constant[layer + 1] += rows.forces[at.wedge].constant[at.corner + 3];
  }
  for (int l = 0; l < columns.levels; ++l) {
    const Vec3T<Real> sum{lanes.sum(constant[l].x), lanes.sum(constant[l].y),
                          lanes.sum(constant[l].z)};
    if (lanes.rank() == 0) rows.constant[column * columns.levels + l] = sum;
  }
}

/// A level's own slopes: its pivot before the elimination, and its blocks to the level above.
template <class Real>
ANGIO_HOST_DEVICE inline void gather_level(const SolidView<Real>& view, const SolidColumns& columns,
                                           const ColumnRows<Real>& rows, int column, int l) {
  Mat3T<Real> own, above, volume;
  for (int n = columns.wedge_begin[column]; n < columns.wedge_begin[column + 1]; ++n) {
    const ColumnWedge& at = columns.wedges[n];
    const int layer = columns.layer[at.wedge];
    if (layer != l && layer + 1 != l) continue;
    const WedgeTangent<Real>& t = rows.tangents[at.wedge];
    const int a = layer == l ? at.corner : at.corner + 3;
    own += in_precision<Real>(t.block[wedge_block(a, a)]);
    if (layer != l) continue;
    above += in_precision<Real>(t.block[wedge_block(a, a + 3)]);
    volume += cross_matrix(t.turn[a]);
  }
  // The pressure's turn of the forces makes no pivot better: the step goes without it.
  Mat3T<Real> upper = above + Real(-1) * volume;
  for (int e = columns.patch_begin[column]; e < columns.patch_begin[column + 1]; ++e) {
    const int patch = columns.patches[e];
    const int layer = columns.layer[view.patch_wedges[view.patch_begin[patch]]];
    if (layer != l && layer + 1 != l) continue;
    const Real k = patch_energy_now(view, rows, patch).d2;
    const Vec3T<Real> by = layer == l ? rows.by_low[e] : rows.by_high[e];
    own += k * outer(by, by);
    if (layer == l) upper += k * outer(by, rows.by_high[e]);
  }
  const int row = column * columns.levels + l;
  rows.pivot[row] = own;
  rows.above[row] = above;
  rows.upper[row] = upper;
}

/// Eliminates a column's block from the outside in. @param added  to each level's pivot
template <class Real, class Added>
ANGIO_HOST_DEVICE inline void eliminate(const SolidColumns& columns, const ColumnRows<Real>& rows,
                                        int column, const Added& added) {
  const int row = column * columns.levels;
  for (int l = columns.levels - 1; l >= 0; --l) {
    Mat3T<Real> pivot = rows.pivot[row + l] + added(l) * Mat3T<Real>::identity();
    const Real trace = pivot(0, 0) + pivot(1, 1) + pivot(2, 2);
    if (l + 1 < columns.levels) {
      const Mat3T<Real>& up = rows.upper[row + l];
      pivot += Real(-1) * (up * rows.pivot[row + l + 1] * transpose(up));
    }
    rows.pivot[row + l] = l > 0 ? inverse_pivot(pivot, trace) : pivot;
  }
}

/// The solid's gradient at a column's levels, the lanes' parts of it (team.hpp).
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void add_column_gradient(const SolidView<Real>& view,
                                                  const SolidColumns& columns,
                                                  const ColumnRows<Real>& rows, int column,
                                                  const Lanes& lanes, Vec3T<Real>* gradient) {
  const int levels = columns.levels, row = column * levels;
  const auto at = [&](int i, int l) { return view.x[l * columns.stride + i]; };
  Vec3T<Real> x[kMostColumnLevels];
  for (int l = 0; l < levels; ++l) x[l] = at(column, l);
  for (int e = columns.link_begin[column] + lanes.rank(); e < columns.link_begin[column + 1];
       e += lanes.size()) {
    const int other = columns.links[e];
    const Slope* beside = rows.beside + 3 * levels * e;
    for (int m = 0; m < levels; ++m) {
      const Vec3T<Real> y = at(other, m);
      for (int l = m > 0 ? m - 1 : 0; l < levels && l <= m + 1; ++l)
        gradient[l] += in_precision<Real>(beside[3 * l + 1 + m - l]) * (y - x[l]);
    }
  }
  for (int e = columns.patch_begin[column] + lanes.rank(); e < columns.patch_begin[column + 1];
       e += lanes.size()) {
    const int patch = columns.patches[e];
    const int l = columns.layer[view.patch_wedges[view.patch_begin[patch]]];
    const Real pressure = patch_energy_now(view, rows, patch).d1;
    gradient[l] += pressure * rows.by_low[e];
    gradient[l + 1] += pressure * rows.by_high[e];
  }
  if (lanes.rank() > 0) return;
  for (int l = 0; l < levels; ++l) {
    gradient[l] += rows.constant[row + l];
    if (l + 1 == levels) break;
    gradient[l] += rows.above[row + l] * (x[l + 1] - x[l]);
    gradient[l + 1] += transpose(rows.above[row + l]) * (x[l] - x[l + 1]);
  }
}

/// The Newton step of a column, -(H + C)^-1 g, C the contact's Hessian on its first vertex.
template <class Real>
ANGIO_HOST_DEVICE inline void solve_column(const SolidColumns& columns,
                                           const ColumnRows<Real>& rows, int column,
                                           const Mat3T<Real>& contact, Vec3T<Real>* gradient,
                                           Vec3T<Real>* move) {
  const int levels = columns.levels, row = column * levels;
  for (int l = levels - 1; l > 0; --l)
    gradient[l - 1] -= rows.upper[row + l - 1] * (rows.pivot[row + l] * gradient[l]);
  const Mat3T<Real> first = rows.pivot[row] + contact;
  move[0] =
      Real(-1) * (inverse_pivot(first, first(0, 0) + first(1, 1) + first(2, 2)) * gradient[0]);
  for (int l = 1; l < levels; ++l)
    move[l] = Real(-1) * (rows.pivot[row + l] *
                          (gradient[l] + transpose(rows.upper[row + l - 1]) * move[l - 1]));
}

template <class Real>
ANGIO_HOST_DEVICE inline Real column_steepness(const SolidColumns& columns,
                                               const ColumnRows<Real>& rows, int column) {
  Real most = 0;
  for (int n = columns.wedge_begin[column]; n < columns.wedge_begin[column + 1]; ++n) {
    const ColumnWedge& at = columns.wedges[n];
    const Real steep = rows.places[at.wedge].steepness[at.corner];
    most = steep > most ? steep : most;
  }
  return most;
}

/// Does no point of a wedge lose or gain more of its volume than a move may change, nor stiffen by
/// more?
template <class Real>
ANGIO_HOST_DEVICE inline bool bears_move(const SolidWedge<Real>& wedge, const Vec3T<Real>* before,
                                         const Vec3T<Real>* after) {
  for (int q = 0; q < kWedgePoints; ++q) {
    const Mat3T<Real> was = solid::deformation(wedge.points[q], before),
                      is = solid::deformation(wedge.points[q], after);
    const Real had = determinant(was), has = determinant(is);
    const Real low = had < Real(1) ? had : Real(1), high = had > Real(1) ? had : Real(1);
    if (!(has >= Real(kKeptInMove) * low && Real(kKeptInMove) * has <= high)) return false;
    if (!(greatest_exponent(wedge.law, wedge.fiber, is) <=
          greatest_exponent(wedge.law, wedge.fiber, was) + Real(kStiffenedInMove)))
      return false;
  }
  return true;
}

/// The share of a column's move that its wedges bear: halved until all do, from a strain of 1 on.
/// No wedge may turn inside out within a move: where its law ends no force brings it back; nor may
/// it stiffen so far that what is wanted next is beyond any move.
template <class Real>
ANGIO_HOST_DEVICE inline Real borne_share(const SolidView<Real>& view, const SolidColumns& columns,
                                          const ColumnRows<Real>& rows, int column,
                                          const Vec3T<Real>* move, Real share) {
  constexpr int kMostHalvings = 12;
  Real longest = 0;
  for (int l = 0; l < columns.levels; ++l)
    longest = norm(move[l]) > longest ? norm(move[l]) : longest;
  const Real strain = share * longest * rows.steepness[column];
  if (strain < Real(kSmallMove)) return share;
  if (strain > Real(1)) share /= strain;
  for (int n = columns.wedge_begin[column]; n < columns.wedge_begin[column + 1]; ++n) {
    const ColumnWedge& at = columns.wedges[n];
    const SolidWedge<Real> wedge = view.wedge(at.wedge);
    const int l = columns.layer[at.wedge];
    Vec3T<Real> before[6], after[6];
    view.gather(at.wedge, before);
    for (int halving = 0; halving <= kMostHalvings; ++halving) {
      if (halving == kMostHalvings) return Real(0);
      for (int a = 0; a < 6; ++a) after[a] = before[a];
      after[at.corner] += share * move[l];
      after[at.corner + 3] += share * move[l + 1];
      if (bears_move(wedge, before, after)) break;
      share *= Real(0.5);
    }
  }
  return share;
}

/// Tells the patches around a column that it moves.
template <class Real, class Lanes>
ANGIO_HOST_DEVICE inline void move_patches(const SolidView<Real>& view, const SolidColumns& columns,
                                           const ColumnRows<Real>& rows, int column, Real share,
                                           const Vec3T<Real>* move, const Lanes& lanes) {
  for (int e = columns.patch_begin[column] + lanes.rank(); e < columns.patch_begin[column + 1];
       e += lanes.size()) {
    const int patch = columns.patches[e];
    const int l = columns.layer[view.patch_wedges[view.patch_begin[patch]]];
    rows.patch_volume[patch] +=
        share * (dot(rows.by_low[e], move[l]) + dot(rows.by_high[e], move[l + 1]));
  }
}

}  // namespace angio::simulation::detail
