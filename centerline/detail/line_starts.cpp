#include "centerline/detail/line_starts.hpp"

#include <algorithm>
#include <cmath>

namespace angio::centerline {
namespace {

Polyline from_voxels(const LumenVoxels& lumen, const std::vector<int>& voxels) {
  Polyline line;
  for (const int v : voxels) line.push_back(lumen.position(v), double(lumen.depth[std::size_t(v)]));
  return line;
}

/// Goes straight on from the last point to the wall, or to the border of the data.
void extend_to_wall(Polyline& line, const Wall& wall, double dropped) {
  const double radius = line.radius.back();
  const Vec3 tip = line.points.back();
  const Vec3 direction = end_tangent(line, radius);
  const double longest = dropped + 2.0 * radius;
  const double step = 0.25 * wall.resolution();
  double reach = wall.ray(tip, direction, longest);
  if (reach >= longest && !wall.beyond_data(tip + reach * direction)) reach = dropped;
  while (reach > 0.0 && wall.beyond_data(tip + reach * direction)) reach -= step;
  if (reach <= step) return;
  const int count = std::max(1, int(std::ceil(reach / std::max(kWorkStep * radius, step))));
  for (int i = 1; i <= count; ++i) line.push_back(tip + (reach * i / count) * direction, radius);
}

/// Goes straight on to the middle of a rim.
void extend_to_rim(Polyline& line, const Vec3& rim, double step) {
  const double radius = line.radius.back();
  const Vec3 tip = line.points.back();
  const int count =
      std::max(1, int(std::ceil(distance(tip, rim) / std::max(kWorkStep * radius, step))));
  for (int i = 1; i <= count; ++i) line.push_back(tip + (double(i) / count) * (rim - tip), radius);
}

void cut_and_extend(Polyline& line, const Wall& wall, std::size_t keep,
                    const std::optional<Vec3>& rim) {
  if (keep < 2 || keep > line.points.size() || (keep == line.points.size() && !rim)) return;
  const double dropped = distance(line.points.back(), line.points[keep - 1]);
  line.resize(keep);
  if (rim)
    extend_to_rim(line, *rim, 0.25 * wall.resolution());
  else
    extend_to_wall(line, wall, dropped);
}

/// How far from the end of a chain its cap is felt: over twice the vessel's radius there.
double reach_of_cap(const Polyline& tip_first) {
  const auto cap = std::size_t(end_of_cap(tip_first.points, tip_first.radius));
  return 2.0 * tip_first.radius[cap];
}

/// A voxel path runs into the edge of the cap: replace its end by a straight piece.
void straighten_end(Polyline& line, const Wall& wall, std::size_t least_kept,
                    const std::optional<Vec3>& rim) {
  Polyline tip_first = line;
  reverse(tip_first);
  const auto cap = std::size_t(end_of_cap(tip_first.points, tip_first.radius));
  cut_and_extend(line, wall, std::max(line.points.size() - cap, least_kept), rim);
}

/// Paths through neighbouring voxels may run side by side in one vessel: a branch begins behind the
/// last of its voxels that is still on its parent's line, and not where the paths part.
/// @return the first voxel that is the branch's own
std::size_t leaves_line(const LumenVoxels& lumen, const Skeleton::Chain& chain,
                        std::size_t first_own, const Line& parent) {
  const double voxel = lumen.geometry.longest_spacing();
  const Polyline& line = parent.line;
  std::size_t own = first_own;
  for (std::size_t i = first_own; i < chain.voxels.size(); ++i) {
    const Vec3 p = lumen.position(chain.voxels[i]);
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < line.points.size(); ++k)
      if (norm_squared(line.points[k] - p) < norm_squared(line.points[nearest] - p)) nearest = k;
    const double away = distance(line.points[nearest], p);
    if (away > line.radius[nearest]) break;
    if (away < std::max(0.25 * line.radius[nearest], voxel)) own = i + 1;
  }
  return std::min(own, chain.voxels.size() - 1);
}

/// The first point of a line that what begins at another can feel: smoothing and its outliers reach
/// a dozen points, tangents and turns a few widths.
std::size_t first_felt(const Polyline& line, std::size_t end) {
  constexpr std::size_t kPoints = 32;
  constexpr double kWidths = 12.0;
  double length = 0.0, widest = line.extent[end];
  std::size_t first = end;
  while (first > 0 && (end - first < kPoints || length < kWidths * widest)) {
    --first;
    length += distance(line.points[first], line.points[first + 1]);
    widest = std::max(widest, line.extent[first]);
  }
  return first;
}

}  // namespace

std::vector<Plan> plan_lines(const LumenVoxels& lumen, const Skeleton& skeleton) {
  std::vector<int> owner(std::size_t(lumen.count()), -1);
  std::vector<Plan> plans;
  for (const Skeleton::Chain& chain : skeleton.chains) {
    const int index = int(plans.size());
    Plan plan;
    plan.chain = &chain;
    std::size_t& own = plan.first_own;
    while (own < chain.voxels.size() && owner[std::size_t(chain.voxels[own])] >= 0) ++own;
    if (index > 0 && own == chain.voxels.size()) continue;  // an outlet on another line
    plan.parent = own > 0 ? owner[std::size_t(chain.voxels[own - 1])] : (index > 0 ? 0 : -1);
    if (plan.parent >= 0) plan.generation = plans[std::size_t(plan.parent)].generation + 1;
    for (std::size_t i = own; i < chain.voxels.size(); ++i)
      owner[std::size_t(chain.voxels[i])] = index;
    plans.push_back(plan);
  }
  return plans;
}

Line start_line(const LumenVoxels& lumen, const Skeleton& skeleton, const Wall& wall) {
  Line work;
  work.line = from_voxels(lumen, skeleton.chains.front().voxels);
  work.course = PointRow(work.line.points);
  work.free_start = skeleton.starts_at_end;
  work.free_end = !skeleton.chains.front().ends_at_cut;
  work.start_rim = skeleton.inlet_rim;
  work.end_rim = skeleton.chains.front().rim;
  if (work.free_start) work.start_reach = reach_of_cap(work.line);
  reverse(work.line);
  if (work.free_end) work.end_reach = reach_of_cap(work.line);
  if (work.free_start) straighten_end(work.line, wall, 2, work.start_rim);
  reverse(work.line);
  if (work.free_end) straighten_end(work.line, wall, 2, work.end_rim);
  return work;
}

Line start_branch(const LumenVoxels& lumen, const Plan& plan, const Line& parent,
                  const Wall& wall) {
  const Skeleton::Chain& chain = *plan.chain;
  const std::size_t first_own = leaves_line(lumen, chain, plan.first_own, parent);
  const Vec3 junction = lumen.position(chain.voxels[first_own > 0 ? first_own - 1 : 0]);
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < parent.line.points.size(); ++i)
    if (distance(parent.line.points[i], junction) < distance(parent.line.points[nearest], junction))
      nearest = i;
  std::size_t leave = nearest;
  while (leave > 0 && distance(parent.line.points[leave], parent.line.points[nearest]) <
                          0.5 * parent.line.radius[nearest])
    --leave;
  Line work;
  work.parent = plan.parent;
  work.skipped = first_felt(parent.line, leave);
  work.shared = leave + 1 - work.skipped;
  work.free_end = !chain.ends_at_cut;
  const auto from = std::ptrdiff_t(work.skipped), to = std::ptrdiff_t(leave + 1);
  work.line = parent.line;
  work.line.resize(leave + 1);
  work.line.erase(0, work.skipped);
  work.area.assign(parent.area.begin() + from, parent.area.begin() + to);
  work.seen.assign(parent.seen.begin() + from, parent.seen.begin() + to);
  work.fitted.assign(parent.fitted.begin() + from, parent.fitted.begin() + to);
  const Vec3& first = work.line.points.front();
  std::size_t beside_first = first_own;
  for (std::size_t i = first_own; i-- > 0;)
    if (distance(lumen.position(chain.voxels[i]), first) <
        distance(lumen.position(chain.voxels[beside_first]), first))
      beside_first = i;
  std::vector<Vec3> course;
  for (std::size_t i = work.skipped == 0 ? 0 : beside_first; i < chain.voxels.size(); ++i)
    course.push_back(lumen.position(chain.voxels[i]));
  work.course = PointRow(std::move(course));
  for (std::size_t i = first_own; i < chain.voxels.size(); ++i)
    work.line.push_back(lumen.position(chain.voxels[i]),
                        double(lumen.depth[std::size_t(chain.voxels[i])]));
  if (work.free_end) {
    Polyline tip_first = from_voxels(lumen, chain.voxels);
    reverse(tip_first);
    work.end_reach = reach_of_cap(tip_first);
  }
  // The voxels inside the parent run along its middle, maybe past the mouth: go straight instead.
  work.line.erase(work.shared, std::min(first_outside(work, &parent), work.line.points.size() - 1));
  work.end_rim = chain.rim;
  if (work.free_end) straighten_end(work.line, wall, work.shared + 1, work.end_rim);
  return work;
}

void take_skipped(Line& work, const Line& parent) {
  const auto count = std::ptrdiff_t(work.skipped);
  const auto prepend = [&](auto& own, const auto& parents) {
    own.insert(own.begin(), parents.begin(), parents.begin() + count);
  };
  prepend(work.line.points, parent.line.points);
  prepend(work.line.radius, parent.line.radius);
  prepend(work.line.extent, parent.line.extent);
  prepend(work.area, parent.area);
  prepend(work.seen, parent.seen);
  prepend(work.fitted, parent.fitted);
  work.shared += work.skipped;
  work.skipped = 0;
}

namespace {

/// How many points of a line come before the cap that shuts its vessel, up to the last ball that
/// the sides hold: behind it the balls get smaller by a fifth of the way or more, and the axis
/// meets the wall within kAcross radii (a cap that slants by 55 degrees: 1.74). Where the sides
/// hold balls of one size over kHeld radii there is a tube, and no cap farther on. 0: no such cap.
std::size_t count_before_cap(const Polyline& line, const Wall& wall,
                             const WallDistance& distance_to_wall) {
  constexpr double kFall = 0.1, kReach = 4.0, kAcross = 2.0, kHeld = 1.5;  // radii
  const std::vector<double> s = arc_length(line.points);
  std::size_t last = line.points.size() - 1;
  double radius = 0.0, widest = 0.0, most = 0.0, held = 0.0;
  for (std::size_t i = line.points.size(); i-- > 0;) {
    const double here = distance_to_wall.at(line.points[i], line.radius[i]);
    const double to_tip = s.back() - s[i];
    widest = std::max(widest, here);
    if (to_tip > kReach * widest) break;
    if (here - kFall * to_tip <= most) {
      if (to_tip - held > kHeld * radius) break;
      continue;
    }
    most = here - kFall * to_tip;
    last = i;
    radius = here;
    held = to_tip;
  }
  if (last < 2 || last + 1 == line.points.size()) return 0;
  Polyline kept = line;
  kept.resize(last + 1);
  const double across = kAcross * radius;
  return wall.ray(line.points[last], end_tangent(kept, radius), across) < across ? last + 1 : 0;
}

}  // namespace

double redo_end(Polyline& line, const Wall& wall, const WallDistance& distance_to_wall,
                std::size_t least_kept, const std::optional<Vec3>& rim) {
  const std::vector<double> s = arc_length(line.points);
  const double zone = std::max(kEndZone * line.radius.back(), wall.resolution());
  std::size_t keep = line.points.size();
  const std::size_t before_cap = rim ? 0 : count_before_cap(line, wall, distance_to_wall);
  if (before_cap > least_kept) keep = before_cap;
  while (keep > least_kept && s.back() - s[keep - 1] < zone) --keep;
  cut_and_extend(line, wall, keep, rim);
  return before_cap > least_kept ? arc_length(line.points).back() - s[keep - 1] : 0.0;
}

std::size_t first_outside(const Line& branch, const Line* parent) {
  if (parent == nullptr) return 0;
  const std::vector<Vec3>& points = branch.line.points;
  for (std::size_t i = branch.shared; i < points.size(); ++i)
    if (!inside_tube(parent->line.points, parent->line.radius, 0, points[i])) return i;
  return points.size() - 1;
}

}  // namespace angio::centerline
