#include "datasets/detail/truth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "datasets/detail/section.hpp"
#include "datasets/detail/vessel_plan.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kPointDistanceMm = 0.2;

/// A sample of one branch, as a point of a path.
struct Place {
  int branch = 0;
  int sample = 0;
};

/// A fork: where side branches leave their parent at one place, and from where on neither tube
/// meets the other. A sac (a branch that ends as a dome) makes a fork too: no branch owns the lumen
/// in front of its neck.
struct Fork {
  int id = 0;  ///< the first of the sides that leave there
  int side = 0;
  int parent = 0;
  int parent_sample = 0;
  int parent_apart_sample = 0;
  int side_apart_sample = 0;
};

/// The first sample of `branch` from which on its balls do not meet those of `other`.
int first_sample_apart(const Branch& branch, int from, const Branch& other, int other_from) {
  for (int s = from; s < branch.last_sample; ++s) {
    bool apart = true;
    for (int t = other_from; t <= other.last_sample && apart; ++t)
      apart = distance(branch.center[std::size_t(s)], other.center[std::size_t(t)]) >
              branch.radius[std::size_t(s)] + other.radius[std::size_t(t)];
    if (apart) return s;
  }
  return branch.last_sample;
}

std::vector<Fork> find_forks(const std::vector<Branch>& branches) {
  std::vector<Fork> forks;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& side = branches[b];
    if (side.parent < 0) continue;
    const Branch& parent = branches[std::size_t(side.parent)];
    Fork fork{int(b), int(b), side.parent, side.parent_sample, 0, 0};
    if (side.cut_at_end) {
      fork.parent_apart_sample =
          first_sample_apart(parent, side.parent_sample, side, side.first_sample);
      fork.side_apart_sample =
          first_sample_apart(side, side.first_sample, parent, side.parent_sample);
    } else {
      const double neck = side.radius.front() + side.blend_mm;
      const int reach = int(std::ceil(neck / parent.step_mm));
      fork.parent_sample = side.parent_sample - reach;
      fork.parent_apart_sample = side.parent_sample + reach;
    }
    for (Fork& other : forks) {
      if (other.parent != fork.parent || other.parent_sample != fork.parent_sample) continue;
      fork.id = other.id;
      fork.parent_apart_sample = other.parent_apart_sample =
          std::max(fork.parent_apart_sample, other.parent_apart_sample);
    }
    forks.push_back(fork);
  }
  return forks;
}

/// The narrowest sample of a lesion on its branch.
int narrowest_sample(const Anatomy& anatomy, const LesionSite& site) {
  const Branch& branch = anatomy.shape.branches()[std::size_t(site.branch)];
  const auto first = branch.radius.begin() + sample_at(branch, site.center_mm - site.length_mm / 2);
  const auto last = branch.radius.begin() + sample_at(branch, site.center_mm + site.length_mm / 2);
  return int(std::min_element(first, last + 1) - branch.radius.begin());
}

/// The samples of a branch that become points: evenly, with every fork and the narrowest place.
std::vector<int> point_samples(const Anatomy& anatomy, int b) {
  const std::vector<Branch>& branches = anatomy.shape.branches();
  const Branch& branch = branches[std::size_t(b)];
  const int stride = std::max(1, int(std::lround(kPointDistanceMm / branch.step_mm)));
  std::vector<int> samples;
  for (int s = branch.first_sample; s < branch.last_sample; s += stride) samples.push_back(s);
  samples.push_back(branch.last_sample);
  for (const LesionSite& site : anatomy.lesions)
    if (site.branch == b) samples.push_back(narrowest_sample(anatomy, site));
  for (const Branch& other : branches)
    if (other.parent == b) samples.push_back(other.parent_sample);
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return samples;
}

/// From the inlet to the end of branch `b`. A side branch begins at its fork's point, which is its
/// parent's already and is not repeated.
std::vector<Place> places_to(const Anatomy& anatomy, int b) {
  std::vector<Place> places;
  int last = anatomy.shape.branches()[std::size_t(b)].last_sample;
  for (int here = b; here >= 0;) {
    const Branch& branch = anatomy.shape.branches()[std::size_t(here)];
    std::vector<Place> stretch;
    for (int s : point_samples(anatomy, here))
      if (s <= last && (branch.parent < 0 || s > branch.first_sample)) stretch.push_back({here, s});
    places.insert(places.begin(), stretch.begin(), stretch.end());
    last = branch.parent_sample;
    here = branch.parent;
  }
  return places;
}

/// Names the piece of the tree that a place belongs to: a fork's common lumen (first: -1 - its id),
/// or a stretch of a branch between forks (first: the branch, second: forks passed on it).
std::pair<int, int> piece_at(const std::vector<Fork>& forks, const Place& place) {
  int passed = 0;
  for (const Fork& fork : forks) {
    if (place.branch == fork.side && place.sample < fork.side_apart_sample)
      return {-1 - fork.id, 0};
    if (place.branch != fork.parent || place.sample < fork.parent_sample) continue;
    if (place.sample < fork.parent_apart_sample) return {-1 - fork.id, 0};
    ++passed;
  }
  return {place.branch, passed};
}

std::vector<CenterlineTract> cut_into_tracts(const std::vector<Fork>& forks,
                                             const std::vector<Place>& places,
                                             std::map<std::pair<int, int>, int>& group_ids) {
  std::vector<CenterlineTract> tracts;
  for (int p = 0; p + 1 < int(places.size()); ++p) {
    const auto piece = piece_at(forks, places[std::size_t(p)]);
    const int group = group_ids.emplace(piece, int(group_ids.size())).first->second;
    if (tracts.empty() || tracts.back().group_id != group) {
      CenterlineTract tract;
      tract.first_point = p;
      tract.group_id = group;
      tract.tract_id = int(tracts.size());
      tract.blanking = piece.first < 0;
      tracts.push_back(tract);
    }
    tracts.back().last_point = p + 1;
  }
  return tracts;
}

/// Section areas at the points of every branch, by branch and sample.
std::map<std::pair<int, int>, double> measure_areas(const Anatomy& anatomy) {
  const std::vector<Branch>& branches = anatomy.shape.branches();
  std::vector<Place> places;
  for (std::size_t b = 0; b < branches.size(); ++b)
    for (int s : branches[b].cut_at_end ? point_samples(anatomy, int(b)) : std::vector<int>{})
      places.push_back({int(b), s});
  std::vector<double> area(places.size());
  parallel_for_uneven(std::ptrdiff_t(places.size()), [&](std::ptrdiff_t p) {
    const Place& place = places[std::size_t(p)];
    const Branch& branch = branches[std::size_t(place.branch)];
    area[std::size_t(p)] = section_area(anatomy.shape, branch.center[std::size_t(place.sample)],
                                        branch.tangent(place.sample));
  });
  std::map<std::pair<int, int>, double> areas;
  for (std::size_t p = 0; p < places.size(); ++p)
    areas[{places[p].branch, places[p].sample}] = area[p];
  return areas;
}

CenterlinePath build_path(const LumenShape& shape,
                          const std::map<std::pair<int, int>, double>& areas,
                          const std::vector<Place>& places) {
  CenterlinePath path;
  for (const Place& place : places) {
    const Branch& branch = shape.branches()[std::size_t(place.branch)];
    const double area = areas.at({place.branch, place.sample});
    path.points.push_back(branch.center[std::size_t(place.sample)]);
    path.inscribed_radius.push_back(branch.radius[std::size_t(place.sample)]);
    path.section_area.push_back(area);
    path.equivalent_radius.push_back(std::sqrt(area / units::kPi));
  }
  path.abscissa = arc_length(path.points);
  return path;
}

LesionTruth describe_lesion(const Anatomy& anatomy, const LesionSite& site,
                            const CenterlineTree& tree,
                            const std::vector<std::vector<Place>>& places) {
  const Branch& branch = anatomy.shape.branches()[std::size_t(site.branch)];
  const int narrowest = narrowest_sample(anatomy, site);
  LesionTruth lesion;
  lesion.lesion_point = branch.center[std::size_t(narrowest)];
  lesion.mld_mm = 2.0 * branch.radius[std::size_t(narrowest)];
  lesion.reference_diameter_mm = 2.0 * branch.healthy_mm[std::size_t(narrowest)];
  lesion.diameter_stenosis_percent = 100.0 * (1.0 - lesion.mld_mm / lesion.reference_diameter_mm);
  for (std::size_t path = places.size(); path-- > 0;)  // the longest path through it comes last
    for (std::size_t p = 0; p < places[path].size(); ++p)
      if (places[path][p].branch == site.branch && places[path][p].sample == narrowest) {
        lesion.lesion_path = int(path);
        lesion.lesion_abscissa_mm = tree.paths[path].abscissa[p];
        lesion.mla_mm2 = tree.paths[path].section_area[p];
      }
  return lesion;
}

void describe_lesions(const Anatomy& anatomy, const std::vector<std::vector<Place>>& places,
                      PhantomTruth& truth) {
  for (const LesionSite& site : anatomy.lesions)
    truth.lesions.push_back(describe_lesion(anatomy, site, truth.tree, places));
  std::stable_sort(truth.lesions.begin(), truth.lesions.end(),
                   [](const LesionTruth& a, const LesionTruth& b) {
                     return a.diameter_stenosis_percent > b.diameter_stenosis_percent;
                   });
  truth.has_lesion = true;
  static_cast<LesionTruth&>(truth) = truth.lesions.front();
}

/// Without a stenosis the narrowest place of the tree is an end; its diameter is its own reference.
void describe_healthy(PhantomTruth& truth) {
  double least = std::numeric_limits<double>::max();
  for (std::size_t path = 0; path < truth.tree.paths.size(); ++path) {
    const CenterlinePath& line = truth.tree.paths[path];
    for (std::size_t p = 0; p < line.points.size(); ++p)
      if (line.inscribed_radius[p] < least) {
        least = line.inscribed_radius[p];
        truth.lesion_path = int(path);
        truth.lesion_abscissa_mm = line.abscissa[p];
        truth.lesion_point = line.points[p];
        truth.mla_mm2 = line.section_area[p];
      }
  }
  truth.mld_mm = truth.reference_diameter_mm = 2.0 * least;
}

}  // namespace

PhantomTruth derive_truth(const Anatomy& anatomy) {
  const std::vector<Branch>& branches = anatomy.shape.branches();
  struct Line {
    std::vector<Place> places;
    CenterlinePath path;
  };
  const auto areas = measure_areas(anatomy);
  std::vector<Line> lines;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    if (!branches[b].cut_at_end) continue;  // a sac has no outlet
    lines.push_back({places_to(anatomy, int(b)), {}});
    lines.back().path = build_path(anatomy.shape, areas, lines.back().places);
  }
  std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) {
    return a.path.abscissa.back() > b.path.abscissa.back();
  });

  PhantomTruth truth;
  const std::vector<Fork> forks = find_forks(branches);
  std::map<std::pair<int, int>, int> group_ids;
  std::vector<std::vector<Place>> places;
  for (Line& line : lines) {
    line.path.id = int(truth.tree.paths.size());
    line.path.tracts = cut_into_tracts(forks, line.places, group_ids);
    truth.tree.paths.push_back(std::move(line.path));
    places.push_back(std::move(line.places));
  }
  anatomy.lesions.empty() ? describe_healthy(truth) : describe_lesions(anatomy, places, truth);
  return truth;
}

}  // namespace angio::datasets::detail
