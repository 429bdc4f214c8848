#pragma once

#include <memory>
#include <string>

#include "simulation/simulation.hpp"

namespace angio::simulation {

/// What a hand asks of the balloon.
struct LiveAim {
  double pressure_atm = 0.0;  ///< above the outside, [0, 40]
  double place_mm = 0.0;      ///< along the guidewire, from where the balloon was placed
};

/// A simulation that is driven by hand, frame by frame, instead of by a schedule: gas flows in or
/// out at the schedule's rates until the pressure is the one that is asked for, and the balloon is
/// pushed or drawn along the guidewire. On the CPU. The wall's own model, contact and membrane are
/// those of simulate().
///
/// Pushing carries the balloon's vertices along the wire, each in the frame that turns with the
/// wire's direction the least, so that a straight wire moves it rigidly. It is quick and without
/// inertia or friction of the shaft; a push that would bring balloon and wall across each other is
/// not made: deflate first.
class LiveSimulation {
 public:
  /// As simulate(). The reference's gas and contact (GasModel::per_tet, ContactModel::paper), which
  /// have no pressure to ask for, are replaced by the enclosed gas and the barrier.
  /// @throws InputError if the balloon crosses the wall at the start
  LiveSimulation(SimulationModel model, SimulationOptions options);
  ~LiveSimulation();
  LiveSimulation(LiveSimulation&&) noexcept;
  LiveSimulation& operator=(LiveSimulation&&) = delete;

  [[nodiscard]] const SimulationModel& model() const;

  /// The start.
  [[nodiscard]] const SimulationFrame& frame() const;
  /// One frame of `options.frame_s` towards the aim.
  const SimulationFrame& step(const LiveAim& aim);

  /// Where the balloon is now [mm], and how far the wire lets it go, from negative to positive.
  [[nodiscard]] double place_mm() const;
  [[nodiscard]] double least_place_mm() const;
  [[nodiscard]] double most_place_mm() const;
  /// Whether the last push was not made.
  [[nodiscard]] bool is_stuck() const;
  [[nodiscard]] std::string device() const;

 private:
  struct Session;
  std::unique_ptr<Session> session_;
};

}  // namespace angio::simulation
