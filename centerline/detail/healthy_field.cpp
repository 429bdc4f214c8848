#include "centerline/detail/healthy_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace angio::centerline {
namespace {

using Costs = std::vector<double>;  // of ln diameters on the grid

// Costs are natural logarithms of odds.
constexpr double kStep = 0.02;     // of the grid of ln diameters
constexpr double kStretch = 4.0;   // of a stretch that is not healthy,
constexpr double kOff = 0.7;       // and of each of its diameters;
constexpr double kWide = 3.0;      // of each, and each e-fold that it is wider than
constexpr double kWideFrom = 0.4;  // this: few ectasias are wider;
constexpr double kAneurysm = 2.0;  // of a stretch wider than that throughout, more than of another
constexpr double kMostNarrowing = 15.0, kMostWidening = 60.0;  // of a step without a fork
constexpr double kLaw = 7.0 / 3.0;                             // exponent of the fork's law
constexpr double kFork = 0.10;                                 // its sd (ln diameter),
constexpr double kForkTail = 15.0;  // and the cost of each e-fold far off
constexpr double kSwapped = 8.0;    // of another vessel than the one before being the trunk

/// A way in which a healthy branch may run: its taper per diameter, what a step to a narrower and
/// to a wider diameter costs (per e-fold), and what the way itself costs.
struct Course {
  double taper, narrowing, widening, cost;
};
constexpr std::array<Course, 6> kCourses{{{0.0, 15.0, 40.0, 0.0},
                                          {-0.025, 15.0, 40.0, 0.0},
                                          {-0.05, 15.0, 40.0, 1.0},
                                          {-0.1, 15.0, 40.0, 2.0},
                                          {0.0, 40.0, 15.0, 5.0},
                                          {0.025, 40.0, 15.0, 5.0}}};

/// What a step costs per e-fold, and at most.
struct Slope {
  double per_fold, most;
};

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
  [[nodiscard]] Costs ended() const {
    Costs costs = healthy;
    keep_lower(costs, off, kEnd);
    keep_lower(costs, aneurysm, kAneurysmEnd);
    return costs;
  }
};

/// The passes over one branch.
class BranchPass {
 public:
  BranchPass(const FieldBranch& branch, double low, std::size_t count)
      : branch_(branch), low_(low), count_(count) {}

  /// The cost at the branch's beginning of all that is on it and behind it.
  [[nodiscard]] Costs up(const Costs& behind) const {
    Costs result(count_, std::numeric_limits<double>::max());
    for (const Course& course : kCourses) {
      Labelled costs(shifted(behind, course.taper * branch_.length));
      for (std::size_t c = branch_.cells.size(); c-- > 0;) {
        add_misfit(costs, c, course);
        step_up(costs, course);
      }
      keep_lower(result, costs.ended(), course.cost);
    }
    return result;
  }

  /// The cost at the branch's end of all that is on it and before it.
  [[nodiscard]] Costs down(const Costs& before) const {
    Costs result(count_, std::numeric_limits<double>::max());
    for (const Course& course : kCourses) {
      Labelled costs(before);
      for (std::size_t c = 0; c < branch_.cells.size(); ++c) {
        step_down(costs, course);
        add_misfit(costs, c, course);
      }
      keep_lower(result, shifted(costs.ended(), -course.taper * branch_.length), course.cost);
    }
    return result;
  }

  /// The cost of the whole tree at each cell.
  [[nodiscard]] std::vector<Costs> whole(const Costs& before, const Costs& behind) const {
    const std::size_t cells = branch_.cells.size();
    std::vector<Costs> result(cells, Costs(count_, std::numeric_limits<double>::max()));
    for (const Course& course : kCourses) {
      std::vector<Labelled> from_before;
      Labelled costs(before);
      for (std::size_t c = 0; c < cells; ++c) {
        step_down(costs, course);
        add_misfit(costs, c, course);
        from_before.push_back(costs);
      }
      costs = Labelled(shifted(behind, course.taper * branch_.length));
      for (std::size_t c = cells; c-- > 0;) {
        Labelled& here = from_before[c];
        add(here.healthy, costs.healthy);
        add(here.off, costs.off);
        add(here.aneurysm, costs.aneurysm);
        keep_lower(here.healthy, here.off, 0.0);
        keep_lower(here.healthy, here.aneurysm, 0.0);
        keep_lower(result[c], shifted(here.healthy, -course.taper * branch_.cells[c].position),
                   course.cost);
        add_misfit(costs, c, course);
        step_up(costs, course);
      }
    }
    return result;
  }

 private:
  static void step_up(Labelled& costs, const Course& course) {
    costs.change();
    for (Costs* c : {&costs.healthy, &costs.off, &costs.aneurysm})
      allow_steps(*c, {course.narrowing, kMostNarrowing}, {course.widening, kMostWidening});
  }
  static void step_down(Labelled& costs, const Course& course) {
    costs.change();
    for (Costs* c : {&costs.healthy, &costs.off, &costs.aneurysm})
      allow_steps(*c, {course.widening, kMostWidening}, {course.narrowing, kMostNarrowing});
  }
  void add_misfit(Labelled& costs, std::size_t c, const Course& course) const {
    const FieldCell& cell = branch_.cells[c];
    if (cell.weight <= 0.0) return;
    const double scale = 0.5 * cell.weight / (cell.spread * cell.spread);
    const double expected = low_ + course.taper * cell.position;
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
  /// inlet.
  [[nodiscard]] Costs to(std::size_t x, const std::vector<Costs>& vessels) const {
    Costs result(count_, std::numeric_limits<double>::max());
    for (std::size_t trunk = 0; trunk < vessels.size(); ++trunk) {
      const double more = trunk == 0 ? 0.0 : kSwapped;
      Costs sum;  // of the others' flows
      for (std::size_t v = 0; v < vessels.size(); ++v)
        if (v != x && v != trunk) sum = sum.empty() ? vessels[v] : joined(sum, vessels[v]);
      if (trunk == x) {
        keep_lower(result, by_law(sum), more);
      } else {
        const Costs of_sum = by_law(vessels[trunk]);
        keep_lower(result, sum.empty() ? of_sum : parted(of_sum, sum), more);
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
  std::vector<Costs> up(branch_count), before(branch_count, Costs(count, 0.0)),
      behind(branch_count, Costs(count, 0.0));
  for (std::size_t b = branch_count; b-- > 0;) {
    if (!branches[b].daughters.empty()) {
      std::vector<Costs> vessels{Costs()};
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
    std::vector<Costs> vessels{pass.down(before[b])};
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
