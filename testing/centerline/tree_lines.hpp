#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/detail/tracts.hpp"
#include "testing/centerline/random_tree.hpp"
#include "testing/centerline/shapes.hpp"

/// Lines of random trees: straight from the truth, or extracted from a level set; and the lesions
/// that are truly on them.
namespace angio::benchmarks {

constexpr double kNarrow = 20.0;  ///< percent: less is no true narrowing

/// Where a point of a path lies in the true tree.
struct Place {
  int branch = -1;
  int sample = 0;
};

struct Lines {
  CenterlineTree tree;
  std::vector<std::vector<Place>> places;  ///< of each path's points
};

/// Points a quarter of the radius apart, as the centreline stage puts them.
inline void append_points(const TrueTree& truth, int b, CenterlinePath& path,
                          std::vector<Place>& places) {
  const TrueBranch& branch = truth.branches[std::size_t(b)];
  double at = path.points.empty() ? 0.0 : 0.25 * branch.radius.front();
  for (std::size_t i = 0; i < branch.points.size(); ++i) {
    if (branch.abscissa[i] < at && i + 1 < branch.points.size()) continue;
    path.points.push_back(branch.points[i]);
    path.inscribed_radius.push_back(branch.radius[i]);
    places.push_back({b, int(i)});
    at = branch.abscissa[i] + 0.25 * branch.radius[i];
  }
}

inline void follow(const TrueTree& truth, int b, CenterlinePath path, std::vector<Place> places,
                   std::vector<std::pair<CenterlinePath, std::vector<Place>>>& found) {
  append_points(truth, b, path, places);
  const auto& daughters = truth.branches[std::size_t(b)].daughters;
  for (const int daughter : daughters) follow(truth, daughter, path, places, found);
  if (!daughters.empty()) return;
  path.abscissa = arc_length(path.points);
  found.emplace_back(std::move(path), std::move(places));
}

/// The radii that an extraction reads: errors that go together over a diameter, and some of each
/// point.
inline void add_noise(Draw& draw, const TrueTree& truth, Lines& lines) {
  const double relative = draw.between(0.0, 0.03), absolute = draw.between(0.0, 0.04);
  std::map<std::pair<int, int>, double> factor;
  for (std::size_t p = 0; p < lines.tree.paths.size(); ++p) {
    CenterlinePath& path = lines.tree.paths[p];
    double common = draw.normal(1.0);
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const Place at = lines.places[p][i];
      const double healthy = truth.branches[std::size_t(at.branch)].healthy[std::size_t(at.sample)];
      const double step = i > 0 ? path.abscissa[i] - path.abscissa[i - 1] : 0.0;
      const double keep = std::exp(-step / healthy);
      common = keep * common + std::sqrt(1.0 - keep * keep) * draw.normal(1.0);
      const double error = 0.9 * common + 0.3 * draw.normal(1.0);
      const auto [entry, is_new] = factor.try_emplace({at.branch, at.sample}, error);
      double& r = path.inscribed_radius[i];
      r = std::max(0.02 * healthy, r + entry->second * (relative * r + absolute));
    }
  }
}

inline void fill_sections(CenterlineTree& tree) {
  for (CenterlinePath& path : tree.paths)
    for (const double r : path.inscribed_radius) {
      path.section_area.push_back(units::kPi * r * r);
      path.equivalent_radius.push_back(r);
    }
}

inline Lines make_lines(const TrueTree& truth, unsigned seed) {
  std::vector<std::pair<CenterlinePath, std::vector<Place>>> found;
  follow(truth, 0, {}, {}, found);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.first.abscissa.back() > b.first.abscissa.back();
  });
  Lines lines;
  for (auto& [path, places] : found) {
    path.id = int(lines.tree.paths.size());
    lines.tree.paths.push_back(std::move(path));
    lines.places.push_back(std::move(places));
  }
  // Where branchings begin and end is told by the lumen, whose radii are exact.
  std::vector<std::vector<char>> is_tube;
  for (const CenterlinePath& path : lines.tree.paths) is_tube.emplace_back(path.points.size(), 1);
  centerline::assign_tracts(lines.tree, is_tube);
  Draw draw{std::mt19937(seed + 1000000U)};
  add_noise(draw, truth, lines);
  fill_sections(lines.tree);
  return lines;
}

// ---- lines from a level set -----------------------------------------------------------------

/// Whether two branches come nearer than their walls allow, away from the fork that they share.
inline bool touch(const TrueTree& truth, std::size_t a, std::size_t b, double gap) {
  const TrueBranch &one = truth.branches[a], &two = truth.branches[b];
  const bool is_parent = two.parent == int(a);
  const bool are_kin = is_parent || one.parent == two.parent;
  const auto is_at_fork = [&](const TrueBranch& branch, std::size_t i, bool at_end) {
    const double s = branch.abscissa[i];
    return are_kin && (at_end ? branch.abscissa.back() - s : s) < 6.0 * branch.healthy[i];
  };
  for (std::size_t i = 0; i < one.points.size(); i += 5) {
    if (is_at_fork(one, i, is_parent)) continue;
    for (std::size_t k = 0; k < two.points.size(); k += 5)
      if (!is_at_fork(two, k, false) &&
          distance(one.points[i], two.points[k]) < one.ectatic[i] + two.ectatic[k] + gap)
        return true;
  }
  return false;
}

inline bool touches_itself(const TrueTree& truth, double gap) {
  for (std::size_t a = 0; a < truth.branches.size(); ++a)
    for (std::size_t b = a + 1; b < truth.branches.size(); ++b)
      if (touch(truth, a, b, gap)) return true;
  return false;
}

/// The nearest sample of the true tree, in radii there.
inline Place find_place(const TrueTree& truth, const Vec3& point) {
  Place place;
  double least = std::numeric_limits<double>::max();
  for (std::size_t b = 0; b < truth.branches.size(); ++b)
    for (std::size_t i = 0; i < truth.branches[b].points.size(); ++i) {
      const double d = distance(truth.branches[b].points[i], point) / truth.branches[b].healthy[i];
      if (d >= least) continue;
      least = d;
      place = {int(b), int(i)};
    }
  return place;
}

/// The lines that the centreline stage finds in the tree's level set, three voxels to its least
/// radius, whose values err by a tenth of a voxel; nothing where vessels touch or the volume is too
/// large.
inline std::optional<Lines> extract_lines(const TrueTree& truth, unsigned seed) {
  constexpr double kMostVoxels = 2.5e7;
  const double spacing = truth.least_radius / 3.0;
  if (touches_itself(truth, 4.0 * spacing)) return std::nullopt;
  std::vector<test::Tube> tubes;
  for (const TrueBranch& branch : truth.branches) tubes.push_back({branch.points, branch.radius});
  const VolumeGeometry grid = test::grid_around(tubes, spacing, 4.0 * spacing);
  if (double(grid.size[0]) * grid.size[1] * grid.size[2] > kMostVoxels) return std::nullopt;
  Volume<float> level_set = test::level_set_of(tubes, grid);
  test::add_noise(level_set, 0.1 * spacing, seed);
  centerline::CenterlineOptions options;
  options.inlet_lps_mm = truth.branches.front().points.front();
  Lines lines{centerline::extract_centerline(level_set, options).tree, {}};
  for (const CenterlinePath& path : lines.tree.paths) {
    std::vector<Place> places;
    for (const Vec3& point : path.points) places.push_back(find_place(truth, point));
    lines.places.push_back(std::move(places));
  }
  return lines;
}

// ---- what is true ---------------------------------------------------------------------------

/// A stretch of a branch that is narrowed by at least kNarrow.
struct TrueLesion {
  int branch = 0, first = 0, last = 0;
  double percent = 0.0;
  bool measured = false;  ///< its tightest place is outside branchings
  bool is_whole = false;  ///< less than a diameter of its branch's measured length is healthy
  bool found = false;
};

inline double true_percent(const TrueBranch& branch, int i) {
  return 100.0 * (1.0 - branch.radius[std::size_t(i)] / branch.healthy[std::size_t(i)]);
}

/// Which samples of each branch no branching hides.
inline std::vector<std::vector<char>> find_measured(const TrueTree& truth, const Lines& lines) {
  std::vector<std::vector<char>> measured;
  for (const TrueBranch& branch : truth.branches) measured.emplace_back(branch.points.size(), 1);
  for (std::size_t p = 0; p < lines.tree.paths.size(); ++p)
    for (const CenterlineTract& tract : lines.tree.paths[p].tracts) {
      if (!tract.blanking) continue;
      for (int i = tract.first_point + 1; i <= tract.last_point; ++i) {
        const Place at = lines.places[p][std::size_t(i)],
                    before = lines.places[p][std::size_t(i) - 1];
        const int from = before.branch == at.branch ? before.sample : 0;
        for (int k = from; k < at.sample; ++k) measured[std::size_t(at.branch)][std::size_t(k)] = 0;
      }
    }
  return measured;
}

/// The length of a branch that is measured and narrowed by less than a tenth [mm].
inline double healthy_length(const TrueBranch& branch, const std::vector<char>& measured) {
  double length = 0.0;
  for (std::size_t i = 1; i < measured.size(); ++i)
    if (measured[i] != 0 && true_percent(branch, int(i)) < 10.0)
      length += branch.abscissa[i] - branch.abscissa[i - 1];
  return length;
}

inline std::vector<TrueLesion> find_true_lesions(const TrueTree& truth,
                                                 const std::vector<std::vector<char>>& measured) {
  std::vector<TrueLesion> lesions;
  for (std::size_t b = 0; b < truth.branches.size(); ++b) {
    const TrueBranch& branch = truth.branches[b];
    for (int i = 0; i < int(branch.radius.size()); ++i) {
      if (true_percent(branch, i) < kNarrow) continue;
      TrueLesion lesion{int(b), i, i};
      int tightest = i;
      for (; i < int(branch.radius.size()) && true_percent(branch, i) >= kNarrow; ++i)
        if (true_percent(branch, i) > true_percent(branch, tightest)) tightest = i;
      lesion.last = i - 1;
      lesion.percent = true_percent(branch, tightest);
      lesion.measured = measured[b][std::size_t(tightest)] != 0;
      lesion.is_whole = healthy_length(branch, measured[b]) < 2.0 * branch.healthy.front();
      lesions.push_back(lesion);
    }
  }
  return lesions;
}

}  // namespace angio::benchmarks
