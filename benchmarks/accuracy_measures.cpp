#include "benchmarks/accuracy_measures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "centerline/centerline.hpp"
#include "core/parallel.hpp"

namespace angio {

using datasets::PhantomTruth;
using datasets::detail::LumenShape;

namespace {

// ---- surface --------------------------------------------------------------------------------

/// Whether a point lies where a flat end, which blur rounds off, matters.
bool is_near_end(const LumenShape& shape, const Vec3& x) {
  for (const datasets::detail::FlatEnd& end : shape.flat_ends())
    if (distance(x, end.point) < 2.0 * end.radius) return true;
  return false;
}

// ---- line -----------------------------------------------------------------------------------

/// The nearest place on the true tree.
struct TruePlace {
  double distance = 1e9;
  double inscribed_radius = 0.0;
  double equivalent_radius = 0.0;
  bool counts = false;  ///< outside branchings and a diameter from the ends
};

bool is_blanked(const CenterlinePath& path, std::size_t point) {
  for (const CenterlineTract& tract : path.tracts)
    if (tract.blanking && int(point) >= tract.first_point && int(point) <= tract.last_point)
      return true;
  return false;
}

TruePlace nearest_true_place(const CenterlineTree& truth, const Vec3& point) {
  TruePlace best;
  for (const CenterlinePath& path : truth.paths) {
    const double abscissa = project(path, point);
    const CenterlineSample at = sample(path, abscissa);
    if (distance(at.point, point) >= best.distance) continue;
    const auto above = std::lower_bound(path.abscissa.begin(), path.abscissa.end(), abscissa);
    const std::size_t index =
        std::min(std::size_t(above - path.abscissa.begin()), path.points.size() - 1);
    const double from_end = std::min(abscissa, path.abscissa.back() - abscissa);
    best = {distance(at.point, point), at.inscribed_radius, at.equivalent_radius,
            from_end > 2.0 * at.inscribed_radius && !is_blanked(path, index)};
  }
  return best;
}

void compare_lines(const CenterlineTree& found, const CenterlineTree& truth, Accuracy& accuracy) {
  for (const CenterlinePath& path : found.paths)
    for (std::size_t p = 0; p < path.points.size(); ++p) {
      const TruePlace place = nearest_true_place(truth, path.points[p]);
      if (!place.counts) continue;
      accuracy.line_mm.push_back(place.distance);
      accuracy.radius_mm.push_back(measured_radius(path)[p] - place.inscribed_radius);
      accuracy.wall_mm.push_back(path.inscribed_radius[p] - place.inscribed_radius);
      accuracy.equivalent_mm.push_back(path.equivalent_radius[p] - place.equivalent_radius);
    }
}

/// A branch is found if a line ends near its outlet.
void compare_branches(const CenterlineTree& found, const CenterlineTree& truth,
                      Accuracy& accuracy) {
  const auto has_end = [](const CenterlineTree& tree, const CenterlinePath& path) {
    const double reach = 3.0 * path.inscribed_radius.back();
    return std::any_of(tree.paths.begin(), tree.paths.end(), [&](const CenterlinePath& other) {
      return std::min(distance(other.points.back(), path.points.back()),
                      distance(other.points.front(), path.points.back())) < reach;
    });
  };
  for (const CenterlinePath& path : truth.paths) accuracy.branches_missed += !has_end(found, path);
  for (const CenterlinePath& path : found.paths) {
    const bool is_true =
        std::any_of(truth.paths.begin(), truth.paths.end(), [&](const CenterlinePath& other) {
          return std::min(distance(other.points.back(), path.points.back()),
                          distance(other.points.front(), path.points.back())) <
                 3.0 * other.inscribed_radius.back();
        });
    accuracy.branches_invented += !is_true;
  }
}

void compare_lesions(const CenterlineTree& found, const PhantomTruth& truth, Accuracy& accuracy) {
  const std::vector<centerline::Lesion> lesions = centerline::find_lesions(found, {});
  std::vector<char> matched(lesions.size(), 0);
  for (const datasets::LesionTruth& lesion : truth.lesions) {
    const double reach = 1.5 * lesion.reference_diameter_mm;
    double least_radius = 1e9, least_area = 1e9;
    for (const CenterlinePath& path : found.paths)
      for (std::size_t p = 0; p < path.points.size(); ++p)
        if (distance(path.points[p], lesion.lesion_point) < reach) {
          least_radius = std::min(least_radius, measured_radius(path)[p]);
          least_area = std::min(least_area, path.section_area[p]);
        }
    accuracy.throat.push_back(2.0 * least_radius / lesion.mld_mm - 1.0);
    accuracy.throat_area.push_back(least_area / lesion.mla_mm2 - 1.0);
    bool is_listed = false;
    for (std::size_t l = 0; l < lesions.size(); ++l) {
      const CenterlinePath& path = found.paths[std::size_t(lesions[l].path_id)];
      if (lesions[l].is_stenosis &&
          distance(sample(path, lesions[l].abscissa_mm).point, lesion.lesion_point) < reach) {
        is_listed = true;
        matched[l] = 1;
      }
    }
    accuracy.lesions_missed += !is_listed && lesion.diameter_stenosis_percent > 32.0;
  }
  for (std::size_t l = 0; l < lesions.size(); ++l)
    accuracy.lesions_invented += lesions[l].is_stenosis && !matched[l];
}

}  // namespace

std::vector<double> surface_distances(const Volume<float>& level_set, const LumenShape& shape) {
  const VolumeGeometry& g = level_set.geometry;
  std::vector<std::vector<double>> of_slice(std::size_t(g.size[2]));
  parallel_for_uneven(g.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        for (int axis = 0; axis < 3; ++axis) {
          const int a = i + (axis == 0), b = j + (axis == 1), c = int(k) + (axis == 2);
          if (!g.contains(a, b, c)) continue;
          const double here = level_set.at(i, j, int(k)), there = level_set.at(a, b, c);
          if ((here < 0.0) == (there < 0.0)) continue;
          Vec3 index{double(i), double(j), double(k)};
          index[axis] += here / (here - there);
          const Vec3 point = g.lps_from_index(index);
          if (!is_near_end(shape, point))
            of_slice[std::size_t(k)].push_back(std::abs(shape.signed_distance(point)));
        }
  });
  std::vector<double> all;
  for (const auto& part : of_slice) all.insert(all.end(), part.begin(), part.end());
  return all;
}

void compare_volumes(const Volume<float>& level_set, const LumenShape& shape, Accuracy& accuracy) {
  const VolumeGeometry& g = level_set.geometry;
  struct Sums {
    double found = 0.0, truth = 0.0, both = 0.0, found_volume = 0.0, true_volume = 0.0;
  };
  std::vector<Sums> of_slice(std::size_t(g.size[2]));
  const double h = g.spacing.x;
  parallel_for_uneven(g.size[2], [&](std::ptrdiff_t k) {
    Sums& sums = of_slice[std::size_t(k)];
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i) {
        const double found = level_set.at(i, j, int(k));
        if (found > 3.0) continue;
        const double truth =
            shape.signed_distance(g.lps_from_index({double(i), double(j), double(k)}));
        sums.found += found < 0.0;
        sums.truth += truth < 0.0;
        sums.both += found < 0.0 && truth < 0.0;
        sums.found_volume += std::clamp(0.5 - found / h, 0.0, 1.0);
        sums.true_volume += std::clamp(0.5 - truth / h, 0.0, 1.0);
      }
  });
  Sums total;
  for (const Sums& s : of_slice) {
    total.found += s.found;
    total.truth += s.truth;
    total.both += s.both;
    total.found_volume += s.found_volume;
    total.true_volume += s.true_volume;
  }
  accuracy.dice = 2.0 * total.both / (total.found + total.truth);
  accuracy.volume = total.found_volume / total.true_volume - 1.0;
}

void compare_trees(const CenterlineTree& found, const PhantomTruth& truth, Accuracy& accuracy) {
  compare_lines(found, truth.tree, accuracy);
  compare_branches(found, truth.tree, accuracy);
  compare_lesions(found, truth, accuracy);
}

}  // namespace angio
