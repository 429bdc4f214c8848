#pragma once

#include <functional>
#include <set>
#include <vector>

#include "air_mesh/air_report.hpp"
#include "air_mesh/tet_topology.hpp"
#include "core/tet_mesh.hpp"

namespace angio::air_mesh {

/// Makes tets where flips do not help; functions that are not there make none.
struct AirMesher {
  /// A mesh of the gap between the surfaces, whose vertices come first, points in the air after
  /// them; without tets where it cannot.
  std::function<TetMesh(const std::vector<Vec3>& x)> whole;
  /// A mesh of what some faces enclose, the given vertices first; without tets where it cannot.
  std::function<TetMesh(const std::vector<Vec3>& x, const std::vector<Triangle>& faces)> hollow;
};

/// The mesh of the gap between surfaces that move.
///
/// After each motion the tets whose quality has fallen, and those that are inverted, are worked on:
/// edge removal and multi-face removal (air_mesh/tet_flips.hpp) as long as they raise the least
/// quality; where a tet stays inverted the hollow of the tets around it is filled anew
/// (air_mesh/tet_refill.hpp), with a point in the air where there is no way without
/// (air_points.hpp), which goes as soon as there is one; where that fails too, the hollow is meshed
/// with as many points as it takes, at last the whole gap. Surfaces and caps keep their triangles.
/// The same motions give the same mesh.
class AdaptiveAir {
 public:
  AdaptiveAir() = default;
  /// @param tets      right-handed; those that are flat, over two triangles of a surface in one
  ///                  plane, may be left out
  /// @param surfaces  triangles of balloon and wall, which must be faces of the gap
  AdaptiveAir(std::vector<Tet> tets, const std::vector<Vec3>& x, std::vector<Triangle> surfaces,
              AirMesher mesher = {});

  /// From now on a mesh is built anew for each motion, and not fitted.
  void rebuild_each_time() { each_time_ = true; }

  /// Fits the mesh to new positions [mm], shape [vertex].
  void follow(const std::vector<Vec3>& x);

  /// Is the gap covered once, by right-handed tets whose outer faces are the surfaces' triangles
  /// and caps? It may end before a rim, and up to half a percent of its volume may be left out
  /// where tets are folded into each other (folds.hpp), as they are where surfaces touch. Those
  /// tets keep their places, and are tets again once the surfaces have parted.
  [[nodiscard]] bool is_whole() const;
  /// With those that are left out.
  [[nodiscard]] const TetTopology& topology() const { return air_; }
  /// The mesh without them.
  [[nodiscard]] std::vector<Tet> tets() const;
  /// Of the surfaces' vertices, then of the points in the air, shape [>= vertex].
  [[nodiscard]] const std::vector<Vec3>& positions() const { return x_; }

  /// The report since the last one.
  AirReport take_report();

 private:
  struct Work {
    double quality;
    int slot;
  };
  struct Point {
    int tet = -1;         ///< one around it; -1: not in use
    double height = 0.0;  ///< over the nearest of the faces around it, when it was placed [mm]
    int resume = 0;       ///< motion at which doing without it is tried next
    int pause = 0;        ///< before the try after that
  };
  void adapt(const std::vector<Vec3>& x);
  void drop();
  bool move_to(const std::vector<Vec3>& x, bool may_fail);
  [[nodiscard]] int inverted_count() const;
  void move_points(const std::vector<Vec3>& before);
  void measure();
  void queue_fallen();
  void improve();
  bool flip(int t);
  void mend_inverted(bool all);
  bool refill_around(int t);
  void mend_folds();
  void fill_folds();
  enum class Bare { at_rims, anywhere };  // what of the surfaces may stay without tets
  bool end_before_cap(const std::vector<int>& tets, Bare bare);
  [[nodiscard]] std::vector<int> tets_at_caps(const std::set<int>& tets) const;
  [[nodiscard]] bool hang_on_caps(std::set<int> tets) const;
  [[nodiscard]] bool is_surface(Triangle face) const;
  bool fill_hollow(const std::vector<int>& hollow);
  [[nodiscard]] std::vector<int> inverted_around(int t) const;
  bool add_point(const std::vector<int>& fold);
  void find_again(int vertex);
  int take_point(const Vec3& at, std::size_t index);
  void remove_points();
  bool put_in_place(const int* old, int old_count, const Tet* fresh, int fresh_count);
  void rebuild_whole();
  void take(const TetMesh& mesh);
  [[nodiscard]] bool is_tangled() const;
  void leave_out_folds();
  void count_volumes();
  [[nodiscard]] double quality_of(const Tet& t) const;
  [[nodiscard]] bool covers_surfaces(const TetTopology& air) const;
  [[nodiscard]] bool ends_where_surfaces_do(const TetTopology& air) const;
  [[nodiscard]] std::vector<Triangle> bare_surfaces(const TetTopology& air) const;

  TetTopology air_;
  std::vector<Triangle> surfaces_;  ///< corners ascending, in ascending order
  AirMesher mesher_;
  std::vector<Vec3> x_;
  std::size_t surface_count_ = 0;  ///< vertices
  std::vector<Point> points_;      ///< shape [x_.size() - surface_count_]
  std::vector<double> quality_;    ///< now, by slot
  std::vector<double> tried_;      ///< when it was last worked on
  std::vector<Work> queue_;
  std::vector<int> left_out_;  ///< slots, ascending
  bool closed_ = false;
  bool each_time_ = false;
  int turn_ = 0;          ///< motions so far
  int built_ = 0;         ///< when a mesh was last built, or tried
  int resume_ = 0;        ///< until then none is, unless the last one has lasted
  int pause_ = 1;         ///< after the next one
  int folds_resume_ = 0;  ///< until then folds are let be in a mesh that is whole
  int folds_pause_ = 1;   ///< after the next attempt
  AirReport report_;
};

}  // namespace angio::air_mesh
