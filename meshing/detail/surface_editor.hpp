#pragma once

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <vector>

#include "core/vec3.hpp"
#include "meshing/detail/remesh.hpp"

namespace angio::meshing::detail {

/// Squared sine of a triangle's least angle, in [0, 3/4]; it grows with the angle and needs no
/// root.
double least_sine_squared(const Vec3& a, const Vec3& b, const Vec3& c);
constexpr double sine_squared_of_degrees(double degrees) {
  // sin^2 x = (1 - cos 2x) / 2; the series is exact to 1e-9 up to 60 degrees.
  const double y = degrees * 2.0 * 3.14159265358979323846 / 180.0;
  double term = 1.0;
  double cosine = 1.0;
  for (int n = 1; n <= 10; ++n) {
    term *= -y * y / double((2 * n - 1) * (2 * n));
    cosine += term;
  }
  return 0.5 * (1.0 - cosine);
}

/// A draft as half-edges, with the single steps of remeshing: each is refused where it would turn
/// a triangle away from the surface, spoil the angles around it, or leave a rim's plane.
class SurfaceEditor {
 public:
  using Mesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;
  using Vertex = Mesh::Vertex_index;
  using Edge = Mesh::Edge_index;
  using Halfedge = Mesh::Halfedge_index;
  using Face = Mesh::Face_index;

  /// @param target  null: normals are those of the surface itself, inner vertices move freely
  /// @param free    per vertex, which may move; empty: all
  SurfaceEditor(SurfaceDraft& draft, const SurfaceTarget* target, const std::vector<char>& free);

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const SurfaceDraft& draft() const { return draft_; }
  [[nodiscard]] Vec3 position(Vertex v) const {
    const Mesh::Point& p = mesh_.point(v);
    return {p.x(), p.y(), p.z()};
  }
  [[nodiscard]] bool is_free(Vertex v) const { return free_[v] != 0; }
  [[nodiscard]] bool is_free(Edge e) const {
    return free_[mesh_.vertex(e, 0)] || free_[mesh_.vertex(e, 1)];
  }
  [[nodiscard]] int rim(Vertex v) const { return rim_[v]; }
  [[nodiscard]] Vec3 normal(Vertex v) const { return normal_[v]; }
  [[nodiscard]] double wanted_length(Vertex v) const { return length_[v]; }
  [[nodiscard]] double wanted_length(Edge e) const {
    return 0.5 * (length_[mesh_.vertex(e, 0)] + length_[mesh_.vertex(e, 1)]);
  }
  /// As it counts where the lumen will be widened, as all lengths and angles here do.
  [[nodiscard]] double length(Edge e) const {
    const Vertex a = mesh_.vertex(e, 0), b = mesh_.vertex(e, 1);
    return norm(shortened(position(a) - position(b), 0.5 * (widening_[a] + widening_[b])));
  }
  /// Of a triangle of these corners as if the first lay at `place`.
  [[nodiscard]] double least_sine_squared(Vertex a, const Vec3& place, Vertex b, Vertex c) const;
  [[nodiscard]] double least_sine_squared(Face f) const;
  /// Of the triangles around a vertex as if it lay at `place`.
  [[nodiscard]] double least_sine_squared_around(Vertex v, const Vec3& place) const;

  /// No step goes below this angle but from a worse start.
  void keep_angle(double degrees) { kept_sine_squared_ = sine_squared_of_degrees(degrees); }

  void split(Edge e);
  /// Collapses an edge into its middle or one of its ends.
  ///
  /// @param length_limit    edges get no longer than this times the wanted length
  /// @param sine_squared    least shape that every triangle around the new vertex must have
  bool collapse(Edge e, double length_limit, double sine_squared = 0.0);
  bool flip(Halfedge h);  ///< if sound

  struct Shapes {
    double before, after;  ///< least_sine_squared of the two triangles at an edge
  };
  [[nodiscard]] Shapes flip_shapes(Halfedge h) const;
  /// Change of the sum of |valence - ideal| over the four corners.
  [[nodiscard]] int flip_valence_gain(Halfedge h) const;
  [[nodiscard]] bool can_flip(Halfedge h) const;

  using Place = SurfaceTarget::Place;
  /// The place on the target (at the vertex's own level of it) that is nearest to a point.
  [[nodiscard]] Place place_near(Vertex v, const Vec3& point) const;
  [[nodiscard]] bool may_move(Vertex v, const Place& place) const;
  void move(Vertex v, const Place& place);
  /// From now on vertices keep the signed distance from the target that they have now.
  void keep_levels();

  /// Writes the result into the draft.
  void store();

 private:
  struct Diamond {
    Vertex a, b, c, d;  ///< edge a-b with c to its left and d to its right
  };
  [[nodiscard]] Diamond diamond(Halfedge h) const;
  [[nodiscard]] Vec3 star_normal(Vertex v, const Vec3& place) const;
  [[nodiscard]] Vec3 normal_at(Vertex v, const Vec3& place) const;
  [[nodiscard]] std::vector<Vec3> collapse_places(Vertex a, Vertex b) const;
  /// Would a collapse join two vertices by a new edge that are not free, or on one rim? They may be
  /// joined already outside of what is edited, or by a cap.
  [[nodiscard]] bool joins_tied(Vertex a, Vertex b) const;
  [[nodiscard]] bool star_stays_good(Vertex v, Vertex other, const Place& place,
                                     double length_limit, double sine_squared) const;
  [[nodiscard]] bool border_length_at_most(Halfedge h, int limit) const;
  [[nodiscard]] int excess(Vertex v, int change) const;

  SurfaceDraft& draft_;
  const SurfaceTarget* target_;  ///< null: a membrane
  Mesh mesh_;
  double kept_sine_squared_ = sine_squared_of_degrees(2.0);
  Mesh::Property_map<Vertex, double> length_;
  Mesh::Property_map<Vertex, double> level_;  ///< signed distance from the target that is kept
  Mesh::Property_map<Vertex, int> rim_;
  Mesh::Property_map<Vertex, int> origin_;
  Mesh::Property_map<Vertex, char> free_;      ///< may move
  Mesh::Property_map<Vertex, char> membrane_;  ///< need not lie on the target
  Mesh::Property_map<Vertex, Vec3> normal_;
  Mesh::Property_map<Vertex, Vec3> widening_;  ///< Widening::at
};

}  // namespace angio::meshing::detail
