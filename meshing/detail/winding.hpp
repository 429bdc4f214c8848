#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/triangle_mesh.hpp"

namespace angio::meshing::detail {

/// How often a closed surface winds around a place: 0 outside, 1 inside, 2 where two parts overlap,
/// below 0 inside a part that is inside out. It is counted on straight lines along x, +1 where the
/// line enters and -1 where it leaves. Lines agree at shared edges to the last bit, so that none
/// slips through.
class Winding {
 public:
  /// @param closed  every edge in two triangles that run against each other; must outlive this
  explicit Winding(const TriangleMesh& closed);

  [[nodiscard]] int at(const Vec3& place) const;

  using Crossing = std::pair<double, int>;  ///< x, and the step of the winding number
  /// The least y, from the given one on, whose line (y, z) may cross; infinity if none does.
  [[nodiscard]] double next_line(double y, double z) const;
  /// Crossings of the line (y, z), by ascending x.
  [[nodiscard]] std::vector<Crossing> crossings(double y, double z) const;

 private:
  [[nodiscard]] int bin(double value, int axis) const;
  void visit(double y, double z, const auto& found) const;

  const TriangleMesh& mesh_;
  std::array<double, 2> low_{}, cell_{};  ///< of the bins in y and z
  std::array<int, 2> count_{};
  std::vector<int> first_;      ///< of each bin, into triangles_
  std::vector<int> triangles_;  ///< whose shadow along x touches the bin
};

/// The volume where a closed surface winds around at least so many times: 1 gives the union of its
/// parts, however they cross, 2 what they have in common. Summed over lines a given distance apart,
/// of a large surface so far that they cross it some 200,000 times.
double wound_volume(const TriangleMesh& closed, double line_distance, int least);

/// The volumes [mm^3] of the parts in which the places hang together that a closed surface winds
/// around, the largest first: on such lines, next to each other, that overlap. A neck much thinner
/// than the lines' distance parts them.
std::vector<double> wound_parts(const TriangleMesh& closed, double line_distance);

}  // namespace angio::meshing::detail
