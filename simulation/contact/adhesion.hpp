#pragma once

#include "core/host_device.hpp"

/// Adhesion of two wet surfaces, by the gap between them.
namespace angio::simulation::detail {

/// The film holds from gap 1 to gap 2 with at most `traction` per area.
template <class Real>
struct Adhesion {
  Real traction{};        ///< [Pa]; 0: no adhesion
  Real gap_1{}, gap_2{};  ///< [mm], gap_1 < gap_2
};

/// What a unit area of film holds: energy, traction and stiffness by the gap.
template <class Real>
struct FilmPull {
  Real energy{}, traction{}, stiffness{};  ///< [Pa mm], [Pa], [Pa/mm]
};

/// The film's traction at a gap g, with u = (g - g1) / (g2 - g1) in (0, 1), T its maximum:
///
///     t(g) = 27/4 T u (1 - u)^2,   greatest, T, at u = 1/3;   work of parting 9/16 T (g2 - g1)
///
/// A traction-separation law with an energy: within a step it takes nothing and gives nothing; what
/// parting costs is lost once, because the film does not come back until the surfaces touch again
/// (stays_wet). So the seed paper's viscous item (section 4.3) is kept in what it does, with gaps
/// in place of volumes of tets, which depend on the mesh, and a finite pull in place of its
/// constraint, which is an unbounded bond.
///
/// Source: Needleman, "A Continuum Model for Void Nucleation by Inclusion Debonding", J. Appl.
/// Mech. 54 (1987), the polynomial law.
template <class Real>
ANGIO_HOST_DEVICE inline FilmPull<Real> film_pull(const Adhesion<Real>& a, Real gap) {
  const Real span = a.gap_2 - a.gap_1, u = (gap - a.gap_1) / span;
  if (u <= Real(0)) return {};
  const Real scale = Real(6.75) * a.traction;
  if (u >= Real(1)) return {scale * span / Real(12), Real(0), Real(0)};
  const Real left = Real(1) - u;
  return {scale * span * u * u * (Real(0.5) - u * (Real(2) / Real(3) - Real(0.25) * u)),
          scale * u * left * left, scale * left * (Real(1) - Real(3) * u) / span};
}

/// Is a place wet after a step? It gets wet when it touches, up to gap 1; the film breaks for good
/// at gap 2; in between it stays what it was. Kept per vertex, so that it survives new pairs.
template <class Real>
ANGIO_HOST_DEVICE inline bool stays_wet(const Adhesion<Real>& a, bool wet, Real gap) {
  if (gap <= a.gap_1) return true;
  return wet && gap < a.gap_2;
}

}  // namespace angio::simulation::detail
