#include "meshing/detail/surface_editor.hpp"

#include <CGAL/boost/graph/Euler_operations.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kLeastNormalCosine = 0.35;
constexpr double kGoodSineSquared = sine_squared_of_degrees(30.0);

/// Does a triangle face the way the target does at its corners?
bool faces_target(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal_sum) {
  const Vec3 n = cross(b - a, c - a);
  const double product = dot(n, normal_sum);
  return product > 0.0 && product * product > kLeastNormalCosine * kLeastNormalCosine *
                                                  norm_squared(n) * norm_squared(normal_sum);
}

SurfaceEditor::Mesh::Point to_point(const Vec3& p) { return {p.x, p.y, p.z}; }

}  // namespace

double least_sine_squared(const Vec3& a, const Vec3& b, const Vec3& c) {
  // The least angle lies opposite to the shortest side: sin = 2 area / (the two longer sides).
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const double ab = norm_squared(u);
  const double ca = norm_squared(v);
  const double bc = norm_squared(c - b);
  const double product = (ab <= bc && ab <= ca) ? bc * ca : (bc <= ca ? ab * ca : ab * bc);
  return product > 0.0 ? norm_squared(cross(u, v)) / product : 0.0;
}

SurfaceEditor::SurfaceEditor(SurfaceDraft& draft, const SurfaceTarget* target,
                             const std::vector<char>& free)
    : draft_(draft), target_(target) {
  for (const Vec3& p : draft.mesh.vertices) mesh_.add_vertex(to_point(p));
  for (const Triangle& t : draft.mesh.triangles)
    if (mesh_.add_face(Vertex(unsigned(t[0])), Vertex(unsigned(t[1])), Vertex(unsigned(t[2]))) ==
        Mesh::null_face())
      throw InternalError("remeshing got a surface that is not manifold");
  length_ = mesh_.add_property_map<Vertex, double>("v:length", 0.0).first;
  level_ = mesh_.add_property_map<Vertex, double>("v:level", 0.0).first;
  rim_ = mesh_.add_property_map<Vertex, int>("v:rim", -1).first;
  origin_ = mesh_.add_property_map<Vertex, int>("v:origin", -1).first;
  free_ = mesh_.add_property_map<Vertex, char>("v:free", 1).first;
  membrane_ = mesh_.add_property_map<Vertex, char>("v:membrane", 0).first;
  normal_ = mesh_.add_property_map<Vertex, Vec3>("v:normal_lps", Vec3{}).first;
  widening_ = mesh_.add_property_map<Vertex, Vec3>("v:widening", Vec3{}).first;
  draft.membrane.resize(draft.mesh.vertices.size(), 0);
  const std::vector<Vec3> widening =
      draft.widening ? draft.widening->at(draft.mesh.vertices) : std::vector<Vec3>{};
  for (const Vertex v : mesh_.vertices()) {
    length_[v] = draft.edge_length[v.idx()];
    rim_[v] = draft.rim[v.idx()];
    membrane_[v] = draft.membrane[v.idx()];
    if (!draft.origin.empty()) origin_[v] = draft.origin[v.idx()];
    if (!free.empty()) free_[v] = free[v.idx()];
    if (!widening.empty()) widening_[v] = widening[v.idx()];
  }
  parallel_for(std::ptrdiff_t(draft.mesh.vertices.size()), [&](std::ptrdiff_t i) {
    const auto v = Vertex(unsigned(i));
    normal_[v] = normal_at(v, position(v));
  });
}

// === What is there ===

SurfaceEditor::Diamond SurfaceEditor::diamond(Halfedge h) const {
  return {mesh_.source(h), mesh_.target(h), mesh_.target(mesh_.next(h)),
          mesh_.target(mesh_.next(mesh_.opposite(h)))};
}

Vec3 SurfaceEditor::star_normal(Vertex v, const Vec3& place) const {
  Vec3 sum;
  for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
    if (mesh_.is_border(h)) continue;
    const Vec3 next = position(mesh_.target(mesh_.next(h)));
    sum += cross(next - place, position(mesh_.source(h)) - place);
  }
  return normalized(sum);
}

Vec3 SurfaceEditor::normal_at(Vertex v, const Vec3& place) const {
  if (!target_ || membrane_[v]) return mesh_.is_isolated(v) ? Vec3{} : star_normal(v, place);
  return target_->evaluate(place).normal;
}

double SurfaceEditor::least_sine_squared(Face f) const {
  const Halfedge h = mesh_.halfedge(f);
  const Vertex a = mesh_.source(h);
  return least_sine_squared(a, position(a), mesh_.target(h), mesh_.target(mesh_.next(h)));
}

double SurfaceEditor::least_sine_squared(Vertex a, const Vec3& place, Vertex b, Vertex c) const {
  const Vec3 w = (1.0 / 3.0) * (widening_[a] + widening_[b] + widening_[c]);
  return detail::least_sine_squared(Vec3{}, shortened(position(b) - place, w),
                                    shortened(position(c) - place, w));
}

double SurfaceEditor::least_sine_squared_around(Vertex v, const Vec3& place) const {
  double least = 1.0;
  for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_))
    if (!mesh_.is_border(h))
      least = std::min(least,
                       least_sine_squared(v, place, mesh_.target(mesh_.next(h)), mesh_.source(h)));
  return least;
}

// === Split ===

void SurfaceEditor::split(Edge e) {
  const Vertex a = mesh_.vertex(e, 0);
  const Vertex b = mesh_.vertex(e, 1);
  const Vec3 middle = 0.5 * (position(a) + position(b));
  const double wanted = wanted_length(e);
  const int rim = mesh_.is_border(e) ? rim_[a] : -1;
  const Halfedge incoming = CGAL::Euler::split_edge(mesh_.halfedge(e), mesh_);
  const Vertex v = mesh_.target(incoming);
  mesh_.point(v) = to_point(middle);
  length_[v] = wanted;
  level_[v] = 0.5 * (level_[a] + level_[b]);
  rim_[v] = rim;
  origin_[v] = -1;
  free_[v] = 1;
  membrane_[v] = membrane_[a] && membrane_[b];
  normal_[v] = normalized(normal_[a] + normal_[b]);
  widening_[v] = 0.5 * (widening_[a] + widening_[b]);
  if (!mesh_.is_border(incoming))
    CGAL::Euler::split_face(incoming, mesh_.next(mesh_.next(incoming)), mesh_);
  const Halfedge other = mesh_.opposite(incoming);
  if (!mesh_.is_border(other)) CGAL::Euler::split_face(mesh_.prev(other), mesh_.next(other), mesh_);
}

// === Collapse ===

std::vector<Vec3> SurfaceEditor::collapse_places(Vertex a, Vertex b) const {
  const bool stays_a = rim_[a] >= 0 || !free_[a];
  const bool stays_b = rim_[b] >= 0 || !free_[b];
  if (stays_a && stays_b && !(free_[a] && free_[b])) return {};
  const Vec3 pa = position(a);
  const Vec3 pb = position(b);
  if (stays_a && !stays_b) return {pa};
  if (stays_b && !stays_a) return {pb};
  return {0.5 * (pa + pb), pa, pb};
}

bool SurfaceEditor::collapse(Edge e, double length_limit, double sine_squared) {
  const Halfedge h = mesh_.halfedge(e);
  const Vertex a = mesh_.source(h);
  const Vertex b = mesh_.target(h);
  if (rim_[a] >= 0 && rim_[b] >= 0 && !mesh_.is_border(e)) return false;
  const std::vector<Vec3> places = collapse_places(a, b);
  if (places.empty() || joins_tied(a, b)) return false;
  const Vec3 normal = normalized(normal_[a] + normal_[b]);
  for (const Vec3& place : places) {
    if (!star_stays_good(a, b, {place, normal}, length_limit, sine_squared) ||
        !star_stays_good(b, a, {place, normal}, length_limit, sine_squared))
      continue;
    if (!CGAL::Euler::does_satisfy_link_condition(e, mesh_)) return false;
    if (mesh_.is_border(e) && border_length_at_most(h, 6)) return false;
    const double wanted = wanted_length(e);
    const double level = 0.5 * (level_[a] + level_[b]);
    const int rim = std::max(rim_[a], rim_[b]);
    const int origin = !free_[a] ? origin_[a] : (free_[b] ? -1 : origin_[b]);
    const char free = free_[a] && free_[b];
    const Vec3 widening = 0.5 * (widening_[a] + widening_[b]);
    const char membrane = membrane_[a] && membrane_[b];
    const Vertex kept = CGAL::Euler::collapse_edge(e, mesh_);
    mesh_.point(kept) = to_point(place);
    length_[kept] = wanted;
    level_[kept] = level;
    rim_[kept] = rim;
    origin_[kept] = origin;
    free_[kept] = free;
    membrane_[kept] = membrane;
    normal_[kept] = normal;
    widening_[kept] = widening;
    return true;
  }
  return false;
}

bool SurfaceEditor::joins_tied(Vertex a, Vertex b) const {
  const bool a_is_tied = !free_[a] || (free_[b] && rim_[a] >= 0);
  const Vertex tied = a_is_tied ? a : b;
  const Vertex moving = a_is_tied ? b : a;
  for (const Vertex v : CGAL::vertices_around_target(mesh_.halfedge(moving), mesh_)) {
    const bool both_tied = !free_[tied] && !free_[v];
    const bool both_on_rim = rim_[tied] >= 0 && rim_[v] == rim_[tied] && rim_[moving] < 0;
    if (v != tied && (both_tied || both_on_rim) && mesh_.halfedge(v, tied) == Mesh::null_halfedge())
      return true;
  }
  return false;
}

bool SurfaceEditor::border_length_at_most(Halfedge h, int limit) const {
  if (!mesh_.is_border(h)) h = mesh_.opposite(h);
  int count = 1;
  for (Halfedge g = mesh_.next(h); g != h && count <= limit; g = mesh_.next(g)) ++count;
  return count <= limit;
}

/// Would the triangles around `v`, without those that also hold `other`, stay sound if v moved?
bool SurfaceEditor::star_stays_good(Vertex v, Vertex other, const Place& place, double length_limit,
                                    double sine_squared) const {
  for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
    if (mesh_.is_border(h)) continue;
    const Vertex p = mesh_.target(mesh_.next(h));
    const Vertex q = mesh_.source(h);
    if (p == other || q == other) continue;
    const Vec3 x = position(p);
    const Vec3 y = position(q);
    const double limit = length_limit * 0.5 * (length_[v] + length_[p]);
    const Vec3 w = 0.5 * (widening_[v] + widening_[p]);
    const double reach_squared = norm_squared(shortened(place.point - x, w));
    if (reach_squared > limit * limit &&
        reach_squared > norm_squared(shortened(position(v) - x, w)))
      return false;
    const Vec3 sides = normal_[p] + normal_[q];
    if (!faces_target(place.point, x, y, place.normal + sides) &&
        faces_target(position(v), x, y, normal_[v] + sides))
      return false;
    const double before = least_sine_squared(v, position(v), p, q);
    const double after = least_sine_squared(v, place.point, p, q);
    if (after < std::max(sine_squared, std::min(0.5 * before, kept_sine_squared_))) return false;
  }
  return true;
}

// === Flip ===

bool SurfaceEditor::can_flip(Halfedge h) const {
  const auto [a, b, c, d] = diamond(h);
  if ((rim_[c] >= 0 && rim_[d] >= 0) || (!free_[c] && !free_[d])) return false;
  const Vec3 pa = position(a), pb = position(b), pc = position(c), pd = position(d);
  return faces_target(pa, pd, pc, normal_[a] + normal_[d] + normal_[c]) &&
         faces_target(pd, pb, pc, normal_[d] + normal_[b] + normal_[c]) && mesh_.degree(a) > 3 &&
         mesh_.degree(b) > 3 && mesh_.halfedge(c, d) == Mesh::null_halfedge();
}

bool SurfaceEditor::flip(Halfedge h) {
  if (!can_flip(h)) return false;
  CGAL::Euler::flip_edge(h, mesh_);
  return true;
}

SurfaceEditor::Shapes SurfaceEditor::flip_shapes(Halfedge h) const {
  const auto [a, b, c, d] = diamond(h);
  const auto shape = [this](Vertex p, Vertex q, Vertex r) {
    return least_sine_squared(p, position(p), q, r);
  };
  return {std::min(shape(a, b, c), shape(b, a, d)), std::min(shape(a, d, c), shape(d, b, c))};
}

int SurfaceEditor::excess(Vertex v, int change) const {
  const int degree = int(mesh_.degree(v)) + change;
  return std::abs(degree - (rim_[v] >= 0 ? 4 : 6));
}

int SurfaceEditor::flip_valence_gain(Halfedge h) const {
  const auto [a, b, c, d] = diamond(h);
  const int before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
  const int after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
  return before - after;
}

// === Move ===

SurfaceEditor::Place SurfaceEditor::place_near(Vertex v, const Vec3& point) const {
  if (rim_[v] >= 0) {
    const Plane& plane = draft_.rim_planes[std::size_t(rim_[v])];
    const Vec3 flat = point - plane.signed_distance(point) * plane.normal;
    return target_ ? target_->project_in_plane(flat, plane.normal, 0.5 * length_[v], level_[v])
                   : Place{position(v), normal_[v]};
  }
  if (target_ && !membrane_[v]) return target_->project(point, 0.5 * length_[v], level_[v]);
  return {point, star_normal(v, point)};
}

bool SurfaceEditor::may_move(Vertex v, const Place& place) const {
  const Vec3 from = position(v);
  for (const Halfedge h : CGAL::halfedges_around_target(v, mesh_)) {
    if (mesh_.is_border(h)) continue;
    const Vertex p = mesh_.target(mesh_.next(h));
    const Vertex q = mesh_.source(h);
    const Vec3 x = position(p);
    const Vec3 y = position(q);
    const Vec3 sides = normal_[p] + normal_[q];
    if (!faces_target(place.point, x, y, place.normal + sides) &&
        faces_target(from, x, y, normal_[v] + sides))
      return false;
    const double after = least_sine_squared(v, place.point, p, q);
    if (after < kGoodSineSquared && after < kept_sine_squared_ &&
        after < least_sine_squared(v, from, p, q) - 1e-9)
      return false;
  }
  return true;
}

void SurfaceEditor::move(Vertex v, const Place& place) {
  mesh_.point(v) = to_point(place.point);
  normal_[v] = place.normal;
}

void SurfaceEditor::keep_levels() {
  if (!target_) return;
  parallel_for(std::ptrdiff_t(mesh_.num_vertices()), [&](std::ptrdiff_t i) {
    const auto v = Vertex(unsigned(i));
    level_[v] = target_->evaluate(position(v)).signed_distance;
  });
}

// === Result ===

void SurfaceEditor::store() {
  mesh_.collect_garbage();
  draft_.mesh = {};
  draft_.edge_length.clear();
  draft_.rim.clear();
  draft_.membrane.clear();
  const bool keeps_origin = !draft_.origin.empty();
  draft_.origin.clear();
  std::vector<int> index(mesh_.number_of_vertices(), -1);
  for (const Vertex v : mesh_.vertices()) {
    if (mesh_.is_isolated(v)) continue;
    index[v.idx()] = int(draft_.mesh.vertices.size());
    draft_.mesh.vertices.push_back(position(v));
    draft_.edge_length.push_back(length_[v]);
    draft_.rim.push_back(rim_[v]);
    draft_.membrane.push_back(membrane_[v]);
    if (keeps_origin) draft_.origin.push_back(origin_[v]);
  }
  for (const Face f : mesh_.faces()) {
    const Halfedge h = mesh_.halfedge(f);
    draft_.mesh.triangles.push_back({index[mesh_.source(h).idx()], index[mesh_.target(h).idx()],
                                     index[mesh_.target(mesh_.next(h)).idx()]});
  }
}

}  // namespace angio::meshing::detail
