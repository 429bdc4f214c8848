#include "reconstruction/detail/view_by_view.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/statistics.hpp"
#include "core/units.hpp"

namespace angio::reconstruction::detail {
namespace {

/// One frame of a run.
class OneFrame : public FrameReader {
 public:
  OneFrame(const FrameReader& all, int frame) : all_(all), frame_(frame) {}
  [[nodiscard]] std::vector<float> read(int /*first*/, int /*count*/) const override {
    return all_.read(frame_, 1);
  }

 private:
  const FrameReader& all_;
  int frame_;
};

/// A place moved across a view's rays onto its nearest line; none: that is too far.
std::optional<Vec3> on_line(const ViewLookup& lookup, const Vec3& place) {
  constexpr double kNear = 4.0;  // [mm]
  const LineNear near = lookup.at(place);
  if (!near.is_seen || near.pixel < 0 || near.distance_mm > kNear) return {};
  const angiogram::ConeBeamFrame& frame = lookup.picture().frame;
  const Vec3 on_detector = frame.place(near.pixel % frame.columns, near.pixel / frame.columns);
  return frame.source + lookup.see(place).depth * (on_detector - frame.source);
}

/// The points of a tree moved across a view's rays onto its lines, as far as those are near, and
/// blurred along themselves; shared points stay shared.
CenterlineTree on_lines(const CenterlineTree& tree, const ViewPicture& view) {
  constexpr int kRounds = 8;
  const ViewLookup lookup(view);
  CenterlineTree moved = tree;
  for (CenterlinePath& path : moved.paths) {
    std::vector<Vec3> by;
    for (const Vec3& point : path.points) {
      const auto place = on_line(lookup, point);
      by.push_back(place ? *place - point : Vec3{});
    }
    // From the inlet on, so that paths move alike where they are shared.
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<Vec3> was = by;
      for (std::size_t n = 1; n + 1 < by.size(); ++n)
        by[n] = 0.25 * was[n - 1] + 0.5 * was[n] + 0.25 * was[n + 1];
    }
    for (std::size_t n = 0; n < path.points.size(); ++n) path.points[n] += by[n];
    path.abscissa = arc_length(path.points);
  }
  for (std::size_t p = 1; p < tree.paths.size(); ++p) {
    std::size_t best = 0, with = 0;
    for (std::size_t q = 0; q < p; ++q) {
      std::size_t shared = 0;
      const auto &a = tree.paths[p].points, &b = tree.paths[q].points;
      while (shared < std::min(a.size(), b.size()) && a[shared] == b[shared]) ++shared;
      if (shared > best) {
        best = shared;
        with = q;
      }
    }
    std::copy_n(moved.paths[with].points.begin(), best, moved.paths[p].points.begin());
    moved.paths[p].abscissa = arc_length(moved.paths[p].points);
  }
  return moved;
}

/// Where rays pass nearest to each other, and how far apart: of two rays their distance, of more
/// twice the root mean square of theirs from there.
struct Meeting {
  Vec3 place;
  double off = 0.0;
};

Meeting meet(const std::vector<Vec3>& sources, const std::vector<Vec3>& through) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t v = 0; v < sources.size(); ++v) {
    const Vec3 ray = normalized(through[v] - sources[v]);
    const Eigen::Vector3d d{ray.x, ray.y, ray.z}, s{sources[v].x, sources[v].y, sources[v].z};
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    normal += across;
    right += across * s;
  }
  const Eigen::Vector3d found = normal.ldlt().solve(right);
  Meeting meeting{{found[0], found[1], found[2]}, 0.0};
  for (std::size_t v = 0; v < sources.size(); ++v) {
    const Vec3 ray = normalized(through[v] - sources[v]), to = meeting.place - sources[v];
    meeting.off += dot(to - dot(to, ray) * ray, to - dot(to, ray) * ray) / double(sources.size());
  }
  meeting.off = 2.0 * std::sqrt(meeting.off);
  return meeting;
}

/// A radius as one view has it.
struct SeenRadius {
  double log_radius = 0.0, relative_sd = 1.0;
};

/// What lies before or behind a vessel makes it wider, never narrower: of views that differ by more
/// than half of the narrowest those that are near it count.
/// @return radius and sd [mm]
std::pair<double, double> agreed_radius(const std::vector<SeenRadius>& seen) {
  const double most_apart = std::log(1.5);
  double narrowest = seen.front().log_radius;
  for (const SeenRadius& one : seen) narrowest = std::min(narrowest, one.log_radius);
  double sum = 0.0, weights = 0.0;
  for (const SeenRadius& one : seen) {
    if (one.log_radius > narrowest + most_apart) continue;
    const double weight = 1.0 / (one.relative_sd * one.relative_sd);
    sum += weight * one.log_radius;
    weights += weight;
  }
  const double radius = std::exp(sum / weights);
  return {radius, radius / std::sqrt(weights)};
}

/// One view's tree, fitted where that view sees the vessels.
TreeFit fit_one(const RotationalRun& run, double air, const ViewPicture& view, std::size_t index,
                const CenterlineTree& start, TreeFitOptions options, const Progress& progress) {
  const OneFrame picture(*run.pictures, int(index));
  std::optional<OneFrame> mask;
  if (run.masks) mask.emplace(*run.masks, int(index));
  RotationalRun one;
  one.frames = {view.frame};
  one.pictures = &picture;
  one.masks = mask ? &*mask : nullptr;
  one.relation = run.relation;
  // Depth is not told by one view: the fit creeps along it.
  constexpr int kMostSteps = 15;
  options.frame_shift_sd_mm = options.frame_turn_sd_degrees = 0.0;
  options.most_steps = std::min(options.most_steps, kMostSteps);
  if (!options.left_out.empty()) options.left_out = {std::move(options.left_out[index])};
  return fit_tree(one, air, on_lines(start, view), options, progress);
}

/// A path where the views' rays meet, with the radius that they agree on.
void combine(const std::vector<ViewPicture>& views, const std::vector<TreeFit>& fits,
             std::size_t index, CenterlinePath& path, std::vector<double>& sd) {
  constexpr double kLeastRadius = 0.02, kLeastRelative = 0.02;
  const std::vector<double> as_started = path.inscribed_radius;
  path.inscribed_radius.clear();
  path.section_area.clear();
  for (std::size_t n = 0; n < path.points.size(); ++n) {
    std::vector<Vec3> sources, through;
    std::vector<SeenRadius> seen;
    for (std::size_t v = 0; v < views.size(); ++v) {
      const CenterlinePath& own = fits[v].tree.paths[index];
      sources.push_back(views[v].frame.source);
      through.push_back(own.points[n]);
      if (!(fits[v].contrast_per_mm.front() > 0.0)) continue;
      const double radius = std::max(own.equivalent_radius[n], kLeastRadius);
      seen.push_back(
          {std::log(radius), std::max(fits[v].radius_sd[index][n] / radius, kLeastRelative)});
    }
    path.points[n] = meet(sources, through).place;
    const auto [radius, own_sd] =
        seen.empty() ? std::pair{as_started[n], as_started[n]} : agreed_radius(seen);
    path.inscribed_radius.push_back(radius);
    path.section_area.push_back(units::kPi * radius * radius);
    sd.push_back(own_sd);
  }
  path.tube_radius = path.equivalent_radius = path.inscribed_radius;
  path.abscissa = arc_length(path.points);
}

}  // namespace

double view_skew(const std::vector<ViewPicture>& views, const CenterlineTree& tree) {
  std::vector<ViewLookup> lookups;
  std::vector<Vec3> sources;
  for (const ViewPicture& view : views) {
    lookups.emplace_back(view);
    sources.push_back(view.frame.source);
  }
  std::vector<double> off;
  for (const CenterlinePath& path : tree.paths)
    for (const Vec3& point : path.points) {
      std::vector<Vec3> through;
      for (const ViewLookup& lookup : lookups)
        if (const auto place = on_line(lookup, point)) through.push_back(*place);
      if (through.size() == views.size()) off.push_back(meet(sources, through).off);
    }
  return off.empty() ? 0.0 : median(std::move(off));
}

TreeFit measure_view_by_view(const RotationalRun& run, double air,
                             const std::vector<ViewPicture>& views, const CenterlineTree& start,
                             const TreeFitOptions& options, const Progress& progress) {
  std::vector<TreeFit> fits;
  TreeFit all;
  all.tree = start;
  all.converged = true;
  all.correlation = 0.0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    fits.push_back(fit_one(run, air, views[v], v, start, options,
                           part(progress, double(v) / double(views.size()),
                                (double(v) + 1.0) / double(views.size()))));
    const double share = 1.0 / double(views.size());
    all.frames.push_back(views[v].frame);
    all.contrast_per_mm.push_back(fits[v].contrast_per_mm.front());
    all.noise += share * fits[v].noise;
    all.correlation += share * fits[v].correlation;
    all.blur_pixels += share * fits[v].blur_pixels;
    all.steps = std::max(all.steps, fits[v].steps);
    all.converged = all.converged && fits[v].converged;
  }
  for (std::size_t p = 0; p < all.tree.paths.size(); ++p)
    combine(views, fits, p, all.tree.paths[p], all.radius_sd.emplace_back());
  return all;
}

}  // namespace angio::reconstruction::detail
