#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "centerline/centerline.hpp"
#include "centerline/detail/blood.hpp"
#include "centerline/detail/contacts.hpp"
#include "centerline/detail/diffuse.hpp"
#include "centerline/detail/dip.hpp"
#include "centerline/detail/doubt.hpp"
#include "centerline/detail/tracts.hpp"
#include "centerline/detail/trial_place.hpp"
#include "centerline/resolution.hpp"
#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "core/require.hpp"

namespace angio::centerline {

void LesionOptions::validate() const {
  require_within("lesion.min_stenosis_percent", min_stenosis_percent, 10.0, 90.0);
  require_within("lesion.min_reference_mm", min_reference_mm, 0.0, 30.0);
  if (!(voxel_mm >= 0.0 && std::isfinite(voxel_mm)))
    throw OptionError("lesion.voxel_mm is " + std::to_string(voxel_mm) + ". Give 0 mm or more");
  if (centerline < -1)
    throw OptionError("lesion.centerline is " + std::to_string(centerline) +
                      ". Give the id of a path, or -1 for all of them");
  if (!std::isfinite(abscissa_mm)) throw OptionError("lesion.abscissa_mm is not a number");
}

namespace {

/// A tree and what it would be like if it were healthy.
struct ReferredTree {
  const CenterlineTree& tree;
  TreeReference reference;

  [[nodiscard]] Known known(std::size_t path) const {
    return {tree.paths[path], reference, reference.paths[path]};
  }
};

/// A lesion is listed if its other readings cost this much more (natural logarithm of the odds):
/// that the vessel is thin there by itself, where it ends sooner than elsewhere, and that the
/// diameters err. Many places are looked at, and errors are no better known than that.
constexpr double kLeastEvidence = 0.2;
constexpr double kLeastEvidenceAtEnd = 1.0;
constexpr double kLeastEvidenceInEnd = 5.0;
constexpr double kMostEvidence = 2.0;  ///< that is asked for where many branches are looked at
constexpr double kLeastOddsOfErrors = 5.0;
constexpr double kHalf = 50.0;  ///< [%]

/// The same for a place that lies open to both sides: as many branches, as many chances. Before a
/// dip in which the tree begins, as behind one in which a line ends, nothing tells its width.
double least_evidence_at(const Known& known, const Dip& dip) {
  const double least =
      std::min(kMostEvidence, kLeastEvidence + std::log(double(known.tree.branches.size())));
  return known.is_measured_within(0, dip.first) ? least : std::max(least, kLeastEvidenceAtEnd);
}

/// What a listing has to cost more in a large tree and in one whose lines pass from vessel to
/// vessel (natural logarithm of the odds): of more places some are narrow by chance, and each place
/// where vessels touch or a loop was cut is a bridge that might be taken for a stenosis.
double doubt_in(const CenterlineTree& tree, const TreeReference& reference) {
  constexpr double kUsualBranches = 25.0;
  const double wrong_joints = double(find_contacts(tree).size()) + double(count_cut_ends(tree));
  return std::log1p(wrong_joints) +
         std::max(0.0, std::log(double(reference.branches.size()) / kUsualBranches));
}

/// A dip is in the end where its tightest place is within this many healthy diameters of it.
constexpr double kReachOfEnd = 0.25;

/// A vessel is seen from this many voxels on: a thinner one is shown by partial volumes alone.
constexpr double kLeastVoxels = 3.0;

/// Branches that go on in their widest daughter: each point of a tree is on one vessel.
std::vector<Vessel> find_vessels(const TreeReference& tree) {
  std::vector<Vessel> vessels;
  std::vector<int> begins(tree.branches.empty() ? 0 : 1, 0);
  while (!begins.empty()) {
    int at = begins.back();
    begins.pop_back();
    const int first = tree.branches[std::size_t(at)].first;
    for (;;) {
      const std::vector<int>& daughters = tree.branches[std::size_t(at)].daughters;
      if (daughters.empty()) break;
      const auto width = [&](int d) { return tree.field.best(std::size_t(d), 0); };
      int widest = daughters.front();
      for (const int d : daughters)
        if (width(d) > width(widest) + 0.02) widest = d;
      for (const int d : daughters)
        if (d != widest) begins.push_back(d);
      at = widest;
    }
    const Branch& end = tree.branches[std::size_t(at)];
    vessels.push_back({std::size_t(end.path), std::size_t(first), std::size_t(end.last)});
  }
  return vessels;
}

/// What it costs more that the vessel around a dip is healthy, but thin: that the stenosis is less
/// than half of what would be listed.
double cost_of_thin_vessel(const Known& known, const Dip& dip, double listed_percent) {
  const auto branch = std::size_t(known.reference.branch[dip.tightest]);
  const auto cell = std::size_t(known.reference.cell[dip.tightest]);
  const double tight = known.tree.field_branches[branch].cells[cell].log_diameter;
  return known.tree.field.cost_below(branch, cell, tight - std::log(1.0 - 0.005 * listed_percent));
}

/// What it costs that a dip is but errors of healthy diameters.
double cost_of_errors(const Known& known, const Dip& dip) {
  double cost = 0.0;
  std::pair<int, int> last{-1, -1};
  for (std::size_t i = dip.first; i <= dip.last; ++i) {
    const std::pair<int, int> at{known.reference.branch[i], known.reference.cell[i]};
    if (at.second < 0 || at == last) continue;
    last = at;
    const FieldCell& cell =
        known.tree.field_branches[std::size_t(at.first)].cells[std::size_t(at.second)];
    const double error = (cell.log_diameter - std::log(known.reference.diameter[i])) / cell.spread;
    cost += 0.5 * cell.weight * error * error;
  }
  return cost;
}

/// Whether a dip is but the closed tip in which the vessel ends: from its tightest place on the
/// lumen widens no more, and over its last healthy radius it goes on to narrow; or, within a
/// healthy diameter of the line's end, it stays shut (under a fifth of the healthy width), as a
/// thread that a tip frays into. The ball that fits there tells: sections in a tip are no tube's.
bool is_tip(const Known& known, const Dip& dip) {
  constexpr double kWidens = 1.25, kLeast = 0.05, kNarrows = 0.6, kShut = 0.1, kThread = 0.2;
  const std::vector<double>&radius = known.path.inscribed_radius, &s = known.path.abscissa;
  const double tight = radius[dip.tightest];
  const double healthy = 0.5 * known.reference.diameter[dip.tightest];
  const double widened = std::max(kWidens * tight, tight + 2.0 * kLeast * healthy);
  const auto ends = [&](std::size_t end) {
    std::size_t before = dip.tightest;  // a healthy radius before the end
    for (std::size_t i = 0; i < s.size(); ++i)
      if (std::abs(std::abs(s[i] - s[end]) - healthy) <
          std::abs(std::abs(s[before] - s[end]) - healthy))
        before = i;
    return radius[end] < std::max(kShut * healthy, kNarrows * radius[before]);
  };
  const auto widens = [&](double r) { return r >= widened; };
  const auto is_open = [&](double r) { return r >= kThread * healthy; };
  const auto is_near = [&](std::size_t end) {
    return std::abs(s[dip.tightest] - s[end]) < 2.0 * healthy;
  };
  const auto is_tip_at = [&](std::size_t end) {
    const auto [first, last] = std::minmax(end, dip.tightest);
    const auto begin = radius.begin() + std::ptrdiff_t(first);
    const auto behind = radius.begin() + std::ptrdiff_t(last) + 1;
    return (std::none_of(begin, behind, widens) && ends(end)) ||
           (is_near(end) && std::none_of(begin, behind, is_open));
  };
  return is_tip_at(radius.size() - 1) || is_tip_at(0);
}

/// Whether a dip is tightest in the end of its line, as where a vessel but tapers to its end:
/// nothing behind it tells how wide it would be.
bool ends_tightest(const Known& known, const Dip& dip) {
  const std::vector<double>& s = known.path.abscissa;
  const double reach = kReachOfEnd * known.reference.diameter[dip.tightest];
  return s.back() - s[dip.tightest] < reach || s[dip.tightest] - s.front() < reach;
}

/// Whether a dip is narrow enough and no vessel's end, whatever speaks for it.
bool is_candidate(const Known& known, const Dip& dip, const LesionOptions& options) {
  return known.percent(dip.tightest) >= options.min_stenosis_percent && !is_tip(known, dip);
}

/// Of what is told for a stenosis: where half of the width is missing, the place told of is one of
/// those where it is.
double least_percent_of(const Known& known, const Dip& dip, const LesionOptions& options) {
  return known.percent(dip.tightest) >= kHalf ? std::max(kHalf, options.min_stenosis_percent)
                                              : options.min_stenosis_percent;
}

/// Whether a dip that little speaks for is told of: half of the width or more is missing, and the
/// vessel is seen before and behind it.
bool is_told_anyway(const Known& known, const Vessel& vessel, const Dip& dip) {
  return known.percent(dip.tightest) >= kHalf && !ends_tightest(known, dip) &&
         known.is_measured_within(dip.last + 1, vessel.last + 1);
}

/// Whether a dip is told of though it is less than a stenosis by the tree: against the vessel
/// before and behind it, which is a quarter wider than the tree's reference, half of the width is
/// missing.
bool is_told_by_sides(const Known& known, const Vessel& vessel, const Dip& dip,
                      const Lesion& lesion) {
  return lesion.has_wide_sides() && lesion.percent_of_sides() >= kHalf &&
         !may_be_a_bridge(known, vessel, dip, lesion) && !is_tip(known, dip) &&
         !ends_tightest(known, dip) && known.is_measured_within(dip.last + 1, vessel.last + 1);
}

/// @param least  evidence, where the dip lies open to both sides
/// @param doubt  in the tree: so much more
bool is_evident(const Known& known, const Vessel& vessel, const Dip& dip, double least,
                double doubt, const LesionOptions& options) {
  if (ends_tightest(known, dip))
    least = kLeastEvidenceInEnd;
  else if (!known.is_measured_within(dip.last + 1, vessel.last + 1))
    least = kLeastEvidenceAtEnd;
  return cost_of_thin_vessel(known, dip, options.min_stenosis_percent) >= least + doubt &&
         cost_of_errors(known, dip) >= kLeastOddsOfErrors;
}

/// Whether the data are too coarse for a stenosis: of voxels, or of triangles of which fewer than
/// nine are around the healthy vessel. Of those the vertices lie on the wall, and the edges are
/// chords of it: around a ball of diameter d a regular polygon of edges e has its corners on a
/// circle of diameter sqrt(d^2 + e^2). So wide the throat may be; a stenosis that it is even then
/// is one, unless the triangles were made of voxels that show no more than labels do.
bool is_too_thin(const CenterlinePath& path, const Lesion& lesion, const LesionOptions& options) {
  constexpr double kEdges = 3.0;
  const double healthy = lesion.reference_diameter_mm;
  if (healthy < kLeastVoxels * options.voxel_mm) return true;
  if (!options.edge_mm) return false;
  const double edge = options.edge_mm(sample(path, lesion.abscissa_mm).point, healthy);
  if (healthy >= kEdges * edge) return false;
  if (healthy < 2.0 * kLeastVoxels * options.voxel_mm) return true;
  const double widest = std::hypot(lesion.mld_mm, edge);
  return 100.0 * (1.0 - widest / healthy) < options.min_stenosis_percent;
}

/// Whether what would be a stenosis by the tree is none by the vessel on its two sides.
bool is_refuted_by_sides(const Lesion& lesion, const LesionOptions& options) {
  return lesion.reference_rule == "sides" &&
         lesion.diameter_stenosis_percent < options.min_stenosis_percent;
}

/// The same points on the longest path that has them.
Vessel on_longest_path(const TreeReference& tree, const Vessel& vessel, const Dip& dip) {
  const int last = tree.paths[vessel.path].branch[dip.last];
  const Branch& branch = tree.branches[std::size_t(last)];
  if (std::size_t(branch.path) == vessel.path) return vessel;
  return {std::size_t(branch.path), vessel.first, std::size_t(branch.last)};
}

/// Why a narrowing is told, and not listed: the first reason that holds.
/// @param doubt_in_tree  evidence that a listing needs more
Doubt reason_to_doubt(const Known& known, const Vessel& vessel, const Dip& dip,
                      const Lesion& lesion, const CenterlinePath& shown, double doubt_in_tree,
                      const LesionOptions& options) {
  if (may_be_a_bridge(known, vessel, dip, lesion)) return Doubt::bridge;
  const double least = least_evidence_at(known, dip);
  if (!is_evident(known, vessel, dip, least, 0.0, options)) return Doubt::faint;
  if (!is_evident(known, vessel, dip, least, doubt_in_tree, options)) return Doubt::crowded;
  if (options.intensity && is_other_blood(shown, lesion, options.intensity, options.voxel_mm))
    return Doubt::other_blood;
  return find_doubt(known, vessel, dip, lesion,
                    {.is_crowded = doubt_in_tree > 0.0, .is_scan = options.voxel_mm > 0.0});
}

/// What a dip is: a stenosis, a narrowing that is told of, or nothing. On a line that is named
/// nothing is in doubt, and nothing is told that little speaks for.
std::optional<Lesion> judge_dip(const ReferredTree& referred, const Vessel& vessel, const Dip& dip,
                                double doubt_in_tree, const LesionOptions& options) {
  const Known known = referred.known(vessel.path);
  const bool is_named = options.centerline >= 0;
  const bool is_by_tree = is_candidate(known, dip, options) &&
                          (is_evident(known, vessel, dip, kLeastEvidence, 0.0, options) ||
                           (!is_named && is_told_anyway(known, vessel, dip)));
  if (!is_by_tree && is_named) return {};
  const Vessel shown = is_named ? vessel : on_longest_path(referred.reference, vessel, dip);
  const CenterlinePath& path = referred.tree.paths[shown.path];
  Lesion lesion =
      describe_dip(referred.known(shown.path), shown, dip, least_percent_of(known, dip, options));
  if (is_no_neck(lesion)) return {};
  if (!is_by_tree || is_refuted_by_sides(lesion, options)) {
    if (is_named || !is_told_by_sides(known, vessel, dip, lesion)) return {};
    lesion.doubt = Doubt::wide_sides;
  }
  lesion.evidence = cost_of_thin_vessel(known, dip, options.min_stenosis_percent);
  if (!is_named && !lesion.is_doubtful())
    lesion.doubt = reason_to_doubt(known, vessel, dip, lesion, path, doubt_in_tree, options);
  if (lesion.doubt == Doubt::bridge && known.percent(dip.tightest) < kHalf) return {};
  lesion.is_too_small = known.reference.diameter[dip.tightest] < options.min_reference_mm;
  lesion.is_too_thin = is_too_thin(path, lesion, options);
  lesion.is_stenosis = !lesion.is_left_out();
  return lesion;
}

void find_on_vessel(const ReferredTree& referred, const Vessel& vessel, double doubt_in_tree,
                    const LesionOptions& options, std::vector<Lesion>& found) {
  const Known known = referred.known(vessel.path);
  for (std::size_t i = vessel.first; i <= vessel.last; ++i) {
    if (known.percent(i) < kShoulderPercent) continue;
    const Dip dip = grow_dip(known, vessel, i);
    i = dip.last;
    if (const auto lesion = judge_dip(referred, vessel, dip, doubt_in_tree, options))
      found.push_back(*lesion);
  }
  if (const std::optional<Lesion> diffuse =
          find_diffuse(known, vessel, options.min_stenosis_percent);
      diffuse && diffuse->reference_diameter_mm >= options.min_reference_mm &&
      !is_too_thin(referred.tree.paths[vessel.path], *diffuse, options))
    found.push_back(*diffuse);
}

std::size_t index_of_path(const CenterlineTree& tree, int id) {
  for (std::size_t p = 0; p < tree.paths.size(); ++p)
    if (tree.paths[p].id == id) return p;
  throw OptionError("lesion.centerline is " + std::to_string(id) + ", but there " +
                    (tree.paths.size() == 1
                         ? std::string("is one path, number 0")
                         : "are " + std::to_string(tree.paths.size()) + " paths, numbered from 0"));
}

Lesion lesion_at(const Known& known, const LesionOptions& options) {
  const CenterlinePath& path = known.path;
  if (options.abscissa_mm > path.abscissa.back())
    throw OptionError("lesion.abscissa_mm is " + std::to_string(options.abscissa_mm) +
                      ", but path " + std::to_string(path.id) + " is " +
                      std::to_string(path.abscissa.back()) + " mm long");
  const auto above =
      std::lower_bound(path.abscissa.begin(), path.abscissa.end(), options.abscissa_mm);
  const auto at = std::size_t(above - path.abscissa.begin());
  const Vessel whole{0, 0, path.points.size() - 1};
  Lesion lesion =
      describe_dip(known, whole, grow_dip(known, whole, at), options.min_stenosis_percent);
  lesion.abscissa_mm = options.abscissa_mm;
  if (!(lesion.length_mm > 0.0)) lesion.proximal_mm = lesion.distal_mm = options.abscissa_mm;
  lesion.is_stenosis = lesion.diameter_stenosis_percent >= options.min_stenosis_percent;
  return lesion;
}

/// The narrowings of one tree.
void find_in_tree(const ReferredTree& referred, const LesionOptions& options,
                  std::vector<Lesion>& found) {
  const auto& [tree, reference] = referred;
  if (options.centerline >= 0) {
    const std::size_t chosen = index_of_path(tree, options.centerline);
    const Vessel whole{chosen, 0, tree.paths[chosen].points.size() - 1};
    return find_on_vessel(referred, whole, 0.0, options, found);
  }
  const double doubt = doubt_in(tree, reference);
  for (const Vessel& vessel : find_vessels(reference))
    find_on_vessel(referred, vessel, doubt, options, found);
}

/// Does a narrowing lie on a path? Paths that part later have the stretch before in common.
bool is_on(const Lesion& narrowing, const CenterlinePath& path, const CenterlineTree& tree) {
  return std::any_of(tree.paths.begin(), tree.paths.end(), [&](const CenterlinePath& its) {
    if (its.id != narrowing.path_id) return false;
    const int shared = its.id == path.id ? int(its.points.size()) : count_shared(its, path);
    return shared > 0 && narrowing.proximal_mm < its.abscissa[std::size_t(shared) - 1];
  });
}

/// The trees that are looked at: all, or that of the line that is named.
std::vector<CenterlineTree> trees_to_search(const CenterlineTree& lines,
                                            const LesionOptions& options) {
  if (options.centerline < 0 && options.abscissa_mm < 0.0) return separate_trees(lines);
  const std::size_t named = index_of_path(lines, std::max(options.centerline, 0));
  return {tree_with_path(lines, lines.paths[named].id)};
}

}  // namespace

std::vector<Lesion> find_lesions(const CenterlineTree& lines, const LesionOptions& options) {
  options.validate();
  if (lines.paths.empty())
    throw InputError("the tree has no paths, so no lesion can be on them. Run centerline first");
  const std::vector<CenterlineTree> trees = trees_to_search(lines, options);
  std::vector<ReferredTree> referred;
  for (const CenterlineTree& tree : trees)
    referred.push_back({tree, find_reference(tree, options.voxel_mm)});
  const Known first = referred.front().known(
      options.centerline >= 0 ? index_of_path(trees.front(), options.centerline) : 0);
  std::vector<Lesion> lesions;
  for (const ReferredTree& tree : referred) find_in_tree(tree, options, lesions);
  std::stable_sort(lesions.begin(), lesions.end(), [](const Lesion& a, const Lesion& b) {
    if (a.is_stenosis != b.is_stenosis) return a.is_stenosis;
    return a.diameter_stenosis_percent > b.diameter_stenosis_percent;
  });
  const bool is_named = options.abscissa_mm >= 0.0;
  if (!is_named && !lesions.empty() && lesions.front().is_stenosis) return lesions;
  // Narrowings on the line, also those in doubt or under the threshold: the tree's reference holds.
  const bool is_narrowed =
      std::any_of(lesions.begin(), lesions.end(), [&](const Lesion& narrowing) {
        return !narrowing.is_too_small && narrowing.doubt != Doubt::bridge &&
               is_on(narrowing, first.path, trees.front());
      });
  const ReferenceDiameter own = is_narrowed ? first.reference : no_wider_than_around(first);
  const Known known{first.path, first.tree, own};
  const double least = std::max(options.min_reference_mm, kLeastVoxels * options.voxel_mm);
  Lesion place = is_named ? lesion_at(known, options) : tightest_place(known, least);
  const std::vector<double>& abscissa = first.path.abscissa;
  const auto at = std::lower_bound(abscissa.begin(), abscissa.end(), place.abscissa_mm);
  const double by_tree = first.reference.diameter[std::size_t(at - abscissa.begin())];
  if (!is_narrowed && place.reference_tree_mm < by_tree) {
    if (place.reference_rule == "tree") place.reference_rule = "vessel";
    place.reference_tree_mm = by_tree;
  }
  if (is_named) return {place};
  lesions.insert(lesions.begin(), place);
  return lesions;
}

std::vector<Lesion> stenoses_beside(const CenterlineTree& tree, const Lesion& one,
                                    const LesionOptions& options) {
  std::vector<Lesion> lesions = find_lesions(tree, whole_tree(options));
  std::erase_if(lesions, [&](const Lesion& lesion) {
    const bool overlaps = lesion.path_id == one.path_id && lesion.proximal_mm < one.distal_mm &&
                          one.proximal_mm < lesion.distal_mm;
    return !lesion.is_stenosis || overlaps;
  });
  return lesions;
}

}  // namespace angio::centerline
