#include "meshing/detail/remesh.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace angio::meshing::detail {
namespace {

using Mesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;
using Vertex = Mesh::Vertex_index;
using Edge = Mesh::Edge_index;
using Halfedge = Mesh::Halfedge_index;
using Face = Mesh::Face_index;

constexpr double kLeastNormalCosine = 0.35;
constexpr double kGoodAngle = 30.0;  // [degrees] below it, the last rounds try to improve

class Remesher {
 public:
  Remesher(SurfaceDraft& draft, const SurfaceTarget& target) : Remesher(draft, &target, {}) {}
  Remesher(SurfaceDraft& draft, const std::vector<char>& loose) : Remesher(draft, nullptr, loose) {}

  void run(int round_count) {
    collapse_short_edges();  // the raw surface is far too fine; thin it before anything else
    for (int round = 0; round < round_count; ++round) {
      split_long_edges();
      collapse_short_edges();
      flip_edges(&Remesher::improves_valence);
      relax();
      relax();
    }
    kept_angle_ = 22.0;
    for (int round = 0; round < 4; ++round) {
      flip_edges(&Remesher::improves_angle);
      collapse_slivers();
      relax();
    }
    flip_edges(&Remesher::improves_angle);
    store();
  }

 private:
  using FlipRule = bool (Remesher::*)(Halfedge) const;

  Remesher(SurfaceDraft& draft, const SurfaceTarget* target, const std::vector<char>& loose)
      : draft_(draft), target_(target) {
    for (const Vec3& p : draft.mesh.vertices) mesh_.add_vertex(to_point(p));
    for (const Triangle& t : draft.mesh.triangles)
      if (mesh_.add_face(Vertex(unsigned(t[0])), Vertex(unsigned(t[1])), Vertex(unsigned(t[2]))) ==
          Mesh::null_face())
        throw InternalError("remeshing got a surface that is not manifold");
    length_ = mesh_.add_property_map<Vertex, double>("v:length", 0.0).first;
    rim_ = mesh_.add_property_map<Vertex, int>("v:rim", -1).first;
    free_ = mesh_.add_property_map<Vertex, char>("v:free", 1).first;
    normal_ = mesh_.add_property_map<Vertex, Vec3>("v:normal_lps", Vec3{}).first;
    for (const Vertex v : mesh_.vertices()) {
      length_[v] = draft.edge_length[v.idx()];
      rim_[v] = draft.rim[v.idx()];
      if (!target) free_[v] = loose[v.idx()];
    }
    for (const Vertex v : mesh_.vertices()) normal_[v] = normal_at(v, position(v));
  }

  /// Of the target; of the surface itself where there is none.
  [[nodiscard]] Vec3 normal_at(Vertex v, const Vec3& place) const {
    if (target_) return target_->evaluate(place).normal;
    Vec3 sum;
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
      if (mesh_.is_border(h)) continue;
      const Vec3 next = position(mesh_.target(mesh_.next(h)));
      sum += cross(next - place, position(mesh_.source(h)) - place);
    }
    return normalized(sum);
  }

  [[nodiscard]] bool is_free(Edge e) const {
    return free_[mesh_.vertex(e, 0)] || free_[mesh_.vertex(e, 1)];
  }
  static Mesh::Point to_point(const Vec3& p) { return {p.x, p.y, p.z}; }
  [[nodiscard]] Vec3 position(Vertex v) const {
    const Mesh::Point& p = mesh_.point(v);
    return {p.x(), p.y(), p.z()};
  }
  [[nodiscard]] double length(Edge e) const {
    return distance(position(mesh_.vertex(e, 0)), position(mesh_.vertex(e, 1)));
  }
  [[nodiscard]] double wanted_length(Edge e) const {
    return 0.5 * (length_[mesh_.vertex(e, 0)] + length_[mesh_.vertex(e, 1)]);
  }
  [[nodiscard]] std::vector<Edge> edges_where(auto&& condition) const {
    std::vector<Edge> edges;
    for (const Edge e : mesh_.edges())
      if (is_free(e) && condition(e)) edges.push_back(e);
    return edges;
  }

  /// Does a triangle face the way the target does at its corners?
  static bool faces_target(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal_sum) {
    const Vec3 n = cross(b - a, c - a);
    return dot(n, normal_sum) > kLeastNormalCosine * norm(n) * norm(normal_sum);
  }

  // === Split ===

  void split_long_edges() {
    for (int sweep = 0; sweep < 4; ++sweep) {
      const auto edges =
          edges_where([&](Edge e) { return length(e) > 4.0 / 3.0 * wanted_length(e); });
      if (edges.empty()) return;
      for (const Edge e : edges) split(e);
    }
  }

  void split(Edge e) {
    const Vertex a = mesh_.vertex(e, 0);
    const Vertex b = mesh_.vertex(e, 1);
    const Vec3 middle = 0.5 * (position(a) + position(b));
    const double wanted = wanted_length(e);
    const int rim = mesh_.is_border(e) ? rim_[a] : -1;
    const Halfedge incoming = CGAL::Euler::split_edge(mesh_.halfedge(e), mesh_);
    const Vertex v = mesh_.target(incoming);
    mesh_.point(v) = to_point(middle);
    length_[v] = wanted;
    rim_[v] = rim;
    free_[v] = 1;
    normal_[v] = normalized(normal_[a] + normal_[b]);
    if (!mesh_.is_border(incoming))
      CGAL::Euler::split_face(incoming, mesh_.next(mesh_.next(incoming)), mesh_);
    const Halfedge other = mesh_.opposite(incoming);
    if (!mesh_.is_border(other))
      CGAL::Euler::split_face(mesh_.prev(other), mesh_.next(other), mesh_);
  }

  // === Collapse ===

  void collapse_short_edges() {
    for (int sweep = 0; sweep < 8; ++sweep) {
      const auto edges = edges_where([&](Edge e) { return length(e) < 0.8 * wanted_length(e); });
      int done = 0;
      for (const Edge e : edges) {
        if (mesh_.is_removed(e) || length(e) >= 0.8 * wanted_length(e)) continue;
        done += collapse(e, 4.0 / 3.0) ? 1 : 0;
      }
      if (done == 0 || done < int(edges.size()) / 50) return;
    }
  }

  /// The shortest edge of a bad triangle goes, if that helps.
  void collapse_slivers() {
    const auto edges = edges_where([&](Edge e) {
      const Halfedge h = mesh_.halfedge(e);
      return is_shortest_of_sliver(h) || is_shortest_of_sliver(mesh_.opposite(h));
    });
    for (const Edge e : edges) {
      if (mesh_.is_removed(e)) continue;
      const Halfedge h = mesh_.halfedge(e);
      if (is_shortest_of_sliver(h) || is_shortest_of_sliver(mesh_.opposite(h))) collapse(e, 1.7);
    }
  }

  [[nodiscard]] bool is_shortest_of_sliver(Halfedge h) const {
    if (mesh_.is_border(h)) return false;
    const Vec3 a = position(mesh_.source(h));
    const Vec3 b = position(mesh_.target(h));
    const Vec3 c = position(mesh_.target(mesh_.next(h)));
    const double own = distance(a, b);
    return own <= distance(b, c) && own <= distance(c, a) && least_angle_degrees(a, b, c) < 25.0;
  }

  bool collapse(Edge e, double length_limit) {
    Halfedge h = mesh_.halfedge(e);
    const Vertex a = mesh_.source(h);
    const Vertex b = mesh_.target(h);
    if (rim_[a] >= 0 && rim_[b] >= 0 && !mesh_.is_border(e)) return false;
    const bool stays_a = rim_[a] >= 0 || !free_[a];
    const bool stays_b = rim_[b] >= 0 || !free_[b];
    if (stays_a && stays_b && !(free_[a] && free_[b])) return false;
    if (!CGAL::Euler::does_satisfy_link_condition(e, mesh_)) return false;
    if (mesh_.is_border(e) && border_length_at_most(h, 6)) return false;
    const Vec3 pa = position(a);
    const Vec3 pb = position(b);
    std::vector<Vec3> places;
    if (stays_a && !stays_b)
      places = {pa};
    else if (stays_b && !stays_a)
      places = {pb};
    else
      places = {0.5 * (pa + pb), pa, pb};
    const Vec3 normal = normalized(normal_[a] + normal_[b]);
    const double wanted = wanted_length(e);
    for (const Vec3& place : places) {
      if (!star_stays_good(a, b, place, normal, length_limit) ||
          !star_stays_good(b, a, place, normal, length_limit))
        continue;
      const int rim = std::max(rim_[a], rim_[b]);
      const char is_free_after = free_[a] && free_[b];
      const Vertex kept = CGAL::Euler::collapse_edge(e, mesh_);
      mesh_.point(kept) = to_point(place);
      length_[kept] = wanted;
      rim_[kept] = rim;
      free_[kept] = is_free_after;
      normal_[kept] = normal;
      return true;
    }
    return false;
  }

  [[nodiscard]] bool border_length_at_most(Halfedge h, int limit) const {
    if (!mesh_.is_border(h)) h = mesh_.opposite(h);
    int count = 1;
    for (Halfedge g = mesh_.next(h); g != h && count <= limit; g = mesh_.next(g)) ++count;
    return count <= limit;
  }

  /// Would the triangles around `v`, without those that also hold `other`, stay sound if v moved?
  [[nodiscard]] bool star_stays_good(Vertex v, Vertex other, const Vec3& place, const Vec3& normal,
                                     double length_limit) const {
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
      if (mesh_.is_border(h)) continue;
      const Vertex p = mesh_.target(mesh_.next(h));
      const Vertex q = mesh_.source(h);
      if (p == other || q == other) continue;
      const Vec3 x = position(p);
      const Vec3 y = position(q);
      const double limit = length_limit * 0.5 * (length_[v] + length_[p]);
      const double reach = distance(place, x);
      if (reach > limit && reach > distance(position(v), x)) return false;
      const Vec3 sides = normal_[p] + normal_[q];
      if (!faces_target(place, x, y, normal + sides) &&
          faces_target(position(v), x, y, normal_[v] + sides))
        return false;
      const double before = least_angle_degrees(position(v), x, y);
      if (least_angle_degrees(place, x, y) < std::min(0.7 * before, kept_angle_)) return false;
    }
    return true;
  }

  // === Flip ===

  void flip_edges(FlipRule rule) {
    for (int sweep = 0; sweep < 3; ++sweep) {
      int done = 0;
      for (const Edge e : mesh_.edges()) {
        if (mesh_.is_border(e) || !is_free(e)) continue;
        const Halfedge h = mesh_.halfedge(e);
        if (!can_flip(h) || !(this->*rule)(h)) continue;
        CGAL::Euler::flip_edge(h, mesh_);
        ++done;
      }
      if (done == 0) return;
    }
  }

  struct Diamond {
    Vertex a, b, c, d;  ///< edge a-b with c to its left and d to its right
  };
  [[nodiscard]] Diamond diamond(Halfedge h) const {
    return {mesh_.source(h), mesh_.target(h), mesh_.target(mesh_.next(h)),
            mesh_.target(mesh_.next(mesh_.opposite(h)))};
  }

  [[nodiscard]] bool can_flip(Halfedge h) const {
    const auto [a, b, c, d] = diamond(h);
    if (mesh_.halfedge(c, d) != Mesh::null_halfedge()) return false;
    if (mesh_.degree(a) <= 3 || mesh_.degree(b) <= 3) return false;
    if (rim_[c] >= 0 && rim_[d] >= 0) return false;
    const Vec3 pa = position(a), pb = position(b), pc = position(c), pd = position(d);
    return faces_target(pa, pd, pc, normal_[a] + normal_[d] + normal_[c]) &&
           faces_target(pd, pb, pc, normal_[d] + normal_[b] + normal_[c]);
  }

  struct Angles {
    double before, after;
  };
  [[nodiscard]] Angles flip_angles(Halfedge h) const {
    const auto [a, b, c, d] = diamond(h);
    const Vec3 pa = position(a), pb = position(b), pc = position(c), pd = position(d);
    return {std::min(least_angle_degrees(pa, pb, pc), least_angle_degrees(pb, pa, pd)),
            std::min(least_angle_degrees(pa, pd, pc), least_angle_degrees(pd, pb, pc))};
  }
  [[nodiscard]] int excess(Vertex v, int change) const {
    const int degree = int(mesh_.degree(v)) + change;
    return std::abs(degree - (rim_[v] >= 0 ? 4 : 6));
  }

  [[nodiscard]] bool improves_valence(Halfedge h) const {
    const auto [a, b, c, d] = diamond(h);
    const int before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
    const int after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
    const Angles angles = flip_angles(h);
    if (after < before) return angles.after > std::min(15.0, angles.before);
    return after == before && angles.after > angles.before + 1.0;
  }
  [[nodiscard]] bool improves_angle(Halfedge h) const {
    const Angles angles = flip_angles(h);
    return angles.before < kGoodAngle && angles.after > angles.before + 1e-6;
  }

  // === Move ===

  void relax() {
    for (const Vertex v : mesh_.vertices()) {
      if (mesh_.is_isolated(v) || !free_[v]) continue;
      const Vec3 from = position(v);
      const Vec3 wish = rim_[v] >= 0 ? rim_wish(v) : inner_wish(v);
      for (const double part : {1.0, 0.4, 0.0}) {
        const Vec3 to = onto_target(v, from + part * (wish - from));
        const Vec3 normal = normal_at(v, to);
        if (!move_is_good(v, to, normal)) continue;
        mesh_.point(v) = to_point(to);
        normal_[v] = normal;
        break;
      }
    }
  }

  [[nodiscard]] Vec3 onto_target(Vertex v, const Vec3& point) const {
    if (!target_) return rim_[v] < 0 ? point : position(v);
    const double limit = 0.5 * length_[v];
    if (rim_[v] < 0) return target_->project(point, limit);
    const Plane& plane = draft_.rim_planes[std::size_t(rim_[v])];
    const Vec3 flat = point - plane.signed_distance(point) * plane.normal;
    return target_->project_in_plane(flat, plane.normal, limit);
  }

  [[nodiscard]] Vec3 inner_wish(Vertex v) const {
    Vec3 sum;
    double weight_sum = 0.0;
    const Vec3 own = position(v);
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
      const Vertex p = mesh_.target(mesh_.next(h));
      const Vertex q = mesh_.source(h);
      const Vec3 x = position(p);
      const Vec3 y = position(q);
      const double wanted = length_[v] + length_[p] + length_[q];
      const double weight = norm(cross(x - own, y - own)) / (wanted * wanted);
      sum += (weight / 3.0) * (own + x + y);
      weight_sum += weight;
    }
    if (!(weight_sum > 0.0)) return own;
    const Vec3 step = sum / weight_sum - own;
    if (!target_) return own + step;  // a membrane moves along its normal as well
    return own + step - dot(step, normal_[v]) * normal_[v];
  }

  [[nodiscard]] Vec3 rim_wish(Vertex v) const {
    Vec3 sum;
    int count = 0;
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_))
      if (mesh_.is_border(CGAL::edge(h, mesh_))) {
        sum += position(mesh_.source(h));
        ++count;
      }
    const Vec3 own = position(v);
    return count == 2 ? own + 0.5 * (0.5 * sum - own) : own;
  }

  [[nodiscard]] bool move_is_good(Vertex v, const Vec3& to, const Vec3& normal) const {
    const Vec3 from = position(v);
    for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
      if (mesh_.is_border(h)) continue;
      const Vertex p = mesh_.target(mesh_.next(h));
      const Vertex q = mesh_.source(h);
      const Vec3 x = position(p);
      const Vec3 y = position(q);
      const Vec3 sides = normal_[p] + normal_[q];
      if (!faces_target(to, x, y, normal + sides) && faces_target(from, x, y, normal_[v] + sides))
        return false;
      const double after = least_angle_degrees(to, x, y);
      if (after < kGoodAngle && after < least_angle_degrees(from, x, y) - 1e-9) {
        if (after < kept_angle_) return false;
      }
    }
    return true;
  }

  // === Result ===

  void store() {
    mesh_.collect_garbage();
    draft_.mesh = {};
    draft_.edge_length.clear();
    draft_.rim.clear();
    std::vector<int> index(mesh_.number_of_vertices(), -1);
    for (const Vertex v : mesh_.vertices()) {
      if (mesh_.is_isolated(v)) continue;
      index[v.idx()] = int(draft_.mesh.vertices.size());
      draft_.mesh.vertices.push_back(position(v));
      draft_.edge_length.push_back(length_[v]);
      draft_.rim.push_back(rim_[v]);
    }
    for (const Face f : mesh_.faces()) {
      const Halfedge h = mesh_.halfedge(f);
      draft_.mesh.triangles.push_back({index[mesh_.source(h).idx()], index[mesh_.target(h).idx()],
                                       index[mesh_.target(mesh_.next(h)).idx()]});
    }
  }

  SurfaceDraft& draft_;
  const SurfaceTarget* target_;  ///< none: a membrane
  Mesh mesh_;
  double kept_angle_ = 2.0;  ///< [degrees] no step goes below it but from a worse start
  Mesh::Property_map<Vertex, double> length_;
  Mesh::Property_map<Vertex, int> rim_;
  Mesh::Property_map<Vertex, char> free_;  ///< may move
  Mesh::Property_map<Vertex, Vec3> normal_;
};

}  // namespace

double least_angle_degrees(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double ab = norm_squared(b - a);
  const double bc = norm_squared(c - b);
  const double ca = norm_squared(a - c);
  // The least angle lies opposite to the shortest side.
  const double shortest = std::min({ab, bc, ca});
  const double sum = ab + bc + ca - shortest;
  const double product = (shortest == ab ? bc * ca : shortest == bc ? ab * ca : ab * bc);
  if (!(product > 0.0)) return 0.0;
  const double cosine = std::clamp((sum - shortest) / (2.0 * std::sqrt(product)), -1.0, 1.0);
  return std::acos(cosine) * 180.0 / std::numbers::pi;
}

void remesh(SurfaceDraft& draft, const SurfaceTarget& target, int round_count) {
  Remesher(draft, target).run(round_count);
}

void remesh_membrane(SurfaceDraft& draft, const std::vector<char>& loose, int round_count) {
  Remesher(draft, loose).run(round_count);
}

}  // namespace angio::meshing::detail
