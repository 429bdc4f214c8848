#pragma once

#include <vector>

#include "simulation/materials/membrane.hpp"
#include "simulation/newton/newton.hpp"

namespace angio::simulation::detail {

/// The elastic energy of a membrane on a triangle mesh, for minimize().
class MembraneTerm final : public EnergyTerm {
 public:
  /// @param rest       unloaded positions [mm], shape [vertex]
  /// @param thickness  before loading [mm]
  /// @param fibre      direction of the fibres in the unloaded shape, shape [triangle]; empty: none
  MembraneTerm(MembraneLaw<double> law, std::vector<Triangle> triangles,
               const std::vector<Vec3>& rest, double thickness,
               const std::vector<Vec3>& fibre = {});

  [[nodiscard]] double value(const std::vector<Vec3>& x) const override;
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override;
  [[nodiscard]] MembraneStress<double> stress(std::size_t triangle,
                                              const std::vector<Vec3>& x) const;

 private:
  MembraneLaw<double> law_;
  std::vector<Triangle> triangles_;
  std::vector<CornerMetric<double>> metric_;  // seen from each triangle's first corner
};

}  // namespace angio::simulation::detail
