#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "meshing/detail/remesh.hpp"
#include "meshing/detail/triangle_blocks.hpp"

namespace angio::meshing::detail {

/// Where the lumen is to be opened: the inlet first, then the outlets in path order, then the
/// inlets of further trees.
struct LineEnd {
  Vec3 tip;             ///< end point of the line [mm]
  double radius = 0.0;  ///< of the lumen near the end [mm]
  int path = 0;
  bool at_inlet = false;
};
std::vector<LineEnd> line_ends(const CenterlineTree& tree);

/// "the inlet", "outlet 1", ...
std::string name_of_end(int end);

/// The plane normal to the line at a distance [mm] inside its end; its normal leaves the lumen.
Plane plane_near_end(const CenterlineTree& tree, const LineEnd& end, double inset);

/// Distance inside the end at which the lumen has its full width [mm]: where the inscribed sphere
/// no longer shrinks into a rounded or blind tip, at least a quarter of a radius.
double full_width_inset(const CenterlineTree& tree, const LineEnd& end);

/// Cuts vessels open near line ends: what lies beyond the section of a plane around its origin
/// goes, and only that; other branches that the plane meets stay whole.
class EndOpener {
 public:
  /// @param mesh  must outlive the opener and not change
  /// @param tips  line ends; no cut but its own takes a tip away
  EndOpener(const TriangleMesh& mesh, const std::vector<Vec3>& tips);

  enum class Verdict {
    sound,
    no_section,  ///< no closed section of the vessel's size surrounds the plane's origin
    no_end       ///< what lies beyond the section is joined with the rest elsewhere
  };
  /// What a cut would do.
  struct Cut {
    Plane plane;
    int end = 0;
    Verdict verdict = Verdict::no_section;
    double roundness = 0.0;      ///< of the section, 1 for a circle; less if the wall leans over it
    std::vector<int> triangles;  ///< crossed
    std::vector<int> beyond;     ///< vertices that go
  };
  /// @param planes  to examine: origins inside the lumen, normals towards what goes
  /// @param radius  of the lumen there [mm]
  /// @param end     index in `tips`; becomes the rim's index
  /// @return the first sound cut with a round section, otherwise the one with the roundest,
  ///         otherwise a verdict only
  [[nodiscard]] Cut best_cut(const std::vector<Plane>& planes, double radius, int end);
  /// Plans a sound cut.
  void plan(Cut cut);

  /// Carries out the cuts. @param rim  per vertex, -1 or the rim it belongs to; follows the mesh
  void apply(TriangleMesh& mesh, std::vector<int>& rim) const;

 private:
  struct Loop {
    std::vector<int> triangles;
    std::vector<Vec3> points;
  };
  [[nodiscard]] double side(const Plane& plane, int v) const;
  [[nodiscard]] Vec3 crossing(const Plane& plane, int a, int b) const;
  /// The closed sections within a ball, of triangles that have a corner in another one.
  [[nodiscard]] std::vector<Loop> sections(const Plane& plane, const Ball& ball,
                                           const Ball& corners) const;
  [[nodiscard]] Cut examine(const Plane& plane, double radius, int end, const Ball& corners);
  /// Share of the section where the wall does not lean over the cap-to-be.
  [[nodiscard]] double upright_share(const Plane& plane, const std::vector<int>& triangles) const;
  /// Vertices on the far side of a section; none if it separates nothing within `reach`, or
  /// another end's tip.
  [[nodiscard]] std::vector<int> part_beyond(const Plane& plane, const Loop& loop, double reach,
                                             int end);

  const TriangleMesh& mesh_;
  TriangleBlocks blocks_;
  std::vector<int> first_triangle_;    ///< shape [vertex_count + 1], into triangles_around_
  std::vector<int> triangles_around_;  ///< of each vertex
  std::vector<int> tip_vertex_;        ///< nearest to each tip
  std::vector<int> cut_of_;            ///< per triangle, -1: not crossed
  std::vector<char> gone_;             ///< per vertex
  std::vector<char> is_tip_;           ///< per vertex
  std::vector<char> vertex_mark_;      ///< of part_beyond; 0 between calls
  std::vector<char> triangle_mark_;    ///< the same
  std::vector<Cut> cuts_;
};

}  // namespace angio::meshing::detail
