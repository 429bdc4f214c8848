#pragma once

#include <cstddef>
#include <vector>

#include "simulation/contact/box_grid.hpp"
#include "simulation/contact/wire_gap.hpp"
#include "simulation/materials/rod.hpp"
#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// The guidewire where it is no body of its own: drawn as the curve of least bending energy inside
/// the membrane, which it does not push. Its ends are the poles, and it leaves them in the
/// direction that it has there at the start.
///
///     E = sum EI |kb|^2 / l + sum EA (l / l0 - 1)^2 l0 / 2 + sum k A b(d),   EA = 4 pi^2 EI / L^2
///
/// with the rod's terms (rod.hpp), and the barrier b (contact_force.hpp) over the gaps d between
/// segments and triangles of area A, below the wire's diameter: where there is room its surface,
/// too, is inside; in a membrane that lies flatter than the wire is thick its axis is in the
/// middle. EA is Euler's load between clamped ends: a neck that slides back does not buckle the
/// wire, and a bend by an angle a lengthens it by a^2 / (8 pi^2), 3 % at a right angle.
///
/// From frame to frame the wire is taken along by the membrane around it, then settles. Both
/// motions stop before any gap is closed, so that it stays inside, however the membrane folds.
/// Where it cannot follow (a membrane that begins in a place where the wire is not inside) it goes
/// along without settling.
class DrawnWire {
 public:
  /// @param model  its guidewire has no nodes: none is drawn
  DrawnWire(const SimulationModel& model, const GuidewireOptions& options);

  /// The wire in the next frame.
  /// @param balloon  positions [mm], in the model's numbering
  std::vector<Vec3> follow(const std::vector<Vec3>& balloon);

 private:
  void move_membrane(std::vector<Vec3> to);
  /// Around each segment on its way, larger by `reach`; those beyond the poles are empty.
  [[nodiscard]] std::vector<Box> segment_boxes(double reach,
                                               const std::vector<Vec3>& wire_by) const;
  /// Segments and triangles whose boxes meet, but for those that meet in a pole.
  [[nodiscard]] std::vector<WirePair> pairs_of(const std::vector<Box>& segments,
                                               const std::vector<Box>& membrane) const;
  /// Those of the wire on its way and the membrane as it lies.
  [[nodiscard]] std::vector<WirePair> pairs_within(double reach, const std::vector<Vec3>& wire_by);
  /// How far the wire gets along its way, with the membrane as it lies.
  [[nodiscard]] double share_of(const std::vector<Vec3>& wire_by);
  [[nodiscard]] double share_of(const std::vector<Vec3>& wire_by,
                                const std::vector<Vec3>& membrane_by) const;
  [[nodiscard]] double share_of(const WireMotion& motion, const std::vector<WirePair>& pairs) const;
  /// A triangle that bears a segment.
  struct Bearing {
    std::size_t segment;
    WireGap gap;  ///< below the barrier's range
    double area;  ///< of the triangle [mm^2]
  };
  [[nodiscard]] std::vector<Bearing> bearings(const std::vector<Vec3>& wire,
                                              const std::vector<WirePair>& pairs) const;
  [[nodiscard]] std::vector<Vec3> taken_along(const std::vector<Vec3>& membrane_by) const;
  /// What a wire at x carries, with the membrane as it lies.
  struct Load {
    double energy;
    std::vector<Bearing> bearings;
  };
  [[nodiscard]] Load load(const std::vector<Vec3>& x);
  [[nodiscard]] std::vector<Vec3> newton_step(const std::vector<Bearing>& bearings) const;
  [[nodiscard]] bool is_inside();
  void settle(int most_steps);

  std::vector<Triangle> triangles_;
  std::vector<Vec3> membrane_;  ///< where the wire has followed it to [mm]
  std::vector<Box> boxes_;      ///< of its triangles
  std::vector<WirePair> near_;  ///< all pairs of boxes_ and near_segments_
  std::vector<Box> near_segments_;
  std::vector<Vec3> wire_;    ///< the nodes, and one beyond each pole
  std::vector<double> rest_;  ///< of the segments [mm]
  std::vector<Vec3> bend_;    ///< unloaded: straight
  RodSection<double> section_;
  double reach_ = 0.0;      ///< the wire's diameter [mm]
  double stiffness_ = 0.0;  ///< of the barrier [Pa/mm]
  int poles_[2] = {-1, -1};
  bool inside_ = false;
};

}  // namespace angio::simulation::detail
