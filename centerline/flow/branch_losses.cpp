#include "centerline/flow/branch_losses.hpp"

#include <algorithm>

#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// The integral of ds / r^4 over a cone, exactly.
double cone(double length, double a, double b) {
  return length * (a * a + a * b + b * b) / (3.0 * a * a * a * b * b * b);
}

double inverse_area(double radius) { return 1.0 / (units::kPi * radius * radius); }

/// A vessel, walked along: the loss of all throats that have ended, and of the one that is open.
class Throats {
 public:
  explicit Throats(double radius) : narrowest_(radius), widest_(radius) {}

  void walk_to(double radius) {
    constexpr double kEnds = 0.95;  // as far as healthy diameters scatter round their taper
    if (radius < kEnds * widest_) {
      ended_ += open();
      narrowest_ = widest_ = radius;
    } else if (radius < narrowest_) {
      narrowest_ = widest_ = radius;
    }
    widest_ = std::max(widest_, radius);
  }
  [[nodiscard]] double loss() const { return ended_ + open(); }

 private:
  [[nodiscard]] double open() const {
    const double jet = inverse_area(narrowest_) - inverse_area(widest_);
    return jet * jet;
  }
  double narrowest_, widest_;
  double ended_ = 0.0;
};

}  // namespace

std::vector<double> filled_radii(const FlowBranch& branch) {
  const std::size_t count = branch.radius.size();
  std::vector<double> radius = branch.radius;
  std::size_t before = count;  // the last measured point; none yet
  for (std::size_t i = 0; i <= count; ++i) {
    if (i < count && !(branch.radius[i] > 0.0)) continue;
    if (before == count && i == count) return branch.healthy;
    const std::size_t first = before == count ? 0 : before + 1;
    for (std::size_t k = first; k < i; ++k) {
      if (before == count || i == count) {
        radius[k] = branch.radius[before == count ? i : before];
        continue;
      }
      const double gap = branch.abscissa[i] - branch.abscissa[before];
      const double t = gap > 0.0 ? (branch.abscissa[k] - branch.abscissa[before]) / gap : 0.0;
      radius[k] = (1.0 - t) * branch.radius[before] + t * branch.radius[i];
    }
    before = i;
  }
  return radius;
}

BranchLosses branch_losses(const std::vector<double>& abscissa, const std::vector<double>& radius,
                           double opens_into) {
  BranchLosses losses;
  losses.friction.assign(radius.size(), 0.0);
  losses.expansion.assign(radius.size(), 0.0);
  Throats throats(radius.front());
  for (std::size_t i = 1; i < radius.size(); ++i) {
    losses.friction[i] =
        losses.friction[i - 1] +
        8.0 / units::kPi * cone(abscissa[i] - abscissa[i - 1], radius[i - 1], radius[i]);
    throats.walk_to(radius[i]);
    losses.expansion[i] = throats.loss();
  }
  if (opens_into > radius.back()) {
    throats.walk_to(opens_into);
    losses.expansion.back() = throats.loss();
  }
  return losses;
}

}  // namespace angio::centerline
