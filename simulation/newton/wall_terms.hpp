#pragma once

#include <vector>

#include "simulation/bodies/layered_model.hpp"
#include "simulation/newton/newton.hpp"

/// The wall's energies for Newton's method. Its load, the pressure in the lumen, is the Enclosure
/// that lumen_enclosure makes.
namespace angio::simulation::detail {

/// All wedges of a solid.
class SolidTerm final : public EnergyTerm {
 public:
  /// @param model  is kept by reference
  explicit SolidTerm(const SolidModel& model) : model_(model) {}
  [[nodiscard]] double value(const std::vector<Vec3>& x) const override;
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override;

 private:
  const SolidModel& model_;
};

/// k_v / 2 |x_v - X_v|^2: the surrounding tissue holds the outer surface where it was seen.
class FoundationTerm final : public EnergyTerm {
 public:
  /// @param stiffness  k [uN/mm], shape [vertex]; both are kept by reference
  FoundationTerm(const std::vector<double>& stiffness, const std::vector<Vec3>& place)
      : stiffness_(stiffness), place_(place) {}
  [[nodiscard]] double value(const std::vector<Vec3>& x) const override;
  void add(const std::vector<Vec3>& x, bool clamp, Assembly& out) const override;

 private:
  const std::vector<double>& stiffness_;
  const std::vector<Vec3>& place_;
};

/// The lumen closed by a fan over each rim, under a pressure above that around [Pa]. A cap's load
/// is at right angles to it: it counts only where the rim may move out of its plane.
Enclosure lumen_enclosure(const LayeredWall& wall, double pressure);

}  // namespace angio::simulation::detail
