#pragma once

#include <vector>

#include "core/triangle_mesh.hpp"
#include "simulation/materials/membrane.hpp"

namespace angio::simulation::detail {

struct PbdStep {
  double dt = 0.025;       ///< [s]
  int iterations = 20;     ///< projections of every triangle
  double stiffness = 1.0;  ///< k, share of a projection that is applied, (0, 1]
  double damping = 0.0;    ///< share of the velocity lost in a step, [0, 1]
};

/// The seed paper's solver, for comparison: position based dynamics with the constraint C(x) = E(x)
/// of each triangle (its Eqs. 15-19, with corrected gradients).
///
///     x_i <- x_i - k w_i (E / sum_j w_j |dE/dx_j|^2) dE/dx_i
///
/// Not convergent: its target is E = 0, so that the stiffness is set by the number of iterations
/// and the time step, and a pressure-radius curve never comes out (docs/validation.md shows by how
/// much). A triangle is left alone where |dE/dx| vanishes, as it does at rest, E's double root.
///
/// Triangles are taken colour by colour, in packs of eight of one colour; the result depends on
/// neither the processor's vector width nor the number of threads. Single precision.
class PbdSolver {
 public:
  /// @param rest       unloaded shape [mm]; may be open
  /// @param thickness  H [mm]
  /// @param density    [g/mm^3]
  /// @param fixed      shape [vertex]: moves only by `set_position`
  PbdSolver(const TriangleMesh& rest, const MooneyRivlin<double>& law, double thickness,
            double density, const std::vector<char>& fixed);

  void set_position(int vertex, const Vec3& position);

  /// Predicts with the forces [uN, shape [vertex], or empty], projects all triangles, and takes the
  /// velocities from the positions.
  void step(const PbdStep& options, const std::vector<Vec3>& forces);

  [[nodiscard]] std::vector<Vec3> positions() const;  ///< [mm], shape [vertex]
  [[nodiscard]] int color_count() const { return int(color_begin_.size()) - 1; }

  static constexpr int kLanes = 8;
  /// A vertex as the projection reads and writes it.
  struct Particle {
    float x = 0.0F, y = 0.0F, z = 0.0F;
    float inverse_mass = 0.0F;  ///< [1/g]
  };
  /// Eight triangles that share no vertex; unused lanes name the last particle, which nothing
  /// moves.
  struct Batch {
    int corner[3][kLanes];
    float k11[kLanes], k12[kLanes], k22[kLanes], inverse_det[kLanes];
  };

 private:
  void add_batches(const TriangleMesh& rest, double thickness);

  MooneyRivlin<float> law_;  // of moduli with the sum one
  Vec3 origin_;
  std::vector<Particle> particles_;  // one more than there are vertices
  std::vector<Vec3T<float>> velocities_;
  std::vector<Batch> batches_;
  std::vector<int> color_begin_;
};

}  // namespace angio::simulation::detail
