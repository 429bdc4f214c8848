#include "reconstruction/detail/fit_to_ends.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/statistics.hpp"

namespace angio::reconstruction::detail {
namespace {

/// How many points at a line's end lie beyond the vessel's: lines reach out of a vessel's end by
/// their blur, and the tube fitted there has no radius to speak of.
std::size_t beyond_end(const CenterlinePath& path, bool at_inlet) {
  constexpr double kNear = 10.0;                // [mm]
  constexpr double kPart = 0.75, kReach = 4.0;  // of the vessel's radius there
  const std::size_t count = path.points.size();
  const auto point = [&](std::size_t n) { return at_inlet ? n : count - 1 - n; };
  const auto along = [&](std::size_t n) {
    return std::abs(path.abscissa[point(n)] - path.abscissa[point(0)]);
  };
  std::vector<double> radii;
  for (std::size_t n = 0; n < count && along(n) < kNear; ++n)
    radii.push_back(path.equivalent_radius[point(n)]);
  const double vessel = quantile(radii, 0.75);
  std::size_t beyond = 0;
  while (beyond < radii.size() && along(beyond) < std::min(kReach * vessel, 0.5 * kNear) &&
         radii[beyond] < kPart * vessel)
    ++beyond;
  // A path that would be gone keeps its ends.
  constexpr std::size_t kFewest = 8;
  return 2 * beyond + kFewest > count ? 0 : beyond;
}

/// A tree without what lies beyond its vessels' ends, and whether that was anything.
struct CutTree {
  CenterlineTree tree;
  bool is_shorter = false;
};

CutTree without_ends(const CenterlineTree& tree) {
  CutTree result;
  CenterlineTree& cut = result.tree;
  for (const CenterlinePath& path : tree.paths) {
    const std::size_t first = beyond_end(path, true),
                      last = path.points.size() - beyond_end(path, false);
    result.is_shorter = result.is_shorter || last - first < path.points.size();
    CenterlinePath& kept = cut.paths.emplace_back();
    kept.id = path.id;
    kept.points.assign(path.points.begin() + std::ptrdiff_t(first),
                       path.points.begin() + std::ptrdiff_t(last));
    kept.inscribed_radius.assign(path.inscribed_radius.begin() + std::ptrdiff_t(first),
                                 path.inscribed_radius.begin() + std::ptrdiff_t(last));
    kept.abscissa = arc_length(kept.points);
    kept.tracts = {{0, int(kept.points.size()) - 1, path.id, 0, false}};
  }
  return result;
}

double usual_radius(const CenterlineTree& tree) {
  std::vector<double> radii;
  for (const CenterlinePath& path : tree.paths)
    radii.insert(radii.end(), path.inscribed_radius.begin(), path.inscribed_radius.end());
  return median(std::move(radii));
}

constexpr double kCoarseNodes = 1.25;  ///< median radii between them

}  // namespace

void cut_ends(TreeFit& fit) {
  for (std::size_t p = 0; p < fit.tree.paths.size(); ++p) {
    CenterlinePath& path = fit.tree.paths[p];
    const auto first = std::ptrdiff_t(beyond_end(path, true)),
               last = std::ptrdiff_t(path.points.size() - beyond_end(path, false));
    const auto cut = [&](auto& values) {
      values = std::decay_t<decltype(values)>(values.begin() + first, values.begin() + last);
    };
    cut(path.points);
    cut(path.inscribed_radius);
    cut(path.tube_radius);
    cut(path.equivalent_radius);
    cut(path.section_area);
    cut(fit.radius_sd[p]);
    path.abscissa = arc_length(path.points);
    path.tracts = {{0, int(path.points.size()) - 1, path.id, 0, false}};
  }
}

TreeFit fit_to_ends(RotationalRun run, double air, CenterlineTree tree,
                    const TreeFitOptions& options, const Progress& progress) {
  constexpr int kMostCuts = 5;
  TreeFitOptions coarse = options;
  coarse.node_spacing_mm = std::clamp(kCoarseNodes * usual_radius(tree), 2.0, 10.0);
  coarse.most_steps = 12;
  for (int cut = 0; cut < kMostCuts; ++cut) {
    const TreeFit fit =
        fit_tree(run, air, tree, coarse, part(progress, 0.1 * cut, 0.1 * (cut + 1)));
    run.frames = fit.frames;  // the tree lies where they see it
    CutTree shorter = without_ends(fit.tree);
    tree = std::move(shorter.tree);
    if (!shorter.is_shorter) break;
  }
  TreeFit fit = fit_tree(run, air, tree, options, part(progress, 0.5, 0.75));
  run.frames = fit.frames;
  if (CutTree shorter = without_ends(fit.tree); shorter.is_shorter)
    fit = fit_tree(run, air, shorter.tree, options, part(progress, 0.75, 1.0));
  cut_ends(fit);
  return fit;
}

}  // namespace angio::reconstruction::detail
