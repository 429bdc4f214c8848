#pragma once

#include "core/shared_counts.hpp"
#include "simulation/contact/candidate_gap.hpp"
#include "simulation/step/status.hpp"
#include "simulation/step/views.hpp"

/// The search for candidates as a program of loops whose indices may run in any order, or all at
/// once: for a GPU. It finds the same pairs as CandidateFinder and puts them in the same order.
///
/// Items (what of the balloon, the guidewire and, where surfaces meet themselves, the wall is
/// looked for) lie in a hash table by the cell that the middle of their box is in; queries (what
/// faces them) look into the cells where the middle of what is near may be. Source: Teschner et
/// al., "Optimized Spatial Hashing for Collision Detection of Deformable Objects", VMV 2003,
/// section 4.1; here an item is in one cell alone, and cells are as large as the search.
namespace angio::simulation::detail {

/// A vertex, an edge or a triangle, whose last corner fills the rest.
struct Primitive {
  int vertex[3]{};
  int corners = 0;
  int index = 0;  ///< among those of its kind
};

/// Vertices, edges and triangles of each body.
inline constexpr int kPrimitiveKinds = 3 * kBodyCount;
constexpr int primitive_kind(Body body, int corners) { return 3 * int(body) + corners - 1; }

struct SearchItem {
  Primitive shape;
  int kind = 0;
};

struct SearchQuery {
  Primitive shape;
  int family = 0;
};

/// Queries that look for one kind of items.
struct SearchFamily {
  int kind = 0;             ///< of the items
  bool item_first = false;  ///< in the candidate; else the query
  bool self = false, shaft = false;
};
inline constexpr int kMostFamilies = 10;

/// The cell of the middle of an item's box.
struct ItemCell {
  int at[3]{};
  int kind = 0;
  friend constexpr bool operator==(const ItemCell&, const ItemCell&) = default;
};

/// Constants of a search; lengths in mm.
struct SearchRules {
  int frames = 1;  ///< that a set should last
  double distance = 0.0, range = 0.0, self_distance = 0.0, rod_radius = 0.0;
  double most_move = 0.0;   ///< of a vertex between two searches for near pairs
  double most_reach = 0.0;  ///< beyond the range
};

/// What a search measures first [mm].
struct SearchMeasures {
  float moved[kBodyCount]{};        ///< by a body's vertices in this frame or the last, at most
  float extent[kPrimitiveKinds]{};  ///< half of an item's box, at most
};

/// A candidate or a place in one, on its way to its place in the order.
struct FoundEntry {
  float gap = 0;
  int candidate = 0, corner = 0;
};

/// What a search reads, works with, and makes. `found` and what follows have room for `capacity`
/// candidates.
template <class Real>
struct CandidateSearch {
  SearchRules rules;
  SearchFamily families[kMostFamilies];
  BodyRanges bodies;
  int item_count = 0, query_count = 0, vertex_count = 0, bucket_count = 0, capacity = 0;
  const SearchItem* items = nullptr;
  const SearchQuery* queries = nullptr;
  const Vec3* start = nullptr;  ///< of the scene [vertex]
  const char* fixed = nullptr;  ///< [vertex]
  // Where the bodies are, as in MotionView.
  Real dt = 0;
  const Vec3T<Real>* x = nullptr;
  const Vec3T<Real>* velocity = nullptr;
  const Vec3T<Real>* x_before = nullptr;
  const StepStatus* status = nullptr;
  // To be zero before a search.
  SearchMeasures* measures = nullptr;
  int* counts = nullptr;  ///< [zero_count()]
  // Work.
  int* next = nullptr;  ///< [item] the one behind it in its bucket + 1; 0: none
  ItemCell* cells = nullptr;
  Candidate* found = nullptr;     ///< in no order
  FoundEntry* owned = nullptr;    ///< by owner, in no order
  FoundEntry* entries = nullptr;  ///< [4 candidates] by vertex, in no order
  // Result: what a CandidateView shows.
  Candidate* list = nullptr;
  int* owned_begin = nullptr;
  int* ref_begin = nullptr;
  ContactRef* refs = nullptr;
  Vec3T<Real>* x_found = nullptr;
  SearchRadii<Real>* radii = nullptr;

  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit(ArrayRole::model, item_count, items);
    visit(ArrayRole::model, query_count, queries);
    visit(ArrayRole::model, vertex_count, start, fixed);
    visit(ArrayRole::work, 1, measures, radii);
    visit(ArrayRole::work, zero_count(), counts);
    visit(ArrayRole::work, item_count, next, cells);
    visit(ArrayRole::work, vertex_count + 1, owned_begin, ref_begin);
    visit(ArrayRole::work, vertex_count, x_found);
  }
  void link() {}

  [[nodiscard]] ANGIO_HOST_DEVICE int zero_count() const {
    return 1 + 2 * (vertex_count + 1) + bucket_count;
  }
  /// Candidates that were found: more than `capacity` are a set that is not to be used.
  [[nodiscard]] ANGIO_HOST_DEVICE int* found_count() const { return counts; }
  [[nodiscard]] ANGIO_HOST_DEVICE int* owned_count() const { return counts + 1; }
  [[nodiscard]] ANGIO_HOST_DEVICE int* ref_count() const {
    return owned_count() + vertex_count + 1;
  }
  [[nodiscard]] ANGIO_HOST_DEVICE int* buckets() const { return ref_count() + vertex_count + 1; }
  [[nodiscard]] ANGIO_HOST_DEVICE bool fits() const { return *found_count() <= capacity; }
  [[nodiscard]] ANGIO_HOST_DEVICE bool has(int candidate) const {
    return fits() && candidate < *found_count();
  }
};

/// Positions in double precision.
template <class Real>
struct PointsInDouble {
  const Vec3T<Real>* x;
  ANGIO_HOST_DEVICE Vec3 operator[](std::size_t v) const { return in_double(x[v]); }
};

/// Along the axes [mm].
struct PrimitiveBox {
  Vec3 low, high;
};

template <class Real>
ANGIO_HOST_DEVICE inline PrimitiveBox box_around(const CandidateSearch<Real>& s,
                                                 const Primitive& primitive) {
  const PointsInDouble<Real> x{s.x};
  PrimitiveBox box{x[std::size_t(primitive.vertex[0])], x[std::size_t(primitive.vertex[0])]};
  for (int i = 1; i < primitive.corners; ++i) {
    const Vec3 p = x[std::size_t(primitive.vertex[i])];
    for (int k = 0; k < 3; ++k) {
      box.low[k] = p[k] < box.low[k] ? p[k] : box.low[k];
      box.high[k] = p[k] > box.high[k] ? p[k] : box.high[k];
    }
  }
  return box;
}

/// So far do bodies go, as a multiple of what they did in this frame or the last, in each frame
/// that a set is to last; and beyond that, as a multiple of what a vertex may go between two
/// searches for near pairs. Above 1.001, so that a new set always lets a step go on.
inline constexpr double kAsFarAgain = 1.5, kMovesAhead = 1.1;

/// How far a set reaches: as far as bodies are likely to come while it lasts.
///
///     r = range + min(most_reach, max over bodies a, b that may touch of (reach_a + reach_b))
///     reach = kMovesAhead most_move + kAsFarAgain frames moved
template <class Real>
ANGIO_HOST_DEVICE inline SearchRadii<double> radii_of(const CandidateSearch<Real>& s) {
  const SearchRules& rules = s.rules;
  double reach[kBodyCount] = {};
  for (int b = 0; b < kBodyCount; ++b)
    if (s.bodies[Body(b)].count > 0)
      reach[b] =
          kMovesAhead * rules.most_move + kAsFarAgain * rules.frames * double(s.measures->moved[b]);
  const double others = most_of_pairs(reach), self = 2.0 * most_of(reach), most = rules.most_reach;
  return {rules.range + (others < most ? others : most),
          rules.self_distance > 0.0 ? rules.self_distance + (self < most ? self : most) : 0.0};
}

/// The larger of the radii, with the shaft's.
template <class Real>
ANGIO_HOST_DEVICE inline double farthest(const CandidateSearch<Real>& s,
                                         const SearchRadii<double>& radii) {
  return (radii.search > radii.self ? radii.search : radii.self) + s.rules.rod_radius;
}

/// Half of an item's box, at most, a little more for rounding [mm].
template <class Real>
ANGIO_HOST_DEVICE inline double extent_of(const CandidateSearch<Real>& s, int kind) {
  return 1.00001 * double(s.measures->extent[kind]) + 1e-6 * s.rules.distance;
}

ANGIO_HOST_DEVICE inline int cell_at(double place, double size) {
  return int(std::floor(place / size));
}

template <class Real>
ANGIO_HOST_DEVICE inline double cell_size(const CandidateSearch<Real>& s, int kind,
                                          const SearchRadii<double>& radii) {
  return farthest(s, radii) + extent_of(s, kind);
}

template <class Real>
ANGIO_HOST_DEVICE inline int& bucket_of(const CandidateSearch<Real>& s, const ItemCell& cell) {
  const unsigned hash = (unsigned(cell.at[0]) * 73856093U) ^ (unsigned(cell.at[1]) * 19349663U) ^
                        (unsigned(cell.at[2]) * 83492791U) ^ (unsigned(cell.kind) * 2654435761U);
  return s.buckets()[hash & unsigned(s.bucket_count - 1)];
}

/// Measures items and vertices, and remembers where these are.
struct MeasureBodies {
  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int i) {
    if (i < s.item_count) {
      const PrimitiveBox box = box_around(s, s.items[i].shape);
      for (int k = 0; k < 3; ++k)
        raise_to(s.measures->extent[s.items[i].kind], float(0.5 * (box.high[k] - box.low[k])));
      return;
    }
    const int v = i - s.item_count;
    s.x_found[v] = s.x[v];
    const Body body = s.bodies.of(v);
    if (v >= s.bodies[body].end()) return;  // a copy of the wall further out
    const Real before = s.dt * norm(s.velocity[v]);
    const Real now = s.status->stage == StepStage::begin ? Real(0) : norm(s.x[v] - s.x_before[v]);
    raise_to(s.measures->moved[int(body)], float(now > before ? now : before));
  }
};

struct PutItems {
  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int i) {
    const PrimitiveBox box = box_around(s, s.items[i].shape);
    ItemCell cell{{}, s.items[i].kind};
    const double size = cell_size(s, cell.kind, radii_of(s));
    for (int k = 0; k < 3; ++k) cell.at[k] = cell_at(0.5 * (box.low[k] + box.high[k]), size);
    s.cells[i] = cell;
    s.next[i] = exchange(bucket_of(s, cell), i + 1);
  }
};

/// The candidate that a query and an item make.
ANGIO_HOST_DEVICE inline Candidate candidate_of(const SearchFamily& family, const Primitive& query,
                                                const Primitive& item) {
  const Primitive& a = family.item_first ? item : query;
  const Primitive& b = family.item_first ? query : item;
  if (a.corners == 2) return {{a.vertex[0], a.vertex[1], b.vertex[0], b.vertex[1]}, true};
  return {{a.vertex[0], b.vertex[0], b.vertex[1], b.vertex[2]}};
}

/// May two primitives of one surface meet, and are they not the pair seen from the other side?
template <class Real>
ANGIO_HOST_DEVICE inline bool may_meet(const CandidateSearch<Real>& s, const Primitive& query,
                                       const Primitive& item) {
  if (query.corners == item.corners && item.index <= query.index) return false;
  bool held = true;
  for (int i = 0; i < query.corners; ++i) held = held && s.fixed[query.vertex[i]] != 0;
  for (int k = 0; k < item.corners; ++k) {
    for (int i = 0; i < query.corners; ++i)
      if (query.vertex[i] == item.vertex[k]) return false;
    held = held && s.fixed[item.vertex[k]] != 0;
  }
  return !held;
}

/// Adds the pair of a query and an item if it is near.
template <class Real>
ANGIO_HOST_DEVICE inline void add_pair(const CandidateSearch<Real>& s, const SearchQuery& query,
                                       const Primitive& item, double radius) {
  const SearchFamily& family = s.families[query.family];
  const PointsInDouble<double> start{s.start};
  if (family.self && !may_meet(s, query.shape, item)) return;
  Candidate candidate = candidate_of(family, query.shape, item);
  if (family.shaft && !take_radius(start, s.rules.rod_radius, s.rules.distance, candidate)) return;
  if (!take_gap(PointsInDouble<Real>{s.x}, radius, candidate)) return;
  if (family.self) take_self_distance(start, s.rules.self_distance, candidate);
  const int place = add_to(*s.found_count(), 1);
  if (place >= s.capacity) return;
  s.found[place] = candidate;
  add_to(s.owned_count()[candidate.vertex[0]], 1);
  for (const int v : candidate.vertex) add_to(s.ref_count()[v], 1);
}

/// Looks for what is near a query: kSearchers of them share its cells.
struct FindPairs {
  static constexpr int kSearchers = 32;

  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int i) {
    const SearchQuery query = s.queries[i / kSearchers];
    const SearchFamily& family = s.families[query.family];
    const SearchRadii<double> radii = radii_of(s);
    const double radius = family.self ? radii.self : radii.search;
    const double far = radius + (family.shaft ? s.rules.rod_radius : 0.0);
    const double around = far + extent_of(s, family.kind), size = cell_size(s, family.kind, radii);
    const PrimitiveBox box = box_around(s, query.shape);
    int low[3], across[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = cell_at(box.low[k] - around, size);
      across[k] = cell_at(box.high[k] + around, size) - low[k] + 1;
    }
    for (int c = i % kSearchers; c < across[0] * across[1] * across[2]; c += kSearchers)
      look_into({{low[0] + c % across[0], low[1] + c / across[0] % across[1],
                  low[2] + c / (across[0] * across[1])},
                 family.kind},
                s, query, box, {far, radius});
  }

 private:
  struct Reach {
    double box, gap;
  };

  template <class Real>
  static ANGIO_HOST_DEVICE void look_into(const ItemCell& cell, const CandidateSearch<Real>& s,
                                          const SearchQuery& query, const PrimitiveBox& box,
                                          const Reach& reach) {
    for (int next = bucket_of(s, cell); next > 0; next = s.next[next - 1]) {
      if (!(s.cells[next - 1] == cell)) continue;
      const Primitive& item = s.items[next - 1].shape;
      const PrimitiveBox other = box_around(s, item);
      bool meet = true;
      for (int k = 0; k < 3; ++k)
        meet = meet && other.low[k] <= box.high[k] + reach.box &&
               other.high[k] >= box.low[k] - reach.box;
      if (meet) add_pair(s, query, item, reach.gap);
    }
  }
};

/// Gathers each owner's candidates.
struct GatherOwned {
  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int i) {
    if (!s.has(i)) return;
    const int v = s.found[i].vertex[0];
    s.owned[s.owned_begin[v] + add_to(s.owned_count()[v], -1) - 1] = {s.found[i].gap, i, 0};
  }
};

/// Puts each candidate in its place among its owner's, and gathers the candidates of each vertex.
struct SortOwned {
  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int i) {
    if (!s.has(i)) return;
    const FoundEntry entry = s.owned[i];
    const Candidate candidate = s.found[entry.candidate];
    const int owner = candidate.vertex[0];
    int place = s.owned_begin[owner];
    for (int k = s.owned_begin[owner]; k < s.owned_begin[owner + 1]; ++k) {
      const FoundEntry other = s.owned[k];
      place += other.gap < entry.gap ||
               (other.gap == entry.gap && comes_before(s.found[other.candidate], candidate));
    }
    s.list[place] = candidate;
    for (int corner = 0; corner < 4; ++corner) {
      const int v = candidate.vertex[corner];
      s.entries[s.ref_begin[v] + add_to(s.ref_count()[v], -1) - 1] = {candidate.gap, place, corner};
    }
  }
};

/// Puts each vertex's candidates in their order: by ascending gap, then as they are listed.
struct SortRefs {
  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int i) {
    if (!s.has(i / 4)) return;
    const FoundEntry entry = s.entries[i];
    const int v = s.list[entry.candidate].vertex[entry.corner];
    int place = s.ref_begin[v];
    for (int k = s.ref_begin[v]; k < s.ref_begin[v + 1]; ++k) {
      const FoundEntry other = s.entries[k];
      const bool tie = other.gap == entry.gap, same = other.candidate == entry.candidate;
      place += other.gap < entry.gap || (tie && other.candidate < entry.candidate) ||
               (tie && same && other.corner < entry.corner);
    }
    s.refs[place] = {entry.candidate, entry.corner};
  }
};

/// Tells how far the set reaches: nowhere if there was no room for it.
struct TellRadii {
  template <class Real>
  static ANGIO_HOST_DEVICE void run(const CandidateSearch<Real>& s, int) {
    const SearchRadii<double> radii = radii_of(s);
    *s.radii =
        s.fits() ? SearchRadii<Real>{Real(radii.search), Real(radii.self)} : SearchRadii<Real>{};
  }
};

/// Finds the candidates where the bodies are. `Loops` has
///
///     clear(values, count)              sets them to zero
///     for_each<Loop>(count, search)     Loop::run(search, i) for i in [0, count)
///     scan(values, sums, count)         sums[i] = values[0] + ... + values[i - 1]
///
/// each of which ends before the next begins.
template <class Real, class Loops>
void search_candidates(Loops& loops, const CandidateSearch<Real>& search) {
  const int vertices = search.vertex_count, items = search.item_count;
  loops.clear(search.measures, 1);
  loops.clear(search.counts, search.zero_count());
  loops.template for_each<MeasureBodies>(items + vertices, search);
  loops.template for_each<PutItems>(items, search);
  loops.template for_each<FindPairs>(FindPairs::kSearchers * search.query_count, search);
  loops.scan(search.owned_count(), search.owned_begin, vertices + 1);
  loops.scan(search.ref_count(), search.ref_begin, vertices + 1);
  loops.template for_each<GatherOwned>(search.capacity, search);
  loops.template for_each<SortOwned>(search.capacity, search);
  loops.template for_each<SortRefs>(4 * search.capacity, search);
  loops.template for_each<TellRadii>(1, search);
}

}  // namespace angio::simulation::detail
