#pragma once

#include "simulation/contact/adhesion.hpp"
#include "simulation/contact/contact_force.hpp"
#include "simulation/contact/distance.hpp"

/// What a step knows of contact: candidates, the near ones among them, and how far a
/// vertex may move.
namespace angio::simulation::detail {

/// A vertex and a triangle, or two edges, that face each other and may come near. A triangle whose
/// last two corners are one vertex is a segment of the guidewire.
struct Candidate {
  int vertex[4]{};  ///< vertex, triangle; or edge, edge
  bool edges = false;
  bool shaft = false;  ///< of the balloon and the shaft inside it
  bool self = false;   ///< of the balloon and itself, or the wall and itself
  float radius = 0;    ///< of the shaft there [mm]: it is taken off the gap
  float distance = 0;  ///< self: contact acts below this gap [mm]
  float gap = 0;       ///< where it was found, less the radius; at most that [mm]
};

/// A candidate that is near, and since when. What is read of one that does nothing comes first.
template <class Real>
struct NearPair {
  int vertex[4]{};                                  ///< as in Candidate
  bool edges = false, shaft = false, self = false;  ///< as in Candidate
  Real distance{};                                  ///< contact acts below this gap [mm]
  Real radius{};                                    ///< as in Candidate
  // At the last refresh:
  Real weight{};  ///< area, faded out for parallel edges; 0: out of contact
  Real film{};    ///< area of the film that holds vertex and triangle together [mm^2]
  GapWeights<Real> weights;
  Vec3T<Real> direction;   ///< unit gap direction
  Vec3T<Real> gap_before;  ///< sum w_i x_i at the start of the step
  Real gap{};              ///< less the radius; or, where nothing can act, a bound of it [mm]
  // At the search:
  Real gap_searched{};  ///< less the radius [mm]
  Real area{};          ///< that it stands for [mm^2]
  Vec3T<Real> normal;   ///< unit, from side b to side a
  Real limit[4]{};      ///< how far each vertex may move against its side of the normal [mm]
  /// Of the other side, the corner that moves at the same time, by its colour; -1: none.
  short twin[4] = {-1, -1, -1, -1};
};

/// A vertex's place in a candidate or a pair.
struct ContactRef {
  int pair = 0, corner = 0;
};

/// A plane that a vertex may not pass until the next search: n . (x - x_searched) >= -limit.
template <class Real>
struct MotionBound {
  Vec3T<Real> normal;
  Real limit{};  ///< [mm], >= 0
};

/// How surfaces act on each other: constants of a run.
template <class Real>
struct ContactLaw {
  Real distance = 0;       ///< contact acts below this gap [mm]
  Real range = 0;          ///< gap beyond which nothing acts [mm]
  Real self_distance = 0;  ///< of a surface with itself [mm]; 0: not looked for
  Real stiffness = 0;      ///< [Pa/mm]
  Friction<Real> friction;
  Adhesion<Real> adhesion;
};

/// All pairs nearer than this were candidates when they were found [mm].
template <class Real>
struct SearchRadii {
  Real search = 0;
  Real self = 0;  ///< of a surface with itself
};

/// A set of candidates, owned by their first vertex and in its order; replaced now and then.
template <class Real>
struct CandidateView {
  int count = 0;  ///< at most: on a GPU the room that there is
  const Candidate* list = nullptr;
  const int* owned_begin = nullptr;  ///< [vertex + 1] first candidate
  const int* ref_begin = nullptr;    ///< [vertex + 1] candidates, or near pairs, that it is in
  const ContactRef* refs = nullptr;
  const Vec3T<Real>* x = nullptr;  ///< positions when they were found
  const SearchRadii<Real>* radii = nullptr;
};

/// The near pairs, each owner's and each vertex's from where its candidates begin. All of it is
/// made anew by each search.
template <class Real>
struct NearPairView {
  NearPair<Real>* pairs = nullptr;
  int* owned_end = nullptr;
  int* pair_of = nullptr;  ///< of a candidate; -1: not near; null: not asked for
  ContactRef* refs = nullptr;
  int* listed_begin = nullptr;  ///< `ref_begin`, where one thread lists the pairs; [vertex + 1]
  int* ref_end = nullptr;
  MotionBound<Real>* bounds = nullptr;
  int* bound_end = nullptr;
  Real* moved = nullptr;     ///< [vertex] since the candidates, or the pairs, were found [mm]
  Real* max_move = nullptr;  ///< [vertex] how far it may move until the next search [mm]
};

}  // namespace angio::simulation::detail
