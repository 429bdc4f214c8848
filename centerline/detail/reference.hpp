#pragma once

#include <string>
#include <vector>

#include "core/centerline.hpp"

namespace angio::centerline {

/// The diameter that a path would have without disease.
struct ReferenceDiameter {
  std::vector<double> diameter;    ///< [mm], shape [point]; 0 where there is none (at the ends)
  std::vector<char> interpolated;  ///< 1: linear taper fit; 0: mean of proximal and distal
  std::vector<char> healthy;       ///< 1: part of the vessel that the reference is taken from
  std::vector<int> segment;        ///< stretch with one fit, shape [point]; -1 where there is none
};

/// Reference diameter along a path.
///
/// A segment is a stretch between branchings (small side branches, behind which the diameter goes
/// on within kSameVessel, do not end it), less branchings and less one diameter at the tips. On
/// each, a straight line d_ref(s) = a + b s is fitted to the healthy samples: it starts as the 70 %
/// quantile line, then samples more than two robust standard deviations (at least 5 %) below it
/// are left out as diseased and those more than kDilated above it as ectasia, until it stays.
/// "Interpolated" reference of quantitative coronary angiography: Reiber, Serruys, Kooijman et
/// al., Circulation 71(2), 1985, doi:10.1161/01.CIR.71.2.280; the one-sided weights are ours.
///
/// Where less than two diameters of healthy vessel are left, the reference is the mean of the
/// nearest healthy diameters proximal and distal on the path ("average").
///
/// Inside a branching it is the smaller of the references before and behind it: a healthy lumen is
/// nowhere narrower there than the vessel it leads to, so a dip below is a lesion of the ostium or
/// the carina.
ReferenceDiameter find_reference(const CenterlinePath& path);

}  // namespace angio::centerline
