#include "meshing/detail/remesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.hpp"
#include "meshing/detail/surface_editor.hpp"

namespace angio::meshing::detail {
namespace {

using Vertex = SurfaceEditor::Vertex;
using Edge = SurfaceEditor::Edge;
using Halfedge = SurfaceEditor::Halfedge;
using Place = SurfaceEditor::Place;

constexpr double kGood = sine_squared_of_degrees(30.0);  // below it, the last rounds improve
constexpr double kSliver = sine_squared_of_degrees(25.0);
constexpr double kPoor = sine_squared_of_degrees(15.0);

class Remesher {
 public:
  Remesher(SurfaceDraft& draft, const SurfaceTarget* target, const std::vector<char>& free)
      : editor_(draft, target, free), mesh_(editor_.mesh()), keeps_tangent_(target != nullptr) {}

  void run(int round_count) {
    collapse_short_edges();  // the raw surface is far too fine; thin it before anything else
    for (int round = 0; round < round_count; ++round) {
      split_long_edges();
      collapse_short_edges();
      flip_edges(&Remesher::improves_valence);
      relax();
      relax();
    }
    editor_.keep_angle(22.0);
    for (int round = 0; round < 4; ++round) {
      flip_edges(&Remesher::improves_angle);
      collapse_slivers();
      relax();
    }
    flip_edges(&Remesher::improves_angle);
    editor_.store();
  }

 private:
  using FlipRule = bool (Remesher::*)(Halfedge) const;

  [[nodiscard]] std::vector<Edge> edges_where(auto&& condition) const {
    std::vector<Edge> edges;
    for (const Edge e : mesh_.edges())
      if (editor_.is_free(e) && condition(e)) edges.push_back(e);
    return edges;
  }

  void split_long_edges() {
    for (int sweep = 0; sweep < 4; ++sweep) {
      const auto edges = edges_where(
          [&](Edge e) { return editor_.length(e) > 4.0 / 3.0 * editor_.wanted_length(e); });
      if (edges.empty()) return;
      for (const Edge e : edges) editor_.split(e);
    }
  }

  [[nodiscard]] bool is_short(Edge e) const {
    return editor_.length(e) < 0.8 * editor_.wanted_length(e);
  }

  void collapse_short_edges() {
    for (int sweep = 0; sweep < 8; ++sweep) {
      const auto edges = edges_where([&](Edge e) { return is_short(e); });
      int done = 0;
      for (const Edge e : edges)
        if (!mesh_.is_removed(e) && is_short(e)) done += editor_.collapse(e, 4.0 / 3.0) ? 1 : 0;
      if (done == 0 || done < int(edges.size()) / 50) return;
    }
  }

  /// The shortest edge of a bad triangle goes, if that helps.
  void collapse_slivers() {
    const auto is_bad = [&](Edge e) {
      const Halfedge h = mesh_.halfedge(e);
      return is_shortest_of_sliver(h) || is_shortest_of_sliver(mesh_.opposite(h));
    };
    for (const Edge e : edges_where(is_bad))
      if (!mesh_.is_removed(e) && is_bad(e)) editor_.collapse(e, 1.7);
  }

  [[nodiscard]] bool is_shortest_of_sliver(Halfedge h) const {
    if (mesh_.is_border(h)) return false;
    const double own = editor_.length(mesh_.edge(h));
    return own <= editor_.length(mesh_.edge(mesh_.next(h))) &&
           own <= editor_.length(mesh_.edge(mesh_.prev(h))) &&
           editor_.least_sine_squared(mesh_.face(h)) < kSliver;
  }

  void flip_edges(FlipRule rule) {
    for (int sweep = 0; sweep < 3; ++sweep) {
      int done = 0;
      for (const Edge e : mesh_.edges()) {
        if (mesh_.is_border(e) || !editor_.is_free(e)) continue;
        const Halfedge h = mesh_.halfedge(e);
        if ((this->*rule)(h)) done += editor_.flip(h) ? 1 : 0;
      }
      if (done == 0) return;
    }
  }

  [[nodiscard]] bool improves_valence(Halfedge h) const {
    const int gain = editor_.flip_valence_gain(h);
    if (gain < 0) return false;
    const auto [before, after] = editor_.flip_shapes(h);
    return gain > 0 ? after > std::min(kPoor, before) : after > 1.05 * before;
  }
  [[nodiscard]] bool improves_angle(Halfedge h) const {
    const auto [before, after] = editor_.flip_shapes(h);
    return before < kGood && after > 1.0001 * before;
  }

  /// Vertices move to the centres of their stars. The places are found side by side, the moves are
  /// made one after the other, each on condition that the triangles around it stay sound.
  void relax() {
    const auto count =
        std::ptrdiff_t(mesh_.number_of_vertices() + mesh_.number_of_removed_vertices());
    std::vector<Vec3> wishes(static_cast<std::size_t>(count));
    std::vector<Place> places(static_cast<std::size_t>(count));
    parallel_for(count, [&](std::ptrdiff_t i) {
      const auto v = Vertex(unsigned(i));
      if (!moves(v)) return;
      wishes[std::size_t(i)] = editor_.rim(v) >= 0 ? rim_wish(v) : inner_wish(v);
      places[std::size_t(i)] = editor_.place_near(v, wishes[std::size_t(i)]);
    });
    for (const Vertex v : mesh_.vertices()) {
      if (!moves(v)) continue;
      if (editor_.may_move(v, places[v.idx()])) {
        editor_.move(v, places[v.idx()]);
        continue;
      }
      const Vec3 from = editor_.position(v);
      for (const double part : {0.4, 0.0}) {
        const Place place = editor_.place_near(v, from + part * (wishes[v.idx()] - from));
        if (!editor_.may_move(v, place)) continue;
        editor_.move(v, place);
        break;
      }
    }
  }

  [[nodiscard]] bool moves(Vertex v) const {
    return !mesh_.is_removed(v) && !mesh_.is_isolated(v) && editor_.is_free(v);
  }

  [[nodiscard]] Vec3 inner_wish(Vertex v) const {
    Vec3 sum;
    double weight_sum = 0.0;
    const Vec3 own = editor_.position(v);
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
      const Vertex p = mesh_.target(mesh_.next(h));
      const Vertex q = mesh_.source(h);
      const Vec3 x = editor_.position(p);
      const Vec3 y = editor_.position(q);
      const double wanted =
          editor_.wanted_length(v) + editor_.wanted_length(p) + editor_.wanted_length(q);
      const double weight = norm(cross(x - own, y - own)) / (wanted * wanted);
      sum += (weight / 3.0) * (own + x + y);
      weight_sum += weight;
    }
    if (!(weight_sum > 0.0)) return own;
    const Vec3 step = sum / weight_sum - own;
    if (!keeps_tangent_) return own + step;  // a membrane moves along its normal as well
    return own + step - dot(step, editor_.normal(v)) * editor_.normal(v);
  }

  [[nodiscard]] Vec3 rim_wish(Vertex v) const {
    Vec3 sum;
    int count = 0;
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_))
      if (mesh_.is_border(CGAL::edge(h, mesh_))) {
        sum += editor_.position(mesh_.source(h));
        ++count;
      }
    const Vec3 own = editor_.position(v);
    return count == 2 ? own + 0.5 * (0.5 * sum - own) : own;
  }

  SurfaceEditor editor_;
  const SurfaceEditor::Mesh& mesh_;
  bool keeps_tangent_;
};

}  // namespace

double least_angle_degrees(const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::asin(std::sqrt(std::min(1.0, least_sine_squared(a, b, c)))) * 180.0 /
         std::numbers::pi;
}

void remesh(SurfaceDraft& draft, const SurfaceTarget& target, int round_count) {
  Remesher(draft, &target, {}).run(round_count);
}

void remesh_part(SurfaceDraft& draft, const SurfaceTarget& target, const std::vector<char>& free,
                 int round_count) {
  Remesher(draft, &target, free).run(round_count);
}

void remesh_membrane(SurfaceDraft& draft, const std::vector<char>& free, int round_count) {
  Remesher(draft, nullptr, free).run(round_count);
}

}  // namespace angio::meshing::detail
