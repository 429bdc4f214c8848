#include "angiogram/working_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "angiogram/shadow.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/require.hpp"

namespace angio::angiogram {
namespace {

constexpr double kStep = 2.0;        // of the map [degrees]
constexpr double kSameCost = 0.5;    // [%]: views that nobody tells apart
constexpr double kSameWidth = 1.05;  // of the throat, likewise
constexpr double kSameAngle = 1e-9;  // [degrees]

/// From -limit to limit in even steps of about kStep, whole where the limit is; 0 among them.
std::vector<double> grid(double limit) {
  const int half = int(std::ceil(limit / kStep - 1e-9));
  std::vector<double> angles;
  for (int i = -half; i <= half; ++i) angles.push_back(std::clamp(kStep * i, -limit, limit));
  return angles;
}

ViewMap make_map(const SegmentShadow& shadow, const WorkingViewOptions& options) {
  ViewMap map{grid(options.primary_limit_degrees), grid(options.secondary_limit_degrees), {}};
  const std::size_t columns = map.primary_degrees.size();
  map.views.resize(columns * map.secondary_degrees.size());
  parallel_for_uneven(std::ptrdiff_t(map.secondary_degrees.size()), [&](std::ptrdiff_t row) {
    for (std::size_t column = 0; column < columns; ++column)
      map.views[std::size_t(row) * columns + column] =
          shadow.seen({map.primary_degrees[column], map.secondary_degrees[std::size_t(row)]});
  });
  return map;
}

double cost(const SeenSegment& view, const WorkingViewOptions& options) {
  return view.foreshortening_percent + options.overlap_weight * view.overlap_percent;
}

double least_cost(const std::vector<SeenSegment>& views, const WorkingViewOptions& options) {
  double least = std::numeric_limits<double>::infinity();
  for (const SeenSegment& view : views) least = std::min(least, cost(view, options));
  return least;
}

/// Of the views that cost no more than kSameCost above `least` the one nearest to the front, among
/// those in which the throat looks narrowest.
/// @param views  one of them costs that little
SeenSegment choose(const std::vector<SeenSegment>& views, double least,
                   const WorkingViewOptions& options) {
  const SeenSegment* chosen = nullptr;
  double steepness = 0.0, narrowest = std::numeric_limits<double>::infinity();
  for (const SeenSegment& view : views)
    if (cost(view, options) <= least + kSameCost) narrowest = std::min(narrowest, view.throat_mm);
  for (const SeenSegment& view : views) {
    if (cost(view, options) > least + kSameCost || view.throat_mm > kSameWidth * narrowest)
      continue;
    const double steep = angle_between(view.angles, {});
    if (chosen && steep > steepness - kSameAngle) continue;
    chosen = &view;
    steepness = steep;
  }
  ANGIO_EXPECT(chosen);
  return *chosen;
}

/// The same among the whole degrees around the map's.
SeenSegment choose_finely(const SegmentShadow& shadow, const ViewMap& map,
                          const WorkingViewOptions& options) {
  const double least = least_cost(map.views, options);
  const SeenSegment rough = choose(map.views, least, options);
  std::vector<SeenSegment> views{rough};
  const auto within = [](double angle, double limit) {
    return std::clamp(std::round(angle), -std::floor(limit), std::floor(limit));
  };
  for (int dp = -1; dp <= 1; ++dp)
    for (int ds = -1; ds <= 1; ++ds)
      views.push_back(shadow.seen(
          {within(rough.angles.primary_degrees + dp, options.primary_limit_degrees),
           within(rough.angles.secondary_degrees + ds, options.secondary_limit_degrees)}));
  return choose(views, std::min(least, least_cost(views, options)), options);
}

}  // namespace

void WorkingViewOptions::validate() const {
  require_within("view.primary_limit_degrees", primary_limit_degrees, 0.0, 180.0);
  require_within("view.secondary_limit_degrees", secondary_limit_degrees, 0.0, 90.0);
  require_within("view.overlap_weight", overlap_weight, 0.0, 100.0);
  require_within("view.second_view_degrees", second_view_degrees, 0.0, 90.0);
}

WorkingView find_working_view(const CenterlineTree& tree, const ViewedSegment& segment,
                              const WorkingViewOptions& options) {
  options.validate();
  const SegmentShadow shadow(tree, segment);
  WorkingView view;
  view.map = make_map(shadow, options);
  view.best = choose_finely(shadow, view.map, options);
  std::vector<SeenSegment> apart;
  for (const SeenSegment& other : view.map.views) {
    // A beam from behind shows the same, mirrored.
    const double angle = angle_between(view.best.angles, other.angles);
    if (std::min(angle, 180.0 - angle) >= options.second_view_degrees) apart.push_back(other);
  }
  view.has_second = !apart.empty();
  if (view.has_second) view.second = choose(apart, least_cost(apart, options), options);
  return view;
}

SeenSegment judge_view(const CenterlineTree& tree, const ViewedSegment& segment,
                       const CArmAngles& angles) {
  return SegmentShadow(tree, segment).seen(angles);
}

}  // namespace angio::angiogram
