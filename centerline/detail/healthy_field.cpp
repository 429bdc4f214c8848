#include "centerline/detail/healthy_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace angio::centerline {
namespace {

using Costs = std::vector<double>;  // of ln diameters on the grid

// Costs are natural logarithms of odds.
constexpr double kStep = 0.02;      // of the grid of ln diameters
constexpr double kStretch = 4.0;    // of a stretch that is not healthy,
constexpr double kOff = 0.7;        // and of each of its diameters;
constexpr double kWide = 3.0;       // of each, and each e-fold that it is wider than
constexpr double kWideFrom = 0.4;   // this: few ectasias are wider;
constexpr double kAneurysm = 2.0;   // of a stretch wider than that throughout, more than of another
constexpr double kLaw = 7.0 / 3.0;  // exponent of the fork's law
constexpr double kFork = 0.10;      // its sd (ln diameter),
constexpr double kForkTail = 15.0;  // and the cost of each e-fold far off
constexpr double kInlet = 4.0;      // of blood coming in by an end that is not the inlet,
constexpr double kNoInlet = 3.0;    // and of none coming in by the inlet
constexpr double kTurned = 1.0;     // of a fork whose trunk is another vessel than the one before
constexpr double kConfluence = 2.0;  // of vessels that join

/// What a step costs per e-fold, and at most.
struct Slope {
  double per_fold, most;
};

/// A way in which a healthy branch may run: its taper per diameter, what a step to a narrower and
/// to a wider diameter costs, and what the way itself costs.
struct Course {
  double taper;
  Slope narrowing, widening;
  double cost;
};
constexpr Slope kToNarrower{15.0, 15.0}, kToWider{40.0, 60.0};  // as blood runs
constexpr Slope kToNarrowerUpwards{40.0, 15.0}, kToWiderUpwards{15.0, 60.0};
constexpr std::array<Course, 6> kCourses{{{0.0, kToNarrower, kToWider, 0.0},
                                          {-0.025, kToNarrower, kToWider, 0.0},
                                          {-0.05, kToNarrower, kToWider, 1.0},
                                          {-0.1, kToNarrower, kToWider, 2.0},
                                          {0.0, kToNarrowerUpwards, kToWiderUpwards, 5.0},
                                          {0.025, kToNarrowerUpwards, kToWiderUpwards, 5.0}}};

/// Which way blood runs in a branch: from the inlet that the lines begin at, or towards it.
enum class Flow { along, against };

/// The same way as it looks from the branch's beginning.
Course seen(const Course& course, Flow flow) {
  if (flow == Flow::along) return course;
  return {-course.taper, course.widening, course.narrowing, course.cost};
}

/// Costs after a step that may be taken upwards or downwards.
void allow_steps(Costs& costs, Slope up, Slope down) {
  double least = costs.front();
  for (std::size_t i = 1; i < costs.size(); ++i) {
    least = std::min(least, costs[i]);
    costs[i] = std::min({costs[i], costs[i - 1] + up.per_fold * kStep, least + up.most});
  }
  least = costs.back();
  for (std::size_t i = costs.size() - 1; i-- > 0;) {
    least = std::min(least, costs[i]);
    costs[i] = std::min({costs[i], costs[i + 1] + down.per_fold * kStep, least + down.most});
  }
}

/// costs(x + offset) on the grid; beyond its ends, as at its ends.
Costs shifted(const Costs& costs, double offset) {
  Costs moved(costs.size());
  const double most = double(costs.size() - 1);
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const double x = std::clamp(double(i) + offset / kStep, 0.0, most);
    const auto a = std::min(std::size_t(x), costs.size() - 2);
    const double t = x - double(a);
    moved[i] = (1.0 - t) * costs[a] + t * costs[a + 1];
  }
  return moved;
}

void keep_lower(Costs& costs, const Costs& other, double more) {
  for (std::size_t i = 0; i < costs.size(); ++i) costs[i] = std::min(costs[i], other[i] + more);
}

void add(Costs& costs, const Costs& other) {
  for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += other[i];
}

/// Costs where blood runs along a branch and where it runs against it.
struct Directed {
  Costs along, against;

  Directed(Costs one, Costs other) : along(std::move(one)), against(std::move(other)) {}
  explicit Directed(std::size_t count = 0)
      : along(count, std::numeric_limits<double>::max()), against(along) {}
  void keep_lower(const Costs& one, const Costs& other, double more) {
    angio::centerline::keep_lower(along, one, more);
    angio::centerline::keep_lower(against, other, more);
  }
  [[nodiscard]] const Costs& of(Flow flow) const { return flow == Flow::along ? along : against; }
  [[nodiscard]] Costs& of(Flow flow) { return flow == Flow::along ? along : against; }
};

constexpr double kNever = 1e6;

/// What each of the two ends of a stretch costs that is not healthy.
constexpr double kEnd = 0.5 * kStretch, kAneurysmEnd = 0.5 * (kStretch + kAneurysm);

/// Costs while the vessel is healthy, while it is not, and while it is an aneurysm, whose width is
/// drawn once and not again at each of its diameters.
struct Labelled {
  Costs healthy, off, aneurysm;

  explicit Labelled(const Costs& costs) : healthy(costs), off(costs), aneurysm(costs) {
    for (double& cost : off) cost += kEnd;
    for (double& cost : aneurysm) cost += kAneurysmEnd;
  }
  void change() {
    const Costs before = healthy;
    keep_lower(healthy, off, kEnd);
    keep_lower(healthy, aneurysm, kAneurysmEnd);
    keep_lower(off, before, kEnd);
    keep_lower(aneurysm, before, kAneurysmEnd);
  }
  void keep_lower_of(const Labelled& other, double offset) {
    keep_lower(healthy, shifted(other.healthy, offset), 0.0);
    keep_lower(off, shifted(other.off, offset), 0.0);
    keep_lower(aneurysm, shifted(other.aneurysm, offset), 0.0);
  }
  [[nodiscard]] Costs ended() const {
    Costs costs = healthy;
    keep_lower(costs, off, kEnd);
    keep_lower(costs, aneurysm, kAneurysmEnd);
    return costs;
  }
};

/// The passes over one branch. Blood that comes in by both of its ends meets somewhere on it: up to
/// there it runs along, from there on against. Blood that leaves by both has no source.
class BranchPass {
 public:
  BranchPass(const FieldBranch& branch, double low, std::size_t count)
      : branch_(branch), low_(low), count_(count) {}

  /// The cost at the branch's beginning of all that is on it and behind it.
  [[nodiscard]] Directed up(const Directed& behind) const {
    Directed result(count_);
    for (const Course& course : kCourses) {
      Ways ways = behind_end(behind, course);
      for (std::size_t c = branch_.cells.size(); c-- > 0;) go_up(ways, c, course);
      result.keep_lower(ways.along.ended(), ways.against.ended(), course.cost);
    }
    return result;
  }

  /// The cost at the branch's end of all that is on it and before it.
  [[nodiscard]] Directed down(const Directed& before) const {
    Directed result(count_);
    for (const Course& course : kCourses) {
      Ways ways{Labelled(before.along), Labelled(before.against)};
      for (std::size_t c = 0; c < branch_.cells.size(); ++c) go_down(ways, c, course);
      const double taper = course.taper * branch_.length;
      result.keep_lower(shifted(ways.along.ended(), -taper), shifted(ways.against.ended(), taper),
                        course.cost);
    }
    return result;
  }

  /// The cost of the whole tree at each cell.
  [[nodiscard]] std::vector<Costs> whole(const Directed& before, const Directed& behind) const {
    const std::size_t cells = branch_.cells.size();
    std::vector<Costs> result(cells, Costs(count_, std::numeric_limits<double>::max()));
    for (const Course& course : kCourses) {
      std::vector<Ways> from_before;
      Ways ways{Labelled(before.along), Labelled(before.against)};
      for (std::size_t c = 0; c < cells; ++c) {
        go_down(ways, c, course);
        from_before.push_back(ways);
      }
      ways = behind_end(behind, course);
      for (std::size_t c = cells; c-- > 0;) {
        const double taper = course.taper * branch_.cells[c].position;
        meet_up(ways, c, course);
        keep_lower(result[c], shifted(with(from_before[c].along, ways.along), -taper), course.cost);
        keep_lower(result[c], shifted(with(from_before[c].against, ways.against), taper),
                   course.cost);
        leave_up(ways, c, course);
      }
    }
    return result;
  }

 private:
  /// A branch's costs while blood runs along it, and while it runs against it.
  struct Ways {
    Labelled along, against;
  };

  [[nodiscard]] Ways behind_end(const Directed& behind, const Course& course) const {
    const double taper = course.taper * branch_.length;
    return {Labelled(shifted(behind.along, taper)), Labelled(shifted(behind.against, -taper))};
  }
  void meet_up(Ways& ways, std::size_t c, const Course& course) const {
    const double apart = 2.0 * course.taper * branch_.cells[c].position;
    ways.along.keep_lower_of(ways.against, apart);
  }
  void leave_up(Ways& ways, std::size_t c, const Course& course) const {
    add_misfit(ways.along, c, course.taper);
    add_misfit(ways.against, c, -course.taper);
    step_up(ways.along, course);
    step_up(ways.against, seen(course, Flow::against));
  }
  void go_up(Ways& ways, std::size_t c, const Course& course) const {
    meet_up(ways, c, course);
    leave_up(ways, c, course);
  }
  void go_down(Ways& ways, std::size_t c, const Course& course) const {
    step_down(ways.along, course);
    step_down(ways.against, seen(course, Flow::against));
    const double apart = 2.0 * course.taper * branch_.cells[c].position;
    ways.against.keep_lower_of(ways.along, -apart);
    add_misfit(ways.along, c, course.taper);
    add_misfit(ways.against, c, -course.taper);
  }
  /// What comes from before and what comes from behind, together.
  static Costs with(const Labelled& before, const Labelled& behind) {
    Costs costs = before.healthy, off = before.off, aneurysm = before.aneurysm;
    add(costs, behind.healthy);
    add(off, behind.off);
    add(aneurysm, behind.aneurysm);
    keep_lower(costs, off, 0.0);
    keep_lower(costs, aneurysm, 0.0);
    return costs;
  }
  static void step_up(Labelled& costs, const Course& course) {
    costs.change();
    for (Costs* c : {&costs.healthy, &costs.off, &costs.aneurysm})
      allow_steps(*c, course.narrowing, course.widening);
  }
  static void step_down(Labelled& costs, const Course& course) {
    costs.change();
    for (Costs* c : {&costs.healthy, &costs.off, &costs.aneurysm})
      allow_steps(*c, course.widening, course.narrowing);
  }
  void add_misfit(Labelled& costs, std::size_t c, double taper) const {
    const FieldCell& cell = branch_.cells[c];
    if (cell.weight <= 0.0) return;
    const double scale = 0.5 * cell.weight / (cell.spread * cell.spread);
    const double expected = low_ + taper * cell.position;
    for (std::size_t i = 0; i < count_; ++i) {
      const double e = cell.log_diameter - (expected + double(i) * kStep);
      costs.healthy[i] += scale * e * e;
      costs.off[i] += cell.weight * (kOff + kWide * std::max(0.0, e - kWideFrom));
      costs.aneurysm[i] += e < kWideFrom ? kNever : cell.weight * kOff;
    }
  }

  const FieldBranch& branch_;
  double low_;
  std::size_t count_;
};

/// What it costs that the vessel before a fork is e-fold wider than its law says.
double fork_cost(double e) {
  const double x = std::abs(e);
  return x < kForkTail * kFork * kFork
             ? 0.5 * (x / kFork) * (x / kFork)
             : kForkTail * x - 0.5 * kForkTail * kForkTail * kFork * kFork;
}

/// The messages of a fork.
class Fork {
 public:
  explicit Fork(std::size_t count) : count_(count), more_(count), law_(count) {
    for (std::size_t k = 0; k < count; ++k) {
      more_[k] = int(std::lround(std::log1p(std::exp(-kLaw * kStep * double(k))) / kLaw / kStep));
      law_[k] = fork_cost(double(k) * kStep);
    }
  }

  /// Costs at vessel `x` of a fork from those of the others; the first is the one nearest to the
  /// inlet. Either the trunk feeds all others, or they feed it.
  [[nodiscard]] Directed to(std::size_t x, const std::vector<Directed>& vessels) const {
    Directed result(count_);
    for (std::size_t trunk = 0; trunk < vessels.size(); ++trunk)
      for (const bool is_fed_by_trunk : {true, false}) {
        const auto flow = [&](std::size_t v) {
          const bool comes_in = (v == trunk) == is_fed_by_trunk;
          return comes_in == (v == 0) ? Flow::along : Flow::against;
        };
        const double more = !is_fed_by_trunk ? kConfluence : trunk > 0 ? kTurned : 0.0;
        Costs sum;  // of the others' flows
        for (std::size_t v = 0; v < vessels.size(); ++v) {
          if (v == x || v == trunk) continue;
          const Costs& costs = vessels[v].of(flow(v));
          sum = sum.empty() ? costs : joined(sum, costs);
        }
        if (trunk == x) {
          keep_lower(result.of(flow(x)), by_law(sum), more);
        } else {
          const Costs of_sum = by_law(vessels[trunk].of(flow(trunk)));
          keep_lower(result.of(flow(x)), sum.empty() ? of_sum : parted(of_sum, sum), more);
        }
      }
    return result;
  }

 private:
  [[nodiscard]] std::size_t sum_of(std::size_t a, std::size_t b) const {
    const std::size_t wide = std::max(a, b), thin = std::min(a, b);
    return std::min(wide + std::size_t(more_[wide - thin]), count_ - 1);
  }
  [[nodiscard]] Costs joined(const Costs& a, const Costs& b) const {
    Costs result(count_, std::numeric_limits<double>::max());
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t k = 0; k < count_; ++k) {
        double& cost = result[sum_of(i, k)];
        cost = std::min(cost, a[i] + b[k]);
      }
    // Rounding leaves gaps.
    allow_steps(result, {2.0 * kForkTail, 1e9}, {2.0 * kForkTail, 1e9});
    return result;
  }
  [[nodiscard]] Costs parted(const Costs& sum, const Costs& other) const {
    Costs result(count_, std::numeric_limits<double>::max());
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t k = 0; k < count_; ++k)
        result[i] = std::min(result[i], sum[sum_of(i, k)] + other[k]);
    return result;
  }
  [[nodiscard]] Costs by_law(const Costs& other) const {
    Costs result(count_, std::numeric_limits<double>::max());
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t k = 0; k < count_; ++k)
        result[i] = std::min(result[i], other[k] + law_[i > k ? i - k : k - i]);
    return result;
  }

  std::size_t count_;
  std::vector<int> more_;  ///< by how much a sum is above its wider part
  std::vector<double> law_;
};

}  // namespace

HealthyField::HealthyField(const std::vector<FieldBranch>& branches) {
  double high = std::numeric_limits<double>::lowest();
  low_ = std::numeric_limits<double>::max();
  for (const FieldBranch& branch : branches)
    for (const FieldCell& cell : branch.cells) {
      if (cell.weight <= 0.0) continue;
      low_ = std::min(low_, cell.log_diameter);
      high = std::max(high, cell.log_diameter);
    }
  if (high < low_) low_ = high = 0.0;
  low_ -= 0.2;
  const auto count = std::size_t((high + 0.5 - low_) / kStep) + 2;
  const Fork fork(count);
  const std::size_t branch_count = branches.size();
  const Directed inlet{Costs(count, 0.0), Costs(count, kNoInlet)};
  const Directed end{Costs(count, 0.0), Costs(count, kInlet)};
  std::vector<Directed> up(branch_count), before(branch_count, inlet), behind(branch_count, end);
  for (std::size_t b = branch_count; b-- > 0;) {
    if (!branches[b].daughters.empty()) {
      std::vector<Directed> vessels(1);
      for (const int d : branches[b].daughters) vessels.push_back(up[std::size_t(d)]);
      behind[b] = fork.to(0, vessels);
    }
    up[b] = BranchPass(branches[b], low_, count).up(behind[b]);
  }
  cost_.resize(branch_count);
  for (std::size_t b = 0; b < branch_count; ++b) {
    const BranchPass pass(branches[b], low_, count);
    cost_[b] = pass.whole(before[b], behind[b]);
    if (branches[b].daughters.empty()) continue;
    std::vector<Directed> vessels{pass.down(before[b])};
    for (const int d : branches[b].daughters) vessels.push_back(up[std::size_t(d)]);
    for (std::size_t k = 1; k < vessels.size(); ++k)
      before[std::size_t(branches[b].daughters[k - 1])] = fork.to(k, vessels);
  }
}

double HealthyField::best(std::size_t branch, std::size_t cell) const {
  constexpr double kClose = 3.0;
  const Costs& costs = cost_[branch][cell];
  const auto at = std::min_element(costs.begin(), costs.end()) - costs.begin();
  double sum = 0.0, weights = 0.0;
  const auto add = [&](std::ptrdiff_t i) {
    const double more = costs[std::size_t(i)] - costs[std::size_t(at)];
    if (more > kClose) return false;
    weights += std::exp(-more);
    sum += std::exp(-more) * double(i - at);
    return true;
  };
  for (std::ptrdiff_t i = at; i < std::ptrdiff_t(costs.size()) && add(i); ++i) {
  }
  for (std::ptrdiff_t i = at; i-- > 0 && add(i);) {
  }
  return low_ + kStep * (double(at) + sum / weights);
}

double HealthyField::cost_below(std::size_t branch, std::size_t cell, double most) const {
  const Costs& costs = cost_[branch][cell];
  const double least = *std::min_element(costs.begin(), costs.end());
  const auto count =
      std::size_t(std::clamp((most - low_) / kStep + 1.0, 1.0, double(costs.size())));
  return *std::min_element(costs.begin(), costs.begin() + std::ptrdiff_t(count)) - least;
}

}  // namespace angio::centerline
