#include <algorithm>
#include <cmath>

#include "centerline/detail/branches.hpp"
#include "centerline/detail/reference.hpp"
#include "centerline/flow/flow.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::centerline {
namespace {

/// Of a section's area and the ball in it; not a number where one of them is none.
double lumen_radius(double equivalent, double inscribed) {
  constexpr double kMost = 1.5;
  return std::max(inscribed, std::min(equivalent, kMost * inscribed));
}

/// The radius at an abscissa, linear between the places of a profile; not a number outside.
double radius_at(const LumenProfile& profile, double abscissa) {
  const auto above =
      std::lower_bound(profile.abscissa.begin(), profile.abscissa.end(), abscissa - 1e-3);
  if (above == profile.abscissa.end()) return std::nan("");
  const auto radius = [&](std::size_t i) {
    return lumen_radius(std::sqrt(profile.section_area[i] / units::kPi),
                        profile.inscribed_radius[i]);
  };
  const auto i = std::size_t(above - profile.abscissa.begin());
  if (*above <= abscissa + 1e-3) return radius(i);  // files round
  if (i == 0) return std::nan("");
  const double t =
      (abscissa - profile.abscissa[i - 1]) / (profile.abscissa[i] - profile.abscissa[i - 1]);
  return (1.0 - t) * radius(i - 1) + t * radius(i);
}

}  // namespace

FlowTree make_flow_tree(const CenterlineTree& tree, double voxel_mm) {
  if (tree.paths.empty())
    throw InputError("the tree has no paths, so nothing flows in it. Run centerline first");
  const TreeReference reference = find_reference(tree, voxel_mm);
  FlowTree flow;
  for (const Branch& branch : reference.branches) {
    const CenterlinePath& path = tree.paths[std::size_t(branch.path)];
    const ReferenceDiameter& known = reference.paths[std::size_t(branch.path)];
    FlowBranch& stretch = flow.branches.emplace_back();
    stretch.parent = branch.parent;
    const auto first = std::size_t(branch.first), last = std::size_t(branch.last);
    if (first > 0 || first == last) {  // the fork itself belongs to the branch before
      stretch.abscissa.push_back(path.abscissa[first > 0 ? first - 1 : first]);
      stretch.radius.push_back(0.0);
      stretch.healthy.push_back(0.5 * known.diameter[first]);
    }
    for (std::size_t i = first; i <= last; ++i) {
      stretch.abscissa.push_back(path.abscissa[i]);
      stretch.radius.push_back(
          known.measured[i] > 0.0 ? lumen_radius(path.equivalent_radius[i], 0.5 * known.measured[i])
                                  : 0.0);
      stretch.healthy.push_back(0.5 * known.diameter[i]);
    }
  }
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    std::vector<FlowPlace>& places = flow.paths.emplace_back();
    for (std::size_t i = 0; i < tree.paths[p].points.size(); ++i) {
      const auto b = std::size_t(reference.paths[p].branch[i]);
      const auto first = std::size_t(reference.branches[b].first);
      const bool is_led_in =
          flow.branches[b].radius.size() > std::size_t(reference.branches[b].last) - first + 1;
      places.push_back({b, i - first + (is_led_in ? 1 : 0)});
    }
  }
  return flow;
}

FlowTree with_lumen(FlowTree tree, const CenterlinePath& line, std::size_t path,
                    const LumenProfile& profile) {
  for (std::size_t i = 0; i < line.abscissa.size(); ++i) {
    const FlowPlace place = tree.paths.at(path).at(i);
    double& radius = tree.branches[place.branch].radius[place.point];
    const double now = radius_at(profile, line.abscissa[i]);
    if (radius > 0.0 && now > 0.0) radius = now;
  }
  return tree;
}

}  // namespace angio::centerline
