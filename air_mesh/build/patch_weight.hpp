#pragma once

#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include <vector>

/// CGAL's way to fill a hole, such that the same hole is filled by the same triangles on every run.
///
/// CGAL's own search takes the first of equally good patches in an order that goes by the addresses
/// of its cells in memory, which differ from run to run. Here the patch with the lower corners is
/// taken.
namespace angio::air_mesh {

/// CGAL's weight of a patch (its sharpest fold, then its area) and the corner that its last
/// triangle adds to its first and last, which decides between patches of equal weight.
class PatchWeight {
 public:
  using Weight = CGAL::internal::Weight_min_max_dihedral_and_area;

  PatchWeight(const Weight& weight, int corner) : weight_(weight), corner_(corner) {}
  static PatchWeight DEFAULT() { return {Weight::DEFAULT(), -1}; }      // NOLINT: CGAL's names
  static PatchWeight NOT_VALID() { return {Weight::NOT_VALID(), -1}; }  // NOLINT
  friend PatchWeight operator+(const PatchWeight& patch, const PatchWeight& added) {
    return {patch.weight_ + added.weight_, added.corner_};
  }
  friend bool operator<(const PatchWeight& a, const PatchWeight& b) {
    return a.weight_ == b.weight_ ? a.corner_ < b.corner_ : a.weight_ < b.weight_;
  }
  friend bool operator==(const PatchWeight& a, const PatchWeight& b) {
    return a.weight_ == b.weight_;
  }

 private:
  Weight weight_;
  int corner_;
};

/// @tparam IsValid  which of the triangles may be used
template <class IsValid>
class PatchWeights {
 public:
  using Weight = PatchWeight;

  explicit PatchWeights(const IsValid& is_valid) : weigh_(is_valid) {}
  template <class Point, class Table>
  PatchWeight operator()(const std::vector<Point>& loop, const std::vector<Point>& across, int i,
                         int j, int k, const Table& table) const {
    return {weigh_(loop, across, i, j, k, table), j};
  }

 private:
  CGAL::internal::Weight_calculator<PatchWeight::Weight, IsValid> weigh_;
};

/// @param loop    points in order
/// @param across  the third corner of the triangle at each side of the loop; or empty
/// @param tracer  takes the triangles, as CGAL's do
template <class Kernel, class Tracer, class IsValid>
void fill_loop(const std::vector<typename Kernel::Point_3>& loop,
               const std::vector<typename Kernel::Point_3>& across, const IsValid& is_valid,
               Tracer& tracer) {
  CGAL::Polygon_mesh_processing::Hole_filling::Default_visitor visitor;
  constexpr bool kWithDelaunay = true, kWithoutAllOthers = false;
  CGAL::internal::triangulate_hole_polyline(loop, across, tracer, PatchWeights<IsValid>(is_valid),
                                            visitor, kWithDelaunay, kWithoutAllOthers, Kernel());
}

}  // namespace angio::air_mesh
