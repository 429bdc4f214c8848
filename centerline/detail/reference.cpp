#include "centerline/detail/reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "centerline/detail/healthy_line.hpp"
#include "core/statistics.hpp"

namespace angio::centerline {
namespace {

constexpr double kCell = 0.25;        // diameters
constexpr double kVoxelError = 0.29;  // of a length counted in voxels: the sd of its last one

/// The radius of the lumen at a point, freed of noise; but a ball that fits into the lumen as it is
/// proves that it is hardly narrower, whatever the fitted section says. The ball's own radius errs
/// by up to a tenth where the vessel is few voxels wide.
double lumen_radius(const CenterlinePath& path, std::size_t i) {
  constexpr double kProved = 0.9;
  return std::max(measured_radius(path)[i], kProved * path.inscribed_radius[i]);
}

/// Hides the flare in which a branch leaves a far wider vessel: right behind a branching the lumen
/// narrows to half its radius within that radius.
void hide_flares(const CenterlinePath& path, std::vector<char>& hidden) {
  constexpr double kFlare = 0.5;
  const std::vector<double>& s = path.abscissa;
  for (std::size_t i = 1; i < hidden.size(); ++i) {
    if (hidden[i] != 0 || hidden[i - 1] == 0) continue;
    const double radius = lumen_radius(path, i);
    for (std::size_t k = i; k < hidden.size() && hidden[k] == 0 && s[k] - s[i] < radius; ++k)
      if (lumen_radius(path, k) < (1.0 - kFlare) * radius) {
        hidden[i] = 1;
        break;
      }
  }
}

/// Points whose radius tells nothing: in branchings and their flares, and where the sphere reaches
/// an end of the line, so that the end may have cut it off.
std::vector<char> find_unmeasured(const CenterlinePath& path) {
  constexpr double kReach = 0.8;
  std::vector<char> hidden = find_hidden(path);
  hide_flares(path, hidden);
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const double to_end = std::min(path.abscissa[i], path.abscissa.back() - path.abscissa[i]);
    if (lumen_radius(path, i) > kReach * to_end) hidden[i] = 1;
  }
  return hidden;
}

/// Twice the inscribed radii, none smaller than the spheres around its neighbours prove: a sphere
/// of radius r at a distance x holds one of r - x. 0 where they tell nothing.
std::vector<double> measure_diameters(const CenterlinePath& path) {
  const std::vector<char> hidden = find_unmeasured(path);
  const std::size_t count = path.points.size();
  std::vector<double> diameter(count, 0.0);
  for (std::size_t j = 0; j < count; ++j) {
    const double r = lumen_radius(path, j);
    if (hidden[j] != 0 || !(r > 0.0)) continue;
    const auto raise = [&](std::size_t i) {
      const double length = std::abs(path.abscissa[i] - path.abscissa[j]);
      if (length >= r) return false;
      if (hidden[i] == 0)
        diameter[i] = std::max(diameter[i], 2.0 * (r - distance(path.points[i], path.points[j])));
      return true;
    };
    for (std::size_t i = j; i < count && raise(i); ++i) {
    }
    for (std::size_t i = j; i-- > 0 && raise(i);) {
    }
  }
  return diameter;
}

/// The unit in which lengths count: the diameter of the vessel around a point, of which a section
/// farther away tells less: D / (1 + x / D) at a distance x from a section of diameter D. So a
/// throat counts by its vessel, and a thin vessel behind an aneurysm by itself.
std::vector<double> measure_units(const CenterlinePath& path, const std::vector<double>& diameter) {
  constexpr double kReach = 8.0;
  const std::size_t count = path.points.size();
  std::vector<double> unit = diameter;
  for (std::size_t j = 0; j < count; ++j) {
    const auto raise = [&](std::size_t i) {
      const double away = std::abs(path.abscissa[i] - path.abscissa[j]);
      const double left =
          away < kReach * diameter[j] ? diameter[j] / (1.0 + away / diameter[j]) : 0.0;
      unit[i] = std::max(unit[i], left);
      return left > 0.0;
    };
    for (std::size_t i = j; i < count && raise(i); ++i) {
    }
    for (std::size_t i = j; i-- > 0 && raise(i);) {
    }
  }
  // Where nothing is known near by, as at the nearest place.
  double last = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (unit[i] > 0.0)
      last = unit[i];
    else
      unit[i] = last;
  }
  for (std::size_t i = count; i-- > 0;) {
    if (unit[i] > 0.0)
      last = unit[i];
    else
      unit[i] = last > 0.0 ? last : 1.0;
  }
  return unit;
}

/// The measured stretches of a branch in cells, and the cell of each of its points.
FieldBranch cut_into_cells(const CenterlinePath& path, const Branch& branch,
                           const std::vector<double>& unit, ReferenceDiameter& reference) {
  FieldBranch field;
  field.daughters = branch.daughters;
  double position = 0.0, length = 0.0;
  FieldCell cell;  // sums over its points
  int count = 0;
  const auto close = [&] {
    if (count == 0) return;
    cell.log_diameter /= count;
    cell.position /= count;
    cell.abscissa_mm /= count;
    cell.weight = length;
    field.cells.push_back(cell);
    cell = {};
    length = 0.0;
    count = 0;
  };
  for (int k = branch.first; k <= branch.last; ++k) {
    const auto i = std::size_t(k);
    const std::size_t before = i > 0 ? i - 1 : i;
    const std::size_t after = std::min(i + 1, path.points.size() - 1);
    position += (path.abscissa[i] - path.abscissa[before]) / unit[i];
    reference.cell[i] = -1;
    if (reference.measured[i] <= 0.0) {
      close();
      continue;
    }
    const double stands_for_mm = 0.5 * (path.abscissa[after] - path.abscissa[before]);
    cell.log_diameter += std::log(reference.measured[i]);
    cell.position += position;
    cell.abscissa_mm += path.abscissa[i];
    cell.length_mm += stands_for_mm;
    ++count;
    length += stands_for_mm / unit[i];
    reference.cell[i] = int(field.cells.size());
    if (length >= kCell) close();
  }
  close();
  if (field.cells.empty()) field.cells.push_back({.position = 0.5 * position});
  field.length = position;
  return field;
}

/// Tells each cell how wide its sides are: the widest D for which there is a place before it and
/// one behind it that are both as wide, no farther apart than six D; or as wide as itself.
void set_sides(std::vector<FieldCell>& cells) {
  constexpr double kLongest = 6.0;
  for (FieldCell& cell : cells) cell.log_sides = cell.log_diameter;
  for (std::size_t first = 0; first < cells.size(); ++first) {
    const double reach = kLongest * std::exp(cells[first].log_diameter);
    for (std::size_t last = first + 2; last < cells.size(); ++last) {
      const double apart = cells[last].abscissa_mm - cells[first].abscissa_mm;
      if (apart > reach) break;
      const double both = std::min(cells[first].log_diameter, cells[last].log_diameter);
      if (apart > kLongest * std::exp(both)) continue;
      for (std::size_t c = first + 1; c < last; ++c)
        cells[c].log_sides = std::max(cells[c].log_sides, both);
    }
  }
}

/// A branch without its throats: the short stretches, a third narrower than both of their sides,
/// tell nothing of the vessel, whose width the sides show. So one stenosis changes nothing that is
/// told of the vessel before and behind it: long thin stretches are not its prolongation.
FieldBranch without_throats(FieldBranch branch) {
  constexpr double kThroat = 0.36, kShoulder = 0.1;  // e-folds: 30 % and 10 %
  auto& cells = branch.cells;
  const auto depth = [&](std::size_t c) { return cells[c].log_sides - cells[c].log_diameter; };
  for (std::size_t first = 0, end = 0; first < cells.size(); first = end + 1) {
    double deepest = 0.0;
    for (end = first; end < cells.size() && depth(end) >= kShoulder; ++end)
      deepest = std::max(deepest, depth(end));
    if (deepest < kThroat) continue;
    for (std::size_t c = first; c < end; ++c) cells[c].weight = 0.0;
  }
  return branch;
}

/// Takes the thread in which a line ends out of what the healthy width is told by: the last cells
/// while they are under a third as wide as the median of the branch, by length. Counted in its own
/// diameters a thread of a few mm is as long as the vessel before it.
void leave_out_thread(FieldBranch& branch) {
  constexpr double kThread = 1.0 / 3.0;
  if (!branch.daughters.empty()) return;
  std::vector<std::pair<double, double>> widths;
  for (const FieldCell& cell : branch.cells)
    if (cell.weight > 0.0) widths.emplace_back(cell.log_diameter, cell.length_mm);
  if (widths.empty()) return;
  const double most = weighted_quantile(std::move(widths), 0.5) + std::log(kThread);
  for (std::size_t c = branch.cells.size(); c-- > 0 && branch.cells[c].log_diameter < most;)
    branch.cells[c].weight = 0.0;
}

/// The standard deviation of normal errors whose magnitudes these are, by their lower quartile: up
/// to half of them may be no errors at all.
double deviation_of(std::vector<double> magnitudes) {
  constexpr double kQuartile = 0.3186;  // of a standard normal's magnitude
  if (magnitudes.size() < 4) return 0.0;
  const auto at = magnitudes.begin() + std::ptrdiff_t(magnitudes.size() / 4);
  std::nth_element(magnitudes.begin(), at, magnitudes.end());
  return *at / kQuartile;
}

/// The cell that lies nearest to a position, of those that tell something.
std::size_t nearest_cell(const std::vector<FieldCell>& cells, double position) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::max();
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const double away = std::abs(cells[c].position - position);
    if (cells[c].weight <= 0.0 || away >= least) continue;
    nearest = c;
    least = away;
  }
  return nearest;
}

/// An error of a diameter (ln) at a position, by its magnitude.
struct Roughness {
  double position, magnitude;
};

/// Second differences of the diameters over a lag, or less beside an end, as errors of one of them:
/// no taper changes them.
std::vector<Roughness> roughness_over(const std::vector<FieldCell>& cells, double lag) {
  std::vector<Roughness> rough;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (cells[c].weight <= 0.0) continue;
    const std::size_t before = nearest_cell(cells, cells[c].position - lag);
    const std::size_t after = nearest_cell(cells, cells[c].position + lag);
    if (before == c || after == c) continue;
    const double t = (cells[c].position - cells[before].position) /
                     (cells[after].position - cells[before].position);
    const double between = (1.0 - t) * cells[before].log_diameter + t * cells[after].log_diameter;
    rough.push_back({cells[c].position, std::abs(cells[c].log_diameter - between) /
                                            std::sqrt(1.0 + t * t + (1.0 - t) * (1.0 - t))});
  }
  return rough;
}

/// The standard deviation of errors that second differences over a lag show near each cell; 0 where
/// those cover less than some diameters.
std::vector<double> deviations_over(const std::vector<FieldCell>& cells, double lag,
                                    double least_covered) {
  constexpr double kReach = 8.0;
  const std::vector<Roughness> rough = roughness_over(cells, lag);
  std::vector<double> deviations;
  for (const FieldCell& cell : cells) {
    std::vector<double> near;
    for (const auto& [position, magnitude] : rough)
      if (std::abs(position - cell.position) <= kReach) near.push_back(magnitude);
    const bool is_covered = kCell * double(near.size()) >= least_covered;
    deviations.push_back(is_covered ? deviation_of(std::move(near)) : 0.0);
  }
  return deviations;
}

/// How much healthy diameters scatter around a cell: over a diameter, which no taper changes, nor a
/// single lesion in a vessel most of which is healthy.
void set_spreads(std::vector<FieldCell>& cells, double voxel) {
  constexpr double kLag = 1.0;
  const std::vector<double> deviations = deviations_over(cells, kLag, 0.0);
  for (std::size_t c = 0; c < cells.size(); ++c)
    cells[c].spread = std::max(std::clamp(deviations[c], kLeastSpread, kMostSpread),
                               kVoxelError * voxel / std::exp(cells[c].log_diameter));
}

/// Raises the spreads in a long vessel that waves: over a diameter slow waves look like taper. In a
/// short one, most of what a longer lag sees may be a lesion.
void add_waves(std::vector<FieldCell>& cells) {
  constexpr double kLag = 2.0, kLong = 9.0;  // diameters
  const std::vector<double> deviations = deviations_over(cells, kLag, kLong);
  for (std::size_t c = 0; c < cells.size(); ++c)
    cells[c].spread = std::max(cells[c].spread, std::min(deviations[c], kMostSpread));
}

ReferenceDiameter measure(const CenterlinePath& path) {
  ReferenceDiameter reference;
  const std::size_t count = path.points.size();
  reference.measured = measure_diameters(path);
  reference.diameter.assign(count, 0.0);
  reference.healthy.assign(count, 0);
  reference.branch.assign(count, -1);
  reference.cell.assign(count, -1);
  return reference;
}

/// The greatest healthy ln diameter that a branch can have by its own look: one that is seen over
/// many diameters shows its width somewhere, however diseased it is and whatever its forks say.
double greatest_own_width(const FieldBranch& field) {
  constexpr double kLong = 6.0, kWider = 0.1;  // diameters; e-folds
  double seen = 0.0, widest = std::numeric_limits<double>::lowest();
  for (const FieldCell& cell : field.cells) {
    seen += cell.weight;
    if (cell.weight > 0.0) widest = std::max(widest, cell.log_diameter);
  }
  return seen < kLong ? std::numeric_limits<double>::max() : widest + kWider;
}

/// Finds the field that explains the cells, and ln of the healthy diameter at each of them.
std::vector<std::vector<double>> explain(TreeReference& tree) {
  tree.field = HealthyField(tree.field_branches);
  std::vector<FieldBranch> branches;
  for (const FieldBranch& branch : tree.field_branches) branches.push_back(without_throats(branch));
  for (FieldBranch& branch : branches) add_waves(branch.cells);
  const HealthyField healthy(branches);
  std::vector<std::vector<double>> lines;
  for (std::size_t b = 0; b < tree.field_branches.size(); ++b) {
    const FieldBranch& field = tree.field_branches[b];
    std::vector<double> best;
    const double most = greatest_own_width(field);
    for (std::size_t c = 0; c < field.cells.size(); ++c)
      best.push_back(std::min(healthy.best(b, c), most));
    lines.push_back(accept_narrower_vessel(field, fit_healthy_line(field, best)));
  }
  return lines;
}

/// Gives the points of a branch their reference, from its line.
void fill_branch(const TreeReference& tree, std::size_t b, const std::vector<double>& line,
                 const std::vector<double>& unit, const CenterlineTree& lumen,
                 ReferenceDiameter& reference) {
  const FieldBranch& field = tree.field_branches[b];
  const CenterlinePath& path = lumen.paths[std::size_t(tree.branches[b].path)];
  double position = 0.0;
  for (int k = tree.branches[b].first; k <= tree.branches[b].last; ++k) {
    const auto i = std::size_t(k);
    if (i > 0) position += (path.abscissa[i] - path.abscissa[i - 1]) / unit[i];
    reference.branch[i] = int(b);
    reference.diameter[i] = std::exp(value_at(field, line, position));
    if (reference.measured[i] <= 0.0) continue;
    const double off = std::abs(std::log(reference.measured[i] / reference.diameter[i]));
    reference.healthy[i] =
        off <= kHealthy * field.cells[std::size_t(reference.cell[i])].spread ? 1 : 0;
  }
}

/// Lines that share a branch share what is on it.
void share_branch(const Branch& branch, const CenterlineTree& tree,
                  std::vector<ReferenceDiameter>& paths) {
  const auto owner = std::size_t(branch.path);
  const auto first = std::size_t(branch.first), last = std::size_t(branch.last);
  const Vec3& end = tree.paths[owner].points[last];
  for (std::size_t p = owner + 1; p < paths.size(); ++p) {
    const auto& points = tree.paths[p].points;
    if (points.size() <= last || !(points[last] == end)) continue;
    const auto copy = [&](auto& to, const auto& from) {
      std::copy(from.begin() + std::ptrdiff_t(first), from.begin() + std::ptrdiff_t(last) + 1,
                to.begin() + std::ptrdiff_t(first));
    };
    copy(paths[p].measured, paths[owner].measured);
    copy(paths[p].diameter, paths[owner].diameter);
    copy(paths[p].healthy, paths[owner].healthy);
    copy(paths[p].branch, paths[owner].branch);
    copy(paths[p].cell, paths[owner].cell);
  }
}

bool is_measured_anywhere(const std::vector<FieldBranch>& branches) {
  return std::any_of(branches.begin(), branches.end(), [](const FieldBranch& branch) {
    return std::any_of(branch.cells.begin(), branch.cells.end(),
                       [](const FieldCell& cell) { return cell.weight > 0.0; });
  });
}

/// Gives each path the median of its balls' diameters, where nothing tells of the healthy tree.
void take_own_widths(const CenterlineTree& tree, std::vector<ReferenceDiameter>& paths) {
  for (std::size_t p = 0; p < paths.size(); ++p) {
    std::vector<double> radii = tree.paths[p].inscribed_radius;
    paths[p].diameter.assign(tree.paths[p].points.size(), 2.0 * median(std::move(radii)));
  }
}

}  // namespace

TreeReference find_reference(const CenterlineTree& tree, double voxel_mm) {
  TreeReference result{find_branches(tree), {}, HealthyField({}), {}};
  std::vector<std::vector<double>> units;
  for (const CenterlinePath& path : tree.paths) {
    result.paths.push_back(measure(path));
    units.push_back(measure_units(path, result.paths.back().measured));
  }
  for (const Branch& branch : result.branches) {
    const auto p = std::size_t(branch.path);
    result.field_branches.push_back(
        cut_into_cells(tree.paths[p], branch, units[p], result.paths[p]));
    set_spreads(result.field_branches.back().cells, voxel_mm);
    set_sides(result.field_branches.back().cells);
    leave_out_thread(result.field_branches.back());
  }
  const std::vector<std::vector<double>> lines = explain(result);
  for (std::size_t b = 0; b < result.branches.size(); ++b) {
    const auto p = std::size_t(result.branches[b].path);
    fill_branch(result, b, lines[b], units[p], tree, result.paths[p]);
  }
  for (const Branch& branch : result.branches) share_branch(branch, tree, result.paths);
  if (!is_measured_anywhere(result.field_branches)) take_own_widths(tree, result.paths);
  return result;
}

}  // namespace angio::centerline
