#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "air_mesh/build/surface_crossings.hpp"
#include "meshing/detail/patch.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/detail/surface_editor.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {
namespace {

using Vertex = SurfaceEditor::Vertex;
using Edge = SurfaceEditor::Edge;
using Halfedge = SurfaceEditor::Halfedge;
using Face = SurfaceEditor::Face;
using Place = SurfaceEditor::Place;

constexpr double kWanted = sine_squared_of_degrees(28.0);
constexpr double kLeast = sine_squared_of_degrees(21.0);
constexpr double kNeedle = sine_squared_of_degrees(20.0);  // what flow solvers can use
constexpr double kGain = 1.02;  // a step must raise the least squared sine around it by this

/// Raises the least angles of a finished surface one poor triangle at a time.
class AngleImprover {
 public:
  AngleImprover(SurfaceDraft& draft, const SurfaceTarget* target, const std::vector<char>& free)
      : editor_(draft, target, free), mesh_(editor_.mesh()) {
    editor_.keep_levels();
    editor_.keep_angle(0.0);
  }

  void run() {
    constexpr int kRounds = 12;
    for (int round = 0; round < kRounds; ++round) {
      std::vector<Face> poor;
      for (const Face f : mesh_.faces())
        if (editor_.least_sine_squared(f) < kWanted) poor.push_back(f);
      int done = 0;
      for (const Face f : poor)
        if (!mesh_.is_removed(f) && editor_.least_sine_squared(f) < kWanted)
          done += improve(f) ? 1 : 0;
      if (done == 0) break;
    }
    editor_.store();
  }

 private:
  bool improve(Face f) {
    bool done = false;
    for (const Halfedge h : CGAL::halfedges_around_face(mesh_.halfedge(f), mesh_))
      if (flip_if_better(h)) return true;
    for (const Halfedge h : CGAL::halfedges_around_face(mesh_.halfedge(f), mesh_))
      done |= move_if_better(mesh_.target(h));
    if (done && editor_.least_sine_squared(f) >= kWanted) return true;
    return collapse_if_better(f) || split_if_better(f) || done;
  }

  bool flip_if_better(Halfedge h) {
    const Edge e = mesh_.edge(h);
    if (mesh_.is_border(e) || !editor_.is_free(e)) return false;
    const auto [before, after] = editor_.flip_shapes(h);
    return after > kGain * before && editor_.flip(h);
  }

  /// The best of places around a vertex, in the tangent plane.
  bool move_if_better(Vertex v) {
    if (!editor_.is_free(v)) return false;
    const Vec3 from = editor_.position(v);
    const double before = editor_.least_sine_squared_around(v, from);
    if (before >= kWanted) return false;
    const Vec3 u = any_perpendicular(editor_.normal(v));
    const Vec3 w = cross(editor_.normal(v), u);
    double best = kGain * before;
    bool found = false;
    Place best_place{};
    constexpr int kTurns = 12;
    for (const double part : {0.05, 0.12, 0.25, 0.4})
      for (int turn = 0; turn < kTurns; ++turn) {
        const double angle = 2.0 * std::numbers::pi * turn / kTurns;
        const double step = part * editor_.wanted_length(v);
        const Vec3 wish = from + step * (std::cos(angle) * u + std::sin(angle) * w);
        if (editor_.rim(v) < 0 && editor_.least_sine_squared_around(v, wish) < 0.9 * best) continue;
        const Place place = editor_.place_near(v, wish);
        const double after = editor_.least_sine_squared_around(v, place.point);
        if (after <= best || !editor_.may_move(v, place)) continue;
        best = after;
        best_place = place;
        found = true;
      }
    if (found) editor_.move(v, best_place);
    return found;
  }

  [[nodiscard]] Halfedge shortest(Face f) const {
    Halfedge best = mesh_.halfedge(f);
    for (const Halfedge h : CGAL::halfedges_around_face(mesh_.halfedge(f), mesh_))
      if (editor_.length(mesh_.edge(h)) < editor_.length(mesh_.edge(best))) best = h;
    return best;
  }
  [[nodiscard]] Halfedge longest(Face f) const {
    Halfedge best = mesh_.halfedge(f);
    for (const Halfedge h : CGAL::halfedges_around_face(mesh_.halfedge(f), mesh_))
      if (editor_.length(mesh_.edge(h)) > editor_.length(mesh_.edge(best))) best = h;
    return best;
  }

  /// Without its shortest edge, the triangle is gone.
  bool collapse_if_better(Face f) {
    const Edge e = mesh_.edge(shortest(f));
    if (!editor_.is_free(e)) return false;
    const double before = editor_.least_sine_squared(f);
    return editor_.collapse(e, 2.0, kGain * before);
  }

  /// A flat triangle over a long edge gets a vertex in that edge; flips and moves then round it.
  bool split_if_better(Face f) {
    const Halfedge h = longest(f);
    const Edge e = mesh_.edge(h);
    if (!editor_.is_free(mesh_.source(h)) || !editor_.is_free(mesh_.target(h))) return false;
    if (editor_.length(e) < 1.1 * editor_.wanted_length(e)) return false;
    editor_.split(e);
    return true;
  }

  SurfaceEditor editor_;
  const SurfaceEditor::Mesh& mesh_;
};

/// Of each triangle, as lengths count where the lumen will be widened.
std::vector<double> least_sines_squared(const SurfaceDraft& draft) {
  const std::vector<Vec3>& x = draft.mesh.vertices;
  const std::vector<Vec3> w = draft.widening ? draft.widening->at(x) : std::vector<Vec3>(x.size());
  std::vector<double> sines;
  for (const Triangle& t : draft.mesh.triangles) {
    const auto a = std::size_t(t[0]), b = std::size_t(t[1]), c = std::size_t(t[2]);
    const Vec3 mean = (1.0 / 3.0) * (w[a] + w[b] + w[c]);
    sines.push_back(
        least_sine_squared(Vec3{}, shortened(x[b] - x[a], mean), shortened(x[c] - x[a], mean)));
  }
  return sines;
}

double least_of(const SurfaceDraft& draft) {
  const std::vector<double> sines = least_sines_squared(draft);
  return std::accumulate(sines.begin(), sines.end(), 1.0,
                         [](double a, double b) { return std::min(a, b); });
}

std::vector<char> corners_of_poor(const SurfaceDraft& draft, double sine_squared) {
  std::vector<char> marked(draft.mesh.vertices.size(), 0);
  const std::vector<double> sines = least_sines_squared(draft);
  for (std::size_t t = 0; t < sines.size(); ++t)
    if (sines[t] < sine_squared)
      for (const int v : draft.mesh.triangles[t]) marked[std::size_t(v)] = 1;
  return marked;
}

/// Crossings and sharp folds with a marked triangle.
std::vector<std::array<int, 2>> faults_of(const TriangleMesh& mesh,
                                          const std::vector<char>& marked) {
  auto pairs = air_mesh::self_intersections_of(mesh, marked);
  const auto folds = sharp_folds_of(mesh, marked);
  pairs.insert(pairs.end(), folds.begin(), folds.end());
  return pairs;
}

/// Improves all poor triangles at once; where that makes triangles cross, the surface is left.
void improve_everywhere(SurfaceDraft& draft, const SurfaceTarget& target) {
  constexpr int kAttempts = 3;
  constexpr int kRings = 4;
  std::vector<Vec3> untouchable;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Patch patch = take_patch(draft, corners_of_poor(draft, kWanted), kRings);
    if (patch.empty()) return;
    for (std::size_t v = 0; v < patch.free.size(); ++v)
      for (const Vec3& place : untouchable)
        if (distance(patch.draft.mesh.vertices[v], place) < 3.0 * patch.draft.edge_length[v])
          patch.free[v] = 0;
    AngleImprover(patch.draft, &target, patch.free).run();
    SurfaceDraft improved = draft;
    const std::vector<char> changed = put_back(improved, patch);
    const auto pairs = faults_of(improved.mesh, changed);
    if (pairs.empty()) {
      draft = std::move(improved);
      return;
    }
    for (const auto& pair : pairs)
      for (const int t : pair)
        for (const int c : improved.mesh.triangles[std::size_t(t)])
          untouchable.push_back(improved.mesh.vertices[std::size_t(c)]);
  }
}

/// How a patch may be improved: as stiffly as that goes, with the target first, then as a membrane.
struct Way {
  int ring_count;
  bool as_membrane;
};
constexpr std::array<Way, 6> kWays{
    {{3, false}, {1, false}, {1, true}, {2, true}, {4, true}, {7, true}}};
constexpr std::size_t kWaysOnTarget = 2;  // the first of them

/// Improves the patch around one place on its own. @return false if nothing helps
bool improve_place(SurfaceDraft& draft, const SurfaceTarget& target, const Vec3& place,
                   std::span<const Way> ways) {
  std::vector<char> marked(draft.mesh.vertices.size(), 0);
  for (std::size_t v = 0; v < marked.size(); ++v)
    marked[v] = distance(draft.mesh.vertices[v], place) < 1.5 * draft.edge_length[v] ? 1 : 0;
  for (const Way way : ways) {
    Patch patch = take_patch(draft, marked, way.ring_count);
    if (patch.empty()) return false;
    const double before = least_of(patch.draft);
    if (way.as_membrane) {
      constexpr int kRounds = 3;
      for (std::size_t v = 0; v < patch.free.size(); ++v)
        if (patch.free[v]) patch.draft.membrane[v] = 1;
      remesh_membrane(patch.draft, patch.free, kRounds);
    }
    AngleImprover(patch.draft, &target, patch.free).run();
    const double after = least_of(patch.draft);
    if (after < kLeast && after <= kGain * before) continue;
    SurfaceDraft improved = draft;
    const std::vector<char> changed = put_back(improved, patch);
    if (!faults_of(improved.mesh, changed).empty()) continue;
    draft = std::move(improved);
    return true;
  }
  return false;
}

/// Improves the places of triangles below an angle, one after the other.
void improve_places(SurfaceDraft& draft, const SurfaceTarget& target, double sine_squared,
                    std::span<const Way> ways) {
  constexpr int kPlaces = 200;
  std::vector<Vec3> hopeless;
  for (int i = 0; i < kPlaces; ++i) {
    const auto first_corner = [&](std::size_t t) {
      return std::size_t(draft.mesh.triangles[t][0]);
    };
    const auto is_hopeless = [&](std::size_t t) {
      return std::any_of(hopeless.begin(), hopeless.end(), [&](const Vec3& place) {
        return distance(place, draft.mesh.vertices[first_corner(t)]) <
               draft.edge_length[first_corner(t)];
      });
    };
    const std::vector<double> sines = least_sines_squared(draft);
    std::size_t poor = 0;
    while (poor < sines.size() && (sines[poor] >= sine_squared || is_hopeless(poor))) ++poor;
    if (poor == sines.size()) break;
    const Vec3 place = draft.mesh.vertices[first_corner(poor)];
    if (!improve_place(draft, target, place, ways)) hopeless.push_back(place);
  }
}

/// Sets of marked vertices that hang together.
std::vector<std::vector<int>> connected_sets(const TriangleMesh& mesh,
                                             const std::vector<char>& marked) {
  const auto neighbors = vertex_neighbors(mesh);
  std::vector<char> seen(marked.size(), 0);
  std::vector<std::vector<int>> sets;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (marked[first] == 0 || seen[first] != 0) continue;
    std::vector<int> set{int(first)};
    seen[first] = 1;
    for (std::size_t i = 0; i < set.size(); ++i)
      for (const int v : neighbors[std::size_t(set[i])]) {
        if (marked[std::size_t(v)] == 0 || seen[std::size_t(v)] != 0) continue;
        seen[std::size_t(v)] = 1;
        set.push_back(v);
      }
    sets.push_back(std::move(set));
  }
  return sets;
}

/// Takes a patch's free vertices to the target; each connected part as far from it as, on average,
/// the vertices that tie it to the rest.
/// @return places from which the target is out of reach
std::vector<Vec3> project_free(Patch& patch, const SurfaceTarget& target) {
  constexpr double kNear = 0.1;  // of the edge length: there
  SurfaceDraft& draft = patch.draft;
  std::vector<Vec3> beyond;
  const std::vector<char> all(patch.free.size(), 1);
  for (const std::vector<int>& part : connected_sets(draft.mesh, all)) {
    double level = 0.0;
    int tied = 0;
    for (const int v : part) {
      if (patch.free[std::size_t(v)] != 0 || draft.membrane[std::size_t(v)] != 0) continue;
      level += target.evaluate(draft.mesh.vertices[std::size_t(v)]).signed_distance;
      ++tied;
    }
    if (tied > 0) level /= tied;
    for (const int v : part) {
      if (patch.free[std::size_t(v)] == 0 || draft.rim[std::size_t(v)] >= 0) continue;
      draft.membrane[std::size_t(v)] = 0;
      Vec3& at = draft.mesh.vertices[std::size_t(v)];
      const double edge = draft.edge_length[std::size_t(v)];
      const Vec3 there = target.project(at, 0.5 * edge, level).point;
      if (std::abs(target.evaluate(there).signed_distance - level) > kNear * edge)
        beyond.push_back(at);
      at = there;
    }
  }
  return beyond;
}

/// Where a draft has become wrong: corners of changed triangles that are poor, fold or cross.
std::vector<Vec3> wrong_places(const SurfaceDraft& draft, const std::vector<char>& changed) {
  std::vector<char> is_wrong(changed.size(), 0);
  const std::vector<double> sines = least_sines_squared(draft);
  for (std::size_t t = 0; t < changed.size(); ++t)
    is_wrong[t] = changed[t] != 0 && sines[t] < kLeast ? 1 : 0;
  for (const auto& pair : faults_of(draft.mesh, changed))
    for (const int t : pair) is_wrong[std::size_t(t)] = 1;
  std::vector<Vec3> places;
  for (std::size_t t = 0; t < is_wrong.size(); ++t)
    if (is_wrong[t] != 0)
      places.push_back(draft.mesh.vertices[std::size_t(draft.mesh.triangles[t][0])]);
  return places;
}

}  // namespace

void bring_membranes_back(SurfaceDraft& draft, const SurfaceTarget& target) {
  constexpr int kAttempts = 6;
  constexpr int kRings = 3;  // what was collapsed beside a membrane lies beside the target, too
  draft.membrane.resize(draft.mesh.vertices.size(), 0);
  std::vector<std::vector<int>> membranes = connected_sets(draft.mesh, draft.membrane);
  for (int attempt = 0; attempt < kAttempts && !membranes.empty(); ++attempt) {
    std::vector<char> marked(draft.mesh.vertices.size(), 0);
    for (const std::vector<int>& membrane : membranes)
      for (const int v : membrane) marked[std::size_t(v)] = 1;
    Patch patch = take_patch(draft, marked, kRings);
    std::vector<Vec3> wrong = project_free(patch, target);
    AngleImprover(patch.draft, &target, patch.free).run();
    SurfaceDraft improved = draft;
    const std::vector<char> changed = put_back(improved, patch);
    for (const Vec3& place : wrong_places(improved, changed)) wrong.push_back(place);
    if (wrong.empty()) {
      draft = std::move(improved);
      return;
    }
    std::vector<char> stays(membranes.size(), 0);
    for (const Vec3& place : wrong) {
      const auto away = [&](const std::vector<int>& membrane) {
        double nearest = 1e300;
        for (const int v : membrane)
          nearest = std::min(nearest, distance(place, draft.mesh.vertices[std::size_t(v)]));
        return nearest;
      };
      const auto nearest =
          std::min_element(membranes.begin(), membranes.end(),
                           [&](const auto& a, const auto& b) { return away(a) < away(b); });
      stays[std::size_t(nearest - membranes.begin())] = 1;
    }
    std::vector<std::vector<int>> left;
    for (std::size_t m = 0; m < membranes.size(); ++m)
      if (stays[m] == 0) left.push_back(std::move(membranes[m]));
    membranes = std::move(left);
  }
}

std::vector<std::array<int, 2>> improve_angles(SurfaceDraft& draft, const SurfaceTarget& target) {
  improve_everywhere(draft, target);
  improve_places(draft, target, kLeast, kWays);
  if (draft.widening && !draft.widening->is_none()) {
    // Of angles that are good as they count, some few are not as they are. A throat is too narrow
    // for membranes: they would dent it.
    const Widening* widening = std::exchange(draft.widening, nullptr);
    improve_places(draft, target, kNeedle, std::span(kWays).first(kWaysOnTarget));
    draft.widening = widening;
  }
  std::vector<std::array<int, 2>> left;
  const std::vector<double> sines = least_sines_squared(draft);
  for (std::size_t t = 0; t < sines.size(); ++t)
    if (sines[t] < kLeast) left.push_back({int(t), int(t)});
  return left;
}

}  // namespace angio::meshing::detail
