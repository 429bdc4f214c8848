#include "pipeline/stages/treated_lumen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "core/surface_section.hpp"
#include "core/units.hpp"
#include "meshing/subdivide.hpp"

namespace angio::pipeline {
namespace {

// No section looks for its wall farther than four of the greatest radii away, three times over;
// what grows, grows no more than that (measure_lumen).
constexpr double kAroundInRadii = 12.0;

std::vector<int> points_near(const std::vector<Vec3>& points, const CenterlinePath& path,
                             const TreatedSpans& spans) {
  double radius = 0.0;
  std::vector<Vec3> line;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (path.abscissa[i] < spans.segment_first || path.abscissa[i] > spans.segment_last) continue;
    radius = std::max(radius, path.equivalent_radius[i]);
    line.push_back(path.points[i]);
  }
  const double most = kAroundInRadii * radius;
  std::vector<int> near;
  for (std::size_t v = 0; v < points.size(); ++v)
    if (std::any_of(line.begin(), line.end(),
                    [&](const Vec3& p) { return norm_squared(p - points[v]) <= most * most; }))
      near.push_back(int(v));
  return near;
}

std::vector<Triangle> triangles_among(const std::vector<Triangle>& triangles,
                                      const std::vector<int>& vertices) {
  const std::set<int> among(vertices.begin(), vertices.end());
  std::vector<Triangle> found;
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(found),
               [&](const Triangle& t) {
                 return std::all_of(t.begin(), t.end(), [&](int v) { return among.contains(v); });
               });
  return found;
}

/// Whether no point is farther from where it was than this [mm].
bool is_within(double most, const std::vector<Vec3>& points, const std::vector<Vec3>& before) {
  return std::equal(
      points.begin(), points.end(), before.begin(), before.end(),
      [&](const Vec3& p, const Vec3& q) { return norm_squared(p - q) <= most * most; });
}

/// A profile, at no place narrower than another of the same path. Where only the other has a
/// section there is none: it tells but the least that the lumen can be.
centerline::LumenProfile widened(centerline::LumenProfile profile,
                                 const centerline::LumenProfile& least) {
  for (std::size_t i = 0; i < profile.abscissa.size(); ++i) {
    const auto at =
        std::lower_bound(least.abscissa.begin(), least.abscissa.end(), profile.abscissa[i]);
    if (at == least.abscissa.end() || *at != profile.abscissa[i]) continue;
    const auto k = std::size_t(at - least.abscissa.begin());
    profile.inscribed_radius[i] = std::max(profile.inscribed_radius[i], least.inscribed_radius[k]);
    profile.section_area[i] = std::max(profile.section_area[i], least.section_area[k]);
  }
  return profile;
}

}  // namespace

TreatedSpans treated_spans(const nlohmann::json& placement) {
  const nlohmann::json& lesion = placement.at("lesion");
  const nlohmann::json& site = placement.at("site");
  const double proximal = lesion.at("proximal_mm").get<double>(),
               distal = lesion.at("distal_mm").get<double>(),
               throat = lesion.at("abscissa_mm").get<double>(),
               first = site.at("balloon_first_abscissa_mm").get<double>(),
               last = site.at("balloon_last_abscissa_mm").get<double>();
  // Without the balloon's ends, which taper.
  const double length = placement.at("balloon").at("length_mm").get<double>(),
               end = std::max(0.5 * (last - first - length), 0.0);
  TreatedSpans spans;
  spans.cylinder_first = first + end;
  spans.cylinder_last = last - end;
  spans.lesion_first = std::min(std::max(proximal, spans.cylinder_first), throat);
  spans.lesion_last = std::max(std::min(distal, spans.cylinder_last), throat);
  spans.segment_first = std::min(first, proximal);
  spans.segment_last = std::max(last, distal);
  spans.untreated_mm = spans.lesion_first - proximal + distal - spans.lesion_last;
  return spans;
}

TreatedLumen::TreatedLumen(TriangleMesh lumen, std::vector<int> region, CenterlinePath path,
                           const TreatedSpans& spans, double least_radius_mm, bool is_kept)
    : lumen_(std::move(lumen)), region_(std::move(region)), path_(std::move(path)), spans_(spans) {
  if (is_kept) halved_ = meshing::edges_to_halve(lumen_, least_radius_mm);
  near_ = points_near(points(lumen_.vertices), path_, spans_);
  near_triangles_ = triangles_among(lumen_.triangles, near_);
  find_shares();
  find_mistaken();
}

void TreatedLumen::find_mistaken() {
  constexpr double kMostOff = 0.5;     // of the segment's median radius
  constexpr double kMostOfTube = 1.1;  // of the area: a wider plane runs along a side branch
  constexpr double kMostCut = 0.25;    // of the sections: with more, the tube tells of none
  const centerline::LumenProfile seen = centerline::measure_lumen(
      points(lumen_.vertices), path_, spans_.segment_first, spans_.segment_last);
  if (seen.abscissa.empty()) return;
  // What cannot be seen before, beside another vessel or an organ, is seen by mistake later; but
  // in the lesion, which the balloon opens.
  for (const double s : path_.abscissa)
    if ((s < spans_.lesion_first || s > spans_.lesion_last) &&
        !std::binary_search(seen.abscissa.begin(), seen.abscissa.end(), s))
      mistaken_.insert(s);
  std::vector<double> radii;
  for (const double s : seen.abscissa) radii.push_back(sample(path_, s).equivalent_radius);
  const double most = kMostOff * median(radii);
  for (std::size_t i = 0; i < seen.abscissa.size(); ++i) {
    const double s = seen.abscissa[i];
    const auto cut = cut_at(path_, lumen_.vertices, s);
    if (cut && cut->area > kMostOfTube * seen.section_area[i]) branches_.insert(s);
    const bool is_cut = cut && !branches_.contains(s) && !tells(seen, i, *cut);
    if (is_cut) cut_.insert(s);
    if (cut && !is_cut && !branches_.contains(s)) told_.insert(s);
    const double area = is_cut ? cut->area : seen.section_area[i];
    if (std::sqrt(area / units::kPi) > radii[i] + most) mistaken_.insert(s);
  }
  if (double(cut_.size()) > kMostCut * double(seen.abscissa.size()))
    for (const double s : seen.abscissa)
      if (!branches_.contains(s)) cut_.insert(s);
  // What is left has to tell of the lesion; a single place may be told of by what is beside it.
  const auto is_left_between = [&](double first, double last) {
    return std::any_of(seen.abscissa.begin(), seen.abscissa.end(),
                       [&](double s) { return s >= first && s <= last && !mistaken_.contains(s); });
  };
  if (!is_left_between(spans_.segment_first, spans_.segment_last) ||
      (spans_.lesion_last > spans_.lesion_first &&
       !is_left_between(spans_.lesion_first, spans_.lesion_last)))
    mistaken_.clear();
  if (spans_.lesion_first == spans_.lesion_last) measure_single_place_in(seen);
}

std::optional<TreatedLumen::Cut> TreatedLumen::cut_at(const CenterlinePath& path,
                                                      const std::vector<Vec3>& lumen,
                                                      double abscissa) const {
  const CenterlineSample at = sample(path, abscissa);
  const auto section = nearest_section(near_triangles_, lumen, at.point, at.tangent);
  if (!section || !section->is_closed ||
      distance(section->middle, at.point) > std::sqrt(section->area / units::kPi))
    return std::nullopt;
  // The plane crosses two edges for every edge around.
  const double corners = std::max(0.5 * double(section->pieces.size()), 4.0);
  return Cut{section->area, inscribed_radius(*section), 1.0 / std::cos(units::kPi / corners)};
}

bool TreatedLumen::tells(const centerline::LumenProfile& seen, std::size_t i, const Cut& cut) {
  constexpr double kMostOffWidth = 0.05, kMostOffCircle = 0.10;
  const double width = std::sqrt(seen.section_area[i] / cut.area),
               circle = seen.inscribed_radius[i] / cut.inscribed_radius;
  return width < (1.0 + kMostOffWidth) * cut.chord_share &&
         circle < (1.0 + kMostOffCircle) * cut.chord_share && circle > 1.0 - kMostOffCircle;
}

centerline::LumenProfile TreatedLumen::with_cuts(const centerline::LumenProfile& seen,
                                                 const CenterlinePath& path,
                                                 const std::vector<Vec3>& lumen,
                                                 std::pair<double, double> between) const {
  std::set<double> places(seen.abscissa.begin(), seen.abscissa.end());
  for (const auto* known : {&told_, &cut_})
    for (auto at = known->lower_bound(between.first); at != known->upper_bound(between.second);
         ++at)
      if (!mistaken_.contains(*at)) places.insert(*at);
  struct Place {
    double abscissa;
    std::optional<std::size_t> seen;
    std::optional<Cut> cut;
  };
  std::vector<Place> all;
  for (const double s : places) {
    const auto at = std::lower_bound(seen.abscissa.begin(), seen.abscissa.end(), s);
    const bool is_seen = at != seen.abscissa.end() && *at == s;
    all.push_back({s,
                   is_seen ? std::optional(std::size_t(at - seen.abscissa.begin())) : std::nullopt,
                   std::nullopt});
  }
  parallel_for_uneven(std::ptrdiff_t(all.size()), [&](std::ptrdiff_t i) {
    Place& place = all[std::size_t(i)];
    if (!branches_.contains(place.abscissa)) place.cut = cut_at(path, lumen, place.abscissa);
  });
  centerline::LumenProfile profile;
  for (const Place& place : all) {
    const bool tube_tells = place.seen && !cut_.contains(place.abscissa) &&
                            (!place.cut || tells(seen, *place.seen, *place.cut));
    if (!tube_tells && !place.cut) continue;
    profile.abscissa.push_back(place.abscissa);
    profile.section_area.push_back(tube_tells ? seen.section_area[*place.seen] : place.cut->area);
    profile.inscribed_radius.push_back(tube_tells ? seen.inscribed_radius[*place.seen]
                                                  : place.cut->inscribed_radius);
  }
  return profile;
}

void TreatedLumen::measure_single_place_in(const centerline::LumenProfile& seen) {
  const auto away = [&](double s) { return std::abs(s - spans_.lesion_first); };
  std::optional<double> nearest;
  const centerline::LumenProfile left = centerline::without_disproved(with_cuts(
      without_mistaken(seen), path_, lumen_.vertices, {spans_.segment_first, spans_.segment_last}));
  for (const double s : left.abscissa)
    if (!nearest || away(s) < away(*nearest)) nearest = s;
  if (nearest) spans_.lesion_first = spans_.lesion_last = *nearest;
}

centerline::LumenProfile TreatedLumen::without_mistaken(const centerline::LumenProfile& all) const {
  centerline::LumenProfile seen;
  for (std::size_t i = 0; i < all.abscissa.size(); ++i) {
    if (mistaken_.contains(all.abscissa[i])) continue;
    seen.abscissa.push_back(all.abscissa[i]);
    seen.inscribed_radius.push_back(all.inscribed_radius[i]);
    seen.section_area.push_back(all.section_area[i]);
  }
  return seen;
}

void TreatedLumen::find_shares() {
  constexpr double kReach = 2.0;  // radii
  const std::vector<double> areas = vertex_areas(lumen_);
  shares_.resize(path_.points.size());
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    const double reach = kReach * path_.equivalent_radius[i];
    double sum = 0.0;
    for (const int v : near_) {
      if (std::size_t(v) >= areas.size()) break;  // the middles of edges
      const double d = distance(lumen_.vertices[std::size_t(v)], path_.points[i]) / reach;
      if (d >= 1.0) continue;
      shares_[i].push_back({v, areas[std::size_t(v)] * (1.0 - d * d)});
      sum += shares_[i].back().weight;
    }
    for (Share& share : shares_[i]) share.weight /= sum;
  }
}

CenterlinePath TreatedLumen::moved_path(const std::vector<Vec3>& lumen) const {
  CenterlinePath moved = path_;
  for (std::size_t i = 0; i < shares_.size(); ++i)
    for (const Share& share : shares_[i]) {
      const auto v = std::size_t(share.vertex);
      moved.points[i] += share.weight * (lumen[v] - lumen_.vertices[v]);
    }
  return moved;
}

std::vector<Vec3> TreatedLumen::points(const std::vector<Vec3>& lumen) const {
  std::vector<Vec3> all = lumen;
  for (const auto& [a, b] : halved_)
    all.push_back(0.5 * (all[std::size_t(a)] + all[std::size_t(b)]));
  if (near_.empty()) return all;
  std::vector<Vec3> near;
  near.reserve(near_.size());
  for (const int v : near_) near.push_back(all[std::size_t(v)]);
  return near;
}

centerline::LumenProfile TreatedLumen::profile_of(const std::vector<Vec3>& wall,
                                                  const std::vector<Vec3>& balloon,
                                                  std::pair<double, double> between,
                                                  const Measure& measure) const {
  const std::vector<Vec3> lumen = moved(wall);
  const CenterlinePath path = moved_path(lumen);
  const Profiles profiles = measure(points(lumen), balloon, path);
  centerline::LumenProfile seen = centerline::without_disproved(
      with_cuts(without_mistaken(profiles.wall), path, lumen, between));
  if (balloon.empty()) return seen;
  return widened(std::move(seen), profiles.balloon);
}

centerline::LumenProfile TreatedLumen::profile_between(double first, double last,
                                                       const std::vector<Vec3>& wall,
                                                       const std::vector<Vec3>& balloon) const {
  return profile_of(
      wall, balloon, {first, last},
      [&](std::vector<Vec3> points, const std::vector<Vec3>& inside, const CenterlinePath& path) {
        Profiles profiles;
        profiles.wall = centerline::measure_lumen(std::move(points), path, first, last);
        if (!inside.empty())
          profiles.balloon =
              centerline::measure_lumen(inside, path, std::max(first, spans_.cylinder_first),
                                        std::min(last, spans_.cylinder_last));
        return profiles;
      });
}

centerline::LumenProfile TreatedLumen::profile(const std::vector<Vec3>& wall,
                                               const std::vector<Vec3>& balloon) const {
  return profile_between(spans_.segment_first, spans_.segment_last, wall, balloon);
}

std::pair<double, double> TreatedLumen::round_lesion() const {
  const auto radius_at = [&](double abscissa) {
    const auto at = std::lower_bound(path_.abscissa.begin(), path_.abscissa.end() - 1, abscissa);
    return path_.equivalent_radius[std::size_t(at - path_.abscissa.begin())];
  };
  const double around = std::max(radius_at(spans_.lesion_first), radius_at(spans_.lesion_last));
  return {std::max(spans_.lesion_first - around, spans_.segment_first),
          std::min(spans_.lesion_last + around, spans_.segment_last)};
}

centerline::Tightest TreatedLumen::lesion(const std::vector<Vec3>& wall,
                                          const std::vector<Vec3>& balloon) const {
  return LesionFollower(*this).measure(wall, balloon);
}

TreatedLumen::LesionFollower::LesionFollower(const TreatedLumen& lumen)
    : lumen_(lumen),
      wall_follower_(lumen.round_lesion().first, lumen.round_lesion().second),
      balloon_follower_(std::max(lumen.round_lesion().first, lumen.spans_.cylinder_first),
                        std::min(lumen.round_lesion().second, lumen.spans_.cylinder_last)) {}

centerline::Tightest TreatedLumen::LesionFollower::measure(const std::vector<Vec3>& wall,
                                                           const std::vector<Vec3>& balloon) {
  // What inscribed radii change by is at most what points move by.
  constexpr double kStill = 2.5e-4;  // of the diameter
  const double still = kStill * tightest_.mld_mm;
  if (is_within(still, wall, wall_) && is_within(still, balloon, balloon_)) return tightest_;
  const auto follow = [&](std::vector<Vec3> points, const std::vector<Vec3>& inside,
                          const CenterlinePath& path) {
    Profiles profiles;
    const auto measure_balloon = [&] {
      if (!inside.empty()) profiles.balloon = balloon_follower_.measure(inside, path);
    };
    const auto measure_wall = [&] {
      profiles.wall = wall_follower_.measure(std::move(points), path);
    };
    do_both(beside_, measure_balloon, measure_wall);
    return profiles;
  };
  centerline::LumenProfile near = lumen_.profile_of(wall, balloon, lumen_.round_lesion(), follow);
  if (near.abscissa.empty()) near = lumen_.profile(wall, balloon);
  wall_ = wall;
  balloon_ = balloon;
  return tightest_ = centerline::tightest_between(near, lumen_.spans_.lesion_first,
                                                  lumen_.spans_.lesion_last);
}

TreatedMeasures TreatedLumen::measures(const centerline::LumenProfile& profile) const {
  return {centerline::tightest_between(profile, spans_.lesion_first, spans_.lesion_last),
          centerline::tightest_between(profile, spans_.segment_first, spans_.segment_last),
          std::nullopt};
}

std::optional<double> TreatedLumen::eccentricity(const std::vector<Vec3>& wall,
                                                 double abscissa) const {
  const std::vector<Vec3> lumen = moved(wall);
  const CenterlineSample at = sample(moved_path(lumen), abscissa);
  const auto section = nearest_section(lumen_.triangles, lumen, at.point, at.tangent);
  const auto widths = section ? section_widths(*section) : std::nullopt;
  return widths ? std::optional(widths->eccentricity()) : std::nullopt;
}

std::vector<Vec3> TreatedLumen::moved(const std::vector<Vec3>& wall) const {
  std::vector<Vec3> vertices = lumen_.vertices;
  for (std::size_t v = 0; v < wall.size(); ++v) vertices[std::size_t(region_[v])] = wall[v];
  return vertices;
}

TriangleMesh TreatedLumen::mesh(const std::vector<Vec3>& wall) const {
  return {moved(wall), lumen_.triangles};
}

std::string profile_csv(const centerline::LumenProfile& before,
                        const centerline::LumenProfile& peak,
                        const centerline::LumenProfile& after) {
  std::set<double> places;
  for (const auto* profile : {&before, &peak, &after})
    places.insert(profile->abscissa.begin(), profile->abscissa.end());
  const auto cells = [](const centerline::LumenProfile& profile, double place) -> std::string {
    const auto at = std::lower_bound(profile.abscissa.begin(), profile.abscissa.end(), place);
    if (at == profile.abscissa.end() || *at != place) return ",,";
    const auto i = std::size_t(at - profile.abscissa.begin());
    return fmt::format(",{:.5f},{:.5f}", 2.0 * profile.inscribed_radius[i],
                       2.0 * std::sqrt(profile.section_area[i] / units::kPi));
  };
  std::string text =
      "abscissa_mm,inscribed_diameter_before_mm,equivalent_diameter_before_mm,"
      "inscribed_diameter_after_mm,equivalent_diameter_after_mm,"
      "inscribed_diameter_peak_mm,equivalent_diameter_peak_mm\n";
  for (const double place : places)
    text += fmt::format("{:.4f}{}{}{}\n", place, cells(before, place), cells(after, place),
                        cells(peak, place));
  return text;
}

}  // namespace angio::pipeline
