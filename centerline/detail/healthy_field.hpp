#pragma once

#include <vector>

namespace angio::centerline {

/// A piece of a branch over which the diameter was measured.
struct FieldCell {
  double log_diameter = 0.0;  ///< mean of ln(diameter / mm)
  double weight = 0.0;        ///< its length in diameters; 0: nothing was measured
  double position = 0.0;      ///< of its middle from the branch's beginning, in diameters
  double length_mm = 0.0;
  double abscissa_mm = 0.0;  ///< of its middle along the path
  double log_sides = 0.0;    ///< ln(diameter / mm) of the narrower of its sides; its own: no dip
  double spread = 0.05;      ///< sd of healthy ln diameters around their taper
};

struct FieldBranch {
  std::vector<FieldCell> cells;  ///< at least one
  std::vector<int> daughters;    ///< indices above its own
  double length = 0.0;           ///< in diameters
};

/// For each cell, the cost of the best healthy tree that has a given ln diameter there.
///
/// A healthy tree tapers evenly along its branches, takes a step rarely, and obeys the forks' law
/// R0^p = R1^p + R2^p, p = 7/3 (Huo, Kassab, J. R. Soc. Interface 9, 2012,
/// doi:10.1098/rsif.2011.0270); measured diameters scatter around it, but for stretches that are
/// diseased or dilated, whose diameter tells nothing. The cost is minus the logarithm of the
/// probability of all that; it is least exactly, by min-sum messages along the tree, which has no
/// loops (Pearl, Probabilistic reasoning in intelligent systems, 1988, section 4.3). Directions are
/// not taken for granted: blood may come in by any end and run against a branch, at a price, and
/// where it comes in by both ends of a branch, it meets there.
class HealthyField {
 public:
  /// @param branches  parents before daughters; the first is the root
  explicit HealthyField(const std::vector<FieldBranch>& branches);

  /// ln of the healthy diameter: the mean of those whose cost is near the least.
  [[nodiscard]] double best(std::size_t branch, std::size_t cell) const;
  /// By how much the cost rises when the ln diameter has to be at most this.
  [[nodiscard]] double cost_below(std::size_t branch, std::size_t cell, double most) const;

 private:
  double low_ = 0.0;                                    ///< the ln diameters are low_ + i step
  std::vector<std::vector<std::vector<double>>> cost_;  ///< [branch][cell][i]
};

}  // namespace angio::centerline
