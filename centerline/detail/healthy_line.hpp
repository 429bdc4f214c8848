#pragma once

#include <vector>

#include "centerline/detail/healthy_field.hpp"

/// The healthy diameter along a branch, from the cells that agree with the field.
namespace angio::centerline {

inline constexpr double kLeastSpread = 0.05;  ///< healthy vessels are no better cones than that
inline constexpr double kMostSpread = 0.15;   ///< wilder is no scatter, but lesion after lesion
inline constexpr double kHealthy = 2.0;       ///< spreads

/// How much the healthy diameters around each cell scatter around a line. Errors go to both sides
/// alike, but a lesion's shoulders only below the line, and those of an ectasia only above: the
/// smaller of both sides' scatter is that of the errors.
std::vector<double> scatter_around(const std::vector<FieldCell>& cells,
                                   const std::vector<double>& line);

/// ln of the healthy diameter at each cell of a branch: a straight line through the healthy cells
/// around it, weighted by their distance. What is taken for healthy is told ever more sharply, down
/// to three times the scatter: the shoulders of a lesion are left out. Lengths count in healthy
/// diameters, so a lesion weighs no more than the vessel beside it. The field's value counts as one
/// diameter measured there that errs by `kPrior`: it is the line's only where nothing is healthy.
std::vector<double> fit_healthy_line(const FieldBranch& branch, const std::vector<double>& best);

/// The same line where the vessel behind a throat is narrower than it by more than a lesion's
/// shoulder (20 %) until the branch ends, and even over five diameters: 5 % in root mean square off
/// a taper of -8 to +3 % a diameter. No disease is as even, the vessel has that width there (a
/// child's aorta behind its coarctation). Between both, the line goes straight from one width to
/// the other, as interpolated references do. A throat is at least 30 % narrower than what comes
/// behind it; a vessel that is but narrow says nothing of the kind.
std::vector<double> accept_narrower_vessel(const FieldBranch& branch,
                                           const std::vector<double>& line);

/// ln of the healthy diameter at a position of a branch, between its cells.
double value_at(const FieldBranch& branch, const std::vector<double>& line, double position);

}  // namespace angio::centerline
