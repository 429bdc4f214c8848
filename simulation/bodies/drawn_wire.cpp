#include "simulation/bodies/drawn_wire.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.hpp"
#include "simulation/bodies/guidewire.hpp"
#include "simulation/contact/contact_force.hpp"

namespace angio::simulation::detail {
namespace {

// A frame's Newton steps: what is left goes on in the next one.
constexpr int kMostSteps = 20, kStepsOnTheWay = 4;
// A frame's motion in so many parts at most, the wire settling after each.
constexpr int kMostParts = 24;
// It has settled where no node moves by this share of its radius.
constexpr double kSettled = 1e-3;
// The barrier begins at a gap of the wire's width, and bears the wire like this at half of that,
// where its surface meets the membrane. 0.1 mm of membrane's width then carries what bends a
// 0.014 inch wire from straight into a bend of 10 mm within 5 mm, EI / (10 * 5^2) = 3e4 uN/mm,
// three times over: where the membrane leaves it room, the whole wire lies inside, not its axis
// alone.
constexpr double kBearing = 10.0 * units::kPascalPerAtm;

int nearest_vertex(const std::vector<Vec3>& x, const Vec3& p) {
  const auto nearer = [&](const Vec3& a, const Vec3& b) { return distance(a, p) < distance(b, p); };
  return int(std::min_element(x.begin(), x.end(), nearer) - x.begin());
}

std::array<Vec3, 3> corners_of(const std::vector<Vec3>& x, const Triangle& t) {
  return {x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]};
}

bool holds(const Triangle& t, int vertex) {
  return std::find(t.begin(), t.end(), vertex) != t.end();
}

std::vector<Vec3> sum_of(const std::vector<Vec3>& x, double share, const std::vector<Vec3>& by) {
  std::vector<Vec3> sum = x;
  for (std::size_t i = 0; i < x.size(); ++i) sum[i] += share * by[i];
  return sum;
}

std::vector<Vec3> still(std::size_t count) { return std::vector<Vec3>(count); }

}  // namespace

DrawnWire::DrawnWire(const SimulationModel& model, const GuidewireOptions& options)
    : triangles_(model.balloon.triangles) {
  move_membrane(model.balloon.vertices);
  const std::vector<Vec3>& line = model.guidewire;
  if (line.size() < 2) return;
  poles_[0] = nearest_vertex(membrane_, line.front());
  poles_[1] = nearest_vertex(membrane_, line.back());
  wire_ = line;
  wire_.insert(wire_.begin(), 2.0 * line[0] - line[1]);
  wire_.push_back(2.0 * line.back() - line.end()[-2]);
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < wire_.size(); ++i) {
    rest_.push_back(std::max(distance(wire_[i], wire_[i + 1]), 1e-9));
    length += rest_.back();
  }
  bend_.resize(wire_.size());
  section_ = rod_section(options);
  section_.stretch = 4.0 * units::kPi * units::kPi * section_.bend / (length * length);
  reach_ = options.wire_diameter_mm;
  stiffness_ = barrier_stiffness(kBearing, reach_);
  inside_ = is_inside();
}

void DrawnWire::move_membrane(std::vector<Vec3> to) {
  membrane_ = std::move(to);
  boxes_ = boxes_of(membrane_, triangles_, 0.0);
  near_segments_.clear();
}

std::vector<Box> DrawnWire::segment_boxes(double reach, const std::vector<Vec3>& wire_by) const {
  std::vector<Box> segments(wire_.size() - 1);
  for (std::size_t s = 1; s + 2 < wire_.size(); ++s) {
    for (const std::size_t i : {s, s + 1})
      for (const Vec3& p : {wire_[i], wire_[i] + wire_by[i]}) segments[s].add(p);
    segments[s].grow(reach);
  }
  return segments;
}

std::vector<WirePair> DrawnWire::pairs_of(const std::vector<Box>& segments,
                                          const std::vector<Box>& membrane) const {
  constexpr std::size_t kRun = 6;  // segments: a triangle that misses their box misses them all
  const std::size_t end = wire_.size() - 2;
  std::vector<Box> runs;
  for (std::size_t s = 1; s < end; ++s) {
    if ((s - 1) % kRun == 0) runs.emplace_back();
    runs.back().add(segments[s].low);
    runs.back().add(segments[s].high);
  }
  std::vector<WirePair> pairs;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (!membrane[t].meets(runs[r])) continue;
      const std::size_t first = 1 + r * kRun;
      for (std::size_t s = first; s < std::min(first + kRun, end); ++s) {
        const bool meets_in_pole = (s == 1 && holds(triangles_[t], poles_[0])) ||
                                   (s + 1 == end && holds(triangles_[t], poles_[1]));
        if (!meets_in_pole && membrane[t].meets(segments[s])) pairs.push_back({int(s), int(t)});
      }
    }
  return pairs;
}

// Newton's steps ask for pairs several times each, of a wire that hardly moves: those near by are
// searched once, and kept until a segment leaves its box.
std::vector<WirePair> DrawnWire::pairs_within(double reach, const std::vector<Vec3>& wire_by) {
  const std::vector<Box> segments = segment_boxes(reach, wire_by);
  bool is_held = !near_segments_.empty();
  for (std::size_t s = 1; is_held && s + 2 < wire_.size(); ++s)
    is_held = near_segments_[s].holds(segments[s]);
  if (!is_held) {
    near_segments_ = segments;
    for (Box& box : near_segments_) box.grow(reach_);
    near_ = pairs_of(near_segments_, boxes_);
  }
  std::vector<WirePair> pairs;
  for (const WirePair& pair : near_)
    if (boxes_[std::size_t(pair.triangle)].meets(segments[std::size_t(pair.segment)]))
      pairs.push_back(pair);
  return pairs;
}

double DrawnWire::share_of(const WireMotion& motion, const std::vector<WirePair>& pairs) const {
  double least = 1.0;
  for (const WirePair& pair : pairs)
    least = std::min(least, free_share(motion, triangles_[std::size_t(pair.triangle)], pair));
  return least;
}

std::vector<DrawnWire::Bearing> DrawnWire::bearings(const std::vector<Vec3>& wire,
                                                    const std::vector<WirePair>& pairs) const {
  std::vector<Bearing> all;
  for (const WirePair& pair : pairs) {
    const auto s = std::size_t(pair.segment);
    const auto corners = corners_of(membrane_, triangles_[std::size_t(pair.triangle)]);
    const WireGap gap = wire_gap(wire[s], wire[s + 1], corners);
    if (gap.distance < reach_)
      all.push_back({s, gap, 0.5 * norm(cross(corners[1] - corners[0], corners[2] - corners[0]))});
  }
  return all;
}

double DrawnWire::share_of(const std::vector<Vec3>& wire_by) {
  return share_of({wire_, wire_by, membrane_, still(membrane_.size())}, pairs_within(0.0, wire_by));
}

double DrawnWire::share_of(const std::vector<Vec3>& wire_by,
                           const std::vector<Vec3>& membrane_by) const {
  std::vector<Box> on_the_way = boxes_;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const int v : triangles_[t])
      on_the_way[t].add(membrane_[std::size_t(v)] + membrane_by[std::size_t(v)]);
  return share_of({wire_, wire_by, membrane_, membrane_by},
                  pairs_of(segment_boxes(0.0, wire_by), on_the_way));
}

// By the membrane around each node: weights fall with the fourth power of the distance, so that
// what lies next to the wire counts, on all its sides.
//
// Source: Shepard, Proc. 23rd ACM National Conf. (1968) 517
std::vector<Vec3> DrawnWire::taken_along(const std::vector<Vec3>& membrane_by) const {
  std::vector<Vec3> by(wire_.size());
  for (std::size_t i = 2; i + 2 < wire_.size(); ++i) {
    double sum = 0.0;
    for (std::size_t v = 0; v < membrane_.size(); ++v) {
      const double apart = std::max(norm_squared(wire_[i] - membrane_[v]), 1e-12);
      const double weight = 1.0 / (apart * apart);
      by[i] += weight * membrane_by[v];
      sum += weight;
    }
    by[i] *= 1.0 / sum;
  }
  by[0] = by[1] = membrane_by[std::size_t(poles_[0])];
  by.back() = by.end()[-2] = membrane_by[std::size_t(poles_[1])];
  return by;
}

DrawnWire::Load DrawnWire::load(const std::vector<Vec3>& x) {
  const RodShape<double> shape{int(x.size()), rest_.data(), bend_.data()};
  Load load{rod_energy(shape, section_, x.data()),
            bearings(x, pairs_within(reach_, sum_of(x, -1.0, wire_)))};
  for (const Bearing& b : load.bearings)
    load.energy += stiffness_ * b.area * barrier(b.gap.distance, reach_).value;
  return load;
}

std::vector<Vec3> DrawnWire::newton_step(const std::vector<Bearing>& bearings) const {
  const int count = int(wire_.size());
  const RodShape<double> shape{count, rest_.data(), bend_.data()};
  std::vector<RodRow<double>> rows(wire_.size());
  add_rod(shape, section_, wire_.data(), rows.data());
  for (const auto& [s, gap, area] : bearings) {
    const Barrier<double> b = barrier(gap.distance, reach_);
    const double w[2] = {1.0 - gap.share, gap.share};
    const Mat3 along = outer((stiffness_ * area * b.curvature) * gap.direction, gap.direction);
    for (std::size_t k = 0; k < 2; ++k) {
      rows[s + k].force += (-stiffness_ * area * b.slope * w[k]) * gap.direction;
      rows[s + k].own += (w[k] * w[k]) * along;
    }
    rows[s].next += (w[0] * w[1]) * along;
  }
  for (const int held : {0, 1, count - 2, count - 1}) hold_node(held, rows.data());
  solve_rod(count, rows.data());
  std::vector<Vec3> by;
  for (const RodRow<double>& row : rows) by.push_back(row.force);
  return by;
}

// Newton's method with a line search, short of any gap.
void DrawnWire::settle(int most_steps) {
  constexpr int kHalvings = 12;
  Load before = load(wire_);
  for (int step = 0; step < most_steps; ++step) {
    const std::vector<Vec3> by = newton_step(before.bearings);
    double share = share_of(by);
    Load after = load(sum_of(wire_, share, by));
    for (int h = 0; h < kHalvings && !(after.energy < before.energy); ++h) {
      share *= 0.5;
      after = load(sum_of(wire_, share, by));
    }
    if (!(after.energy < before.energy)) return;
    wire_ = sum_of(wire_, share, by);
    before = std::move(after);
    double most = 0.0;
    for (const Vec3& move : by) most = std::max(most, share * norm(move));
    if (most < 0.5 * kSettled * reach_) return;
  }
}

bool DrawnWire::is_inside() {
  const auto none = still(wire_.size());
  for (const WirePair& pair : pairs_within(0.0, none)) {
    const auto s = std::size_t(pair.segment);
    if (runs_through(wire_[s], wire_[s + 1],
                     corners_of(membrane_, triangles_[std::size_t(pair.triangle)])))
      return false;
  }
  for (std::size_t i = 2; i + 2 < wire_.size(); ++i)
    if (!encloses(triangles_, membrane_, wire_[i])) return false;
  return true;
}

std::vector<Vec3> DrawnWire::follow(const std::vector<Vec3>& balloon) {
  if (wire_.empty()) return {};
  bool arrived = false;
  for (int part = 0; part < kMostParts && inside_ && !arrived; ++part) {
    const std::vector<Vec3> by = sum_of(balloon, -1.0, membrane_), along = taken_along(by);
    const double share = share_of(along, by);
    arrived = share == 1.0;
    wire_ = sum_of(wire_, share, along);
    move_membrane(arrived ? balloon : sum_of(membrane_, share, by));
    settle(arrived ? kMostSteps : kStepsOnTheWay);
  }
  if (!arrived) {
    wire_ = sum_of(wire_, 1.0, taken_along(sum_of(balloon, -1.0, membrane_)));
    move_membrane(balloon);
    inside_ = is_inside();
  }
  return {wire_.begin() + 1, wire_.end() - 1};
}

}  // namespace angio::simulation::detail
