#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "core/vec3.hpp"

/// The guidewire in the balloon's shaft as a discrete elastic rod without twist: stretching of its
/// segments and bending at its nodes.
///
/// Source: Bergou, Wardetzky, Robinson, Audoly, Grinspun, "Discrete Elastic Rods", ACM TOG 27
/// (2008), section 4.2: the curvature binormal and the energy of an isotropic rod. Here with
/// present, not rest, lengths of its edges in the curvature (so that a stretched rod does not
/// bend), an elastic axis in place of the inextensible one, and no material frame.
namespace angio::simulation::detail {

/// Energy of one segment, and its derivatives by its second node; those by the first are the
/// opposite, and the mixed block is -hessian.
template <class Real>
struct SegmentTerm {
  Real energy{};         ///< [nJ]
  Vec3T<Real> gradient;  ///< [uN]
  Mat3T<Real> hessian;   ///< [uN/mm], not indefinite: what compression adds is left out
};

/// E = EA (l / l0 - 1)^2 l0 / 2.
///
/// @param edge       from the segment's first node to its second [mm]; a zero one has no direction
///                   and gives no force
/// @param rest       l0 [mm], > 0
/// @param stiffness  EA [uN], >= 0
template <class Real>
ANGIO_HOST_DEVICE inline SegmentTerm<Real> stretch_term(const Vec3T<Real>& edge, Real rest,
                                                        Real stiffness) {
  SegmentTerm<Real> term;
  const Real length = norm(edge), strain = length / rest - Real(1);
  term.energy = Real(0.5) * stiffness * rest * strain * strain;
  if (!(length > Real(0))) return term;
  const Vec3T<Real> t = edge / length;
  term.gradient = (stiffness * strain) * t;
  const Real across = strain > Real(0) ? stiffness * strain / length : Real(0);
  term.hessian = (stiffness / rest - across) * outer(t, t) + across * Mat3T<Real>::identity();
  return term;
}

/// The curvature binormal at a node between two edges, and its derivatives by them.
template <class Real>
struct Curvature {
  Vec3T<Real> binormal;      ///< kb
  Mat3T<Real> by_edge[2]{};  ///< [1/mm]
};

/// kb = 2 t0 x t1 / (1 + t0 . t1), of length 2 tan(turn / 2).
///
/// With c = 1 + t0 . t1 and P = I - t t^T:
///     dkb/de0 = -(2 [t1]x + kb t1^T) P0 / (c |e0|),   dkb/de1 = (2 [t0]x - kb t0^T) P1 / (c |e1|)
///
/// Source: Bergou et al. 2008, Eq. 1 with unit tangents. c is kept above 1e-3: a rod that is folded
/// back on itself keeps a finite, steep curvature. Edges of no length give none.
template <class Real>
ANGIO_HOST_DEVICE inline Curvature<Real> curvature(const Vec3T<Real>& e0, const Vec3T<Real>& e1) {
  Curvature<Real> out;
  const Real l0 = norm(e0), l1 = norm(e1);
  if (!(l0 > Real(0)) || !(l1 > Real(0))) return out;
  const Vec3T<Real> t0 = e0 / l0, t1 = e1 / l1;
  const Real opening = Real(1) + dot(t0, t1);
  const Real c = opening > Real(1e-3) ? opening : Real(1e-3);
  out.binormal = (Real(2) / c) * cross(t0, t1);
  for (int j = 0; j < 3; ++j) {  // columns: the derivative along an axis
    Vec3T<Real> axis;
    axis[j] = Real(1);
    const Vec3T<Real> d0 = (axis - t0[j] * t0) / l0, d1 = (axis - t1[j] * t1) / l1;
    const Vec3T<Real> by0 = (Real(2) * cross(d0, t1) - dot(d0, t1) * out.binormal) / c;
    const Vec3T<Real> by1 = (Real(2) * cross(t0, d1) - dot(t0, d1) * out.binormal) / c;
    for (int i = 0; i < 3; ++i) {
      out.by_edge[0](i, j) = by0[i];
      out.by_edge[1](i, j) = by1[i];
    }
  }
  return out;
}

/// Energy of the bend at a node, and its derivatives by the two edges that meet there: e0 ends at
/// the node, e1 begins there.
template <class Real>
struct BendTerm {
  Real energy{};             ///< [nJ]
  Vec3T<Real> gradient[2];   ///< [uN]
  Mat3T<Real> hessian[3]{};  ///< blocks 00, 01, 11 [uN/mm], Gauss-Newton: never indefinite
};

/// E = EI |kb - kb_rest|^2 / l, with l the unloaded length of both edges.
///
/// Source: Bergou et al. 2008, section 4.2. kb_rest is a vector in space: a rod without frames
/// cannot turn it along, so a curved unloaded shape is for rods that hardly turn, as one held at
/// its ends; for a straight wire it is zero and the energy does not change under rotation.
///
/// @param e0, e1     edges [mm]
/// @param rest       kb_rest
/// @param length     l [mm], > 0
/// @param stiffness  EI [uN mm^2], >= 0
template <class Real>
ANGIO_HOST_DEVICE inline BendTerm<Real> bend_term(const Vec3T<Real>& e0, const Vec3T<Real>& e1,
                                                  const Vec3T<Real>& rest, Real length,
                                                  Real stiffness) {
  const Curvature<Real> k = curvature(e0, e1);
  const Vec3T<Real> off = k.binormal - rest;
  const Real weight = stiffness / length;
  BendTerm<Real> term;
  term.energy = weight * norm_squared(off);
  for (int a = 0; a < 2; ++a)
    term.gradient[a] = (Real(2) * weight) * (transpose(k.by_edge[a]) * off);
  const int pairs[3][2] = {{0, 0}, {0, 1}, {1, 1}};
  for (int h = 0; h < 3; ++h)
    term.hessian[h] =
        (Real(2) * weight) * (transpose(k.by_edge[pairs[h][0]]) * k.by_edge[pairs[h][1]]);
  return term;
}

/// What a rod resists with.
template <class Real>
struct RodSection {
  Real stretch{};  ///< EA [uN]
  Real bend{};     ///< EI [uN mm^2]
};

/// A rod's nodes next to each other in memory, and its unloaded shape.
template <class Real>
struct RodShape {
  int count = 0;                      ///< nodes, >= 3
  const Real* rest = nullptr;         ///< lengths [mm], shape [count - 1]
  const Vec3T<Real>* bend = nullptr;  ///< unloaded kb, shape [count]; of the inner nodes
};

/// A rod's linear system: symmetric, each node coupled to the next two.
template <class Real>
struct RodRow {
  Mat3T<Real> own, next, next_but_one;
  Vec3T<Real> force;  ///< right-hand side; the motion, once it is solved
};

/// Stretching and bending energy of a rod [nJ]. @param x  [mm], shape [node]
template <class Real>
ANGIO_HOST_DEVICE inline Real rod_energy(const RodShape<Real>& rod, const RodSection<Real>& section,
                                         const Vec3T<Real>* x) {
  Real energy = 0;
  for (int i = 0; i + 1 < rod.count; ++i)
    energy += stretch_term(x[i + 1] - x[i], rod.rest[i], section.stretch).energy;
  for (int i = 1; i + 1 < rod.count; ++i)
    energy += bend_term(x[i] - x[i - 1], x[i + 1] - x[i], rod.bend[i],
                        rod.rest[i - 1] + rod.rest[i], section.bend)
                  .energy;
  return energy;
}

/// Adds a rod's forces and its Hessian to a system. @param x  [mm], shape [node]
template <class Real>
ANGIO_HOST_DEVICE inline void add_rod(const RodShape<Real>& rod, const RodSection<Real>& section,
                                      const Vec3T<Real>* x, RodRow<Real>* rows) {
  for (int i = 0; i + 1 < rod.count; ++i) {
    const SegmentTerm<Real> s = stretch_term(x[i + 1] - x[i], rod.rest[i], section.stretch);
    rows[i].force += s.gradient;
    rows[i + 1].force -= s.gradient;
    rows[i].own += s.hessian;
    rows[i + 1].own += s.hessian;
    rows[i].next += Real(-1) * s.hessian;
  }
  for (int i = 1; i + 1 < rod.count; ++i) {
    const BendTerm<Real> b = bend_term(x[i] - x[i - 1], x[i + 1] - x[i], rod.bend[i],
                                       rod.rest[i - 1] + rod.rest[i], section.bend);
    const Mat3T<Real>&h00 = b.hessian[0], &h01 = b.hessian[1], &h11 = b.hessian[2];
    const Mat3T<Real> h10 = transpose(h01);
    rows[i - 1].force += b.gradient[0];
    rows[i].force += b.gradient[1] - b.gradient[0];
    rows[i + 1].force -= b.gradient[1];
    rows[i - 1].own += h00;
    rows[i].own += h00 + h11 + Real(-1) * (h01 + h10);
    rows[i + 1].own += h11;
    rows[i - 1].next += h01 + Real(-1) * h00;
    rows[i].next += h01 + Real(-1) * h11;
    rows[i - 1].next_but_one += Real(-1) * h01;
  }
}

/// Solves a rod's system in place, by block elimination from node to node; `force` becomes the
/// motion [mm]. The system is positive definite: inertia or a held node sees to it.
template <class Real>
ANGIO_HOST_DEVICE inline void solve_rod(int count, RodRow<Real>* rows) {
  for (int i = 0; i < count; ++i) {
    RodRow<Real>& row = rows[i];
    row.own = inverse(row.own);
    if (i + 1 >= count) break;
    const Mat3T<Real> to_next = transpose(row.next) * row.own;
    rows[i + 1].own += Real(-1) * (to_next * row.next);
    rows[i + 1].next += Real(-1) * (to_next * row.next_but_one);
    rows[i + 1].force -= to_next * row.force;
    if (i + 2 >= count) continue;
    const Mat3T<Real> further = transpose(row.next_but_one) * row.own;
    rows[i + 2].own += Real(-1) * (further * row.next_but_one);
    rows[i + 2].force -= further * row.force;
  }
  for (int i = count - 1; i >= 0; --i) {
    Vec3T<Real> right = rows[i].force;
    if (i + 1 < count) right -= rows[i].next * rows[i + 1].force;
    if (i + 2 < count) right -= rows[i].next_but_one * rows[i + 2].force;
    rows[i].force = rows[i].own * right;
  }
}

/// Takes a node out of a system: it does not move.
template <class Real>
ANGIO_HOST_DEVICE inline void hold_node(int node, RodRow<Real>* rows) {
  rows[node].own = Mat3T<Real>::identity();
  rows[node].next = rows[node].next_but_one = {};
  rows[node].force = {};
  if (node > 0) rows[node - 1].next = {};
  if (node > 1) rows[node - 2].next_but_one = {};
}

}  // namespace angio::simulation::detail
