#pragma once

#include <vector>

#include "simulation/detail/contact_set.hpp"
#include "simulation/detail/gas.hpp"
#include "simulation/detail/scene.hpp"
#include "simulation/detail/schedule.hpp"
#include "simulation/detail/step_impl.hpp"

namespace angio::simulation::detail {

/// What moves.
struct State {
  std::vector<Vec3> x, velocity;  ///< [mm], [mm/s], shape [vertex]
  std::vector<Mat3> rotation;     ///< of the clusters
  std::vector<Mat3> plastic;      ///< S^p of the clusters
  double pressure = 0.0;          ///< absolute [Pa]
  double volume = 0.0;            ///< enclosed [mm^3]
};

State start_state(const Scene& scene, double pressure);

struct StepReport {
  double residual = 0.0;  ///< net force over load, root of sums of squares
  int sweeps = 0;
  int detections = 0;
  double friction_delta = 0.0;  ///< see README [mm]
};

/// Takes implicit Euler steps by vertex block descent: sweeps over the vertices, colour by colour,
/// each vertex taking a Newton step in its own 3 x 3 block.
///
/// Source: Chen, Liu, Yang, Yuksel, "Vertex Block Descent", ACM TOG 43 (2024), Eqs. 4-9; here with
/// over-relaxation in place of the Chebyshev acceleration, and with the enclosed gas, which couples
/// all vertices through one number, met exactly once a colour: the volume is linear in the vertices
/// of a colour, V(p) = V + sum g . H^-1 (f + (p - p_0) g), and the gas law is solved against it.
class StepSolver {
 public:
  StepSolver(const Scene& scene, const SimulationOptions& options);

  StepReport step(const GasLaw<double>& law, double dt, State& state);

  /// Pressure of the wall's contact forces at the end of the last step [Pa], shape [wall].
  [[nodiscard]] const std::vector<double>& contact_pressure() const { return contact_pressure_; }
  /// Vertices of the balloon in contact at the end of the last step.
  [[nodiscard]] int contact_count() const { return contact_count_; }

 private:
  struct Move {
    Vec3 by_volume, by_force, by_pressure;  ///< g, w H^-1 f, w H^-1 g
    Vec3 friction;                          ///< H^-1 of the friction
    double net = 0.0, load = 0.0;           ///< squared [uN^2]
    bool taut = true;
  };

  void begin_step(double dt, State& state);
  void detect(const State& state);
  void fit_wall();
  void sweep_balloon(const GasLaw<double>& law, State& state);
  void sweep_wall(State& state);
  double residual() const;
  void flow_wall(double dt, State& state);
  void measure_contact(State& state);
  void move_vertex(int v, const Vec3& move);
  bool any_blocked() const;

  const Scene& scene_;
  SimulationOptions options_;
  PlasticFlow<double> plasticity_;
  StepView view_;
  ContactSet contacts_;
  std::vector<Vec3> x_before_, x_inertial_, x_detected_, goal_, cluster_centre_;
  std::vector<Mat3> cluster_map_;
  std::vector<double> goal_stiffness_, area_, contact_pressure_, pair_weights_;
  std::vector<Move> moves_;
  std::vector<char> blocked_;
  double last_motion_ = 0.0, load_floor_ = 0.0;
  int contact_count_ = 0;
};

/// Enclosed volume of the balloon [mm^3].
double balloon_volume(const Scene& scene, const std::vector<Vec3>& x);

}  // namespace angio::simulation::detail
