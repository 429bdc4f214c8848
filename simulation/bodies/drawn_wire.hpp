#pragma once

#include <vector>

#include "simulation/simulation.hpp"

namespace angio::simulation::detail {

/// The guidewire where it is no body of its own: drawn so that it stays in the balloon. Each node
/// is the middle of what was around it at the start; where that lies outside, as in an emptied
/// balloon that has folded, half-way through the balloon from its nearest vertex. The ends stay at
/// the poles.
class DrawnWire {
 public:
  /// @param model  its guidewire has no nodes: none is drawn
  explicit DrawnWire(const SimulationModel& model);

  /// @param balloon  positions [mm], in the model's numbering
  [[nodiscard]] std::vector<Vec3> nodes(const std::vector<Vec3>& balloon) const;

 private:
  struct Share {
    int vertex;
    double weight;  ///< those of a node sum to 1
  };
  std::vector<std::vector<Share>> around_;  ///< shape [node]
  std::vector<Triangle> triangles_;
};

}  // namespace angio::simulation::detail
