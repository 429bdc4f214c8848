#include "centerline/detail/tracts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "centerline/detail/polyline.hpp"

namespace angio::centerline {
namespace {

/// The first point of `line` behind the shared ones that is outside the tube of `other`.
int find_exit(const CenterlinePath& line, const CenterlinePath& other, int shared) {
  const int last = int(line.points.size()) - 1;
  // The tube begins well before the branching, so that points beside it still count as inside.
  const int from = std::max(0, shared - 40);
  for (int i = shared; i < last; ++i)
    if (!inside_tube(other.points, other.inscribed_radius, std::size_t(from),
                     line.points[std::size_t(i)]))
      return i;
  return last;
}

/// From where on a line's own vessel is seen all round: there it has left the mouth that it came
/// through. At most a diameter behind the exit, else the exit itself.
int find_own_vessel(const CenterlinePath& line, const std::vector<char>& is_tube, int exit) {
  constexpr double kMost = 2.0;  // radii
  std::size_t own = std::size_t(exit);
  while (own + 1 < line.points.size() && is_tube[own] == 0) ++own;
  const double length = line.abscissa[own] - line.abscissa[std::size_t(exit)];
  return is_tube[own] != 0 && length <= kMost * line.inscribed_radius[own] ? int(own) : exit;
}

/// The last point upstream of `exit` whose sphere does not reach beyond `exit`.
int one_sphere_upstream(const CenterlinePath& line, int exit) {
  const Vec3 end = line.points[std::size_t(exit)];
  for (int i = exit; i > 0; --i)
    if (distance(line.points[std::size_t(i)], end) >= line.inscribed_radius[std::size_t(i)])
      return i;
  return 0;
}

struct Interval {
  int first, last;
};

class Splitter {
 public:
  Splitter(const CenterlineTree& tree, const std::vector<std::vector<char>>& is_tube)
      : tree_(tree), count_(tree.paths.size()), shared_(count_ * count_), exit_(count_ * count_) {
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = 0; j < i; ++j)
        shared_entry(i, j) = shared_entry(j, i) = count_shared(tree.paths[i], tree.paths[j]);
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = 0; j < count_; ++j)
        if (i != j)
          exit_entry(i, j) = find_own_vessel(tree.paths[i], is_tube[i],
                                             find_exit(tree.paths[i], tree.paths[j], shared(i, j)));
  }

  /// The branchings on one path, from the inlet on, without overlap.
  [[nodiscard]] std::vector<Interval> branchings(std::size_t i) {
    std::map<int, int> by_parting;  // where they part: the last exit
    for (std::size_t j = 0; j < count_; ++j) {
      if (j == i) continue;
      int& last = by_parting[shared(i, j)];
      last = std::max(last, exit(i, j));
    }
    std::vector<Interval> merged;
    for (const auto& [parting, last] : by_parting) {
      const Interval next{start_of(i, parting), last};
      if (!merged.empty() && next.first <= merged.back().last)
        merged.back().last = std::max(merged.back().last, next.last);
      else
        merged.push_back(next);
    }
    return merged;
  }

  [[nodiscard]] int shared(std::size_t i, std::size_t j) const { return shared_[i * count_ + j]; }

 private:
  int& shared_entry(std::size_t i, std::size_t j) { return shared_[i * count_ + j]; }
  int& exit_entry(std::size_t i, std::size_t j) { return exit_[i * count_ + j]; }
  [[nodiscard]] int exit(std::size_t i, std::size_t j) const { return exit_[i * count_ + j]; }

  /// Where the branching begins at which path i and others part: the same for all of them.
  [[nodiscard]] int start_of(std::size_t i, int parting) {
    std::size_t first_line = 0;
    while (first_line < i && shared(i, first_line) < parting) ++first_line;
    const auto [known, is_new] = start_of_branching_.try_emplace({first_line, parting}, 0);
    if (!is_new) return known->second;
    int& start = known->second = std::max(parting - 1, 0);
    for (std::size_t a = 0; a < count_; ++a) {
      if (a != i && shared(i, a) < parting) continue;
      for (std::size_t b = 0; b < count_; ++b)
        if (a != b && shared(a, b) == parting && (b == i || shared(i, b) >= parting))
          start = std::min(start, one_sphere_upstream(tree_.paths[a], exit(a, b)));
    }
    return start;
  }

  const CenterlineTree& tree_;
  std::size_t count_;
  std::vector<int> shared_, exit_;
  std::map<std::pair<std::size_t, int>, int>
      start_of_branching_;  // its first line, where they part
};

/// The stretches of equal flags.
std::vector<Interval> find_runs(const std::vector<char>& flags, char value) {
  std::vector<Interval> runs;
  for (int i = 0; i < int(flags.size()); ++i) {
    if (flags[std::size_t(i)] != value) continue;
    if (runs.empty() || runs.back().last + 1 < i) runs.push_back({i, i});
    runs.back().last = i;
  }
  return runs;
}

double widest_radius(const CenterlinePath& path, const Interval& some) {
  const auto begin = path.inscribed_radius.begin();
  return *std::max_element(begin + some.first, begin + some.last + 1);
}

double length_of(const CenterlinePath& path, const Interval& some) {
  return path.abscissa[std::size_t(some.last)] - path.abscissa[std::size_t(some.first)];
}

/// What is shorter is not blanked [radii].
constexpr double kLong = 3.0;

/// The stretch with as much of the path on both of its sides as it is long.
Interval with_sides(const CenterlinePath& path, const Interval& some) {
  const double length = length_of(path, some);
  const std::vector<double>& s = path.abscissa;
  Interval wider = some;
  while (wider.first > 0 && s[std::size_t(some.first)] - s[std::size_t(wider.first - 1)] <= length)
    --wider.first;
  while (wider.last + 1 < int(s.size()) &&
         s[std::size_t(wider.last + 1)] - s[std::size_t(some.last)] <= length)
    ++wider.last;
  return wider;
}

/// The stretches of a path, off its tips and branchings, where no tube was seen. What is short
/// against the vessel beside it is none: a throat of few triangles.
std::vector<Interval> find_gaps(const CenterlinePath& path, const std::vector<char>& is_tube,
                                const std::vector<Interval>& branchings) {
  constexpr double kTip = 2.0;  // radii
  std::vector<Interval> gaps;
  for (const Interval& gap : find_runs(is_tube, 0)) {
    const double radius = widest_radius(path, gap);
    const double first = path.abscissa[std::size_t(gap.first)];
    const double last = path.abscissa[std::size_t(gap.last)];
    const bool is_at_tip = first < kTip * radius || path.abscissa.back() - last < kTip * radius;
    const bool is_in_branching = std::any_of(
        branchings.begin(), branchings.end(),
        [&](const Interval& b) { return gap.first <= b.last + 1 && gap.last >= b.first - 1; });
    const double vessel_radius = widest_radius(path, with_sides(path, gap));
    if (!is_at_tip && !is_in_branching && last - first > kLong * vessel_radius) gaps.push_back(gap);
  }
  return gaps;
}

/// The stretches of a path along the border of the data, between what is blanked. Where the border
/// cuts a vessel across, it is no farther than a radius from the end.
std::vector<Interval> find_cut_stretches(const CenterlinePath& path, std::vector<char> is_cut,
                                         const std::vector<Interval>& blanked) {
  for (const Interval& other : blanked)
    std::fill(is_cut.begin() + other.first + 1, is_cut.begin() + other.last, char(0));
  std::vector<Interval> stretches = find_runs(is_cut, 1);
  std::erase_if(stretches, [&](const Interval& some) {
    return length_of(path, some) <= kLong * widest_radius(path, some);
  });
  return stretches;
}

/// Stretches in which nothing is measured, for one reason.
class Blanked {
 public:
  explicit Blanked(std::string reason) : reason_(std::move(reason)) {}
  void add(const CenterlinePath& path, const Interval& gap) {
    const auto mm = [&](int i) {
      return std::to_string(std::lround(path.abscissa[std::size_t(i)]));
    };
    places_.push_back("between " + mm(gap.first) + " and " + mm(gap.last) + " mm of line " +
                      std::to_string(path.id));
  }
  /// One note a stretch, or one of all where they are many.
  void tell(std::vector<std::string>& notes) const {
    constexpr std::size_t kEach = 4;
    const std::string end = " " + reason_ + ", and nothing is measured there (Blanking)";
    if (places_.size() <= kEach) {
      for (const std::string& place : places_) notes.push_back(place + end);
      return;
    }
    std::string some;
    for (std::size_t n = 0; n + 1 < kEach; ++n) some += places_[n] + ", ";
    notes.push_back(some + "and along " + std::to_string(places_.size() + 1 - kEach) +
                    " other stretches" + end);
  }

 private:
  std::string reason_;
  std::vector<std::string> places_;
};

}  // namespace

int count_shared(const CenterlinePath& a, const CenterlinePath& b) {
  const std::size_t most = std::min(a.points.size(), b.points.size());
  std::size_t i = 0;
  while (i < most && a.points[i] == b.points[i]) ++i;
  return int(i);
}

std::vector<std::string> assign_tracts(CenterlineTree& tree,
                                       const std::vector<std::vector<char>>& is_tube,
                                       const std::vector<std::vector<char>>& is_cut) {
  Splitter splitter(tree, is_tube);
  Blanked no_tube(
      "the lumen is no tube (a sac, a chamber, or vessels that touch): the line goes straight "
      "through"),
      cut_open("the vessel runs along the border of the data, which cuts it open");
  std::map<std::tuple<std::size_t, int, bool>, int> group_of;  // first owner, start, blanking
  for (std::size_t i = 0; i < tree.paths.size(); ++i) {
    CenterlinePath& path = tree.paths[i];
    path.tracts.clear();
    const auto add = [&](int first, int last, bool blanking) {
      if (last <= first) return;
      // A branch belongs to the first path that has all of it, a branching to the first that
      // comes in.
      std::size_t owner = 0;
      while (owner < i && splitter.shared(owner, i) <= (blanking ? first : last)) ++owner;
      const int next_group = int(group_of.size());
      const int group = group_of.try_emplace({owner, first, blanking}, next_group).first->second;
      path.tracts.push_back({first, last, group, int(path.tracts.size()), blanking});
    };
    std::vector<Interval> blanked = splitter.branchings(i);
    const auto blank = [&](const std::vector<Interval>& stretches, Blanked& told) {
      for (const Interval& gap : stretches) {
        blanked.push_back(gap);
        const auto has_it = [&](const CenterlinePath& other) {
          return splitter.shared(std::size_t(other.id), i) > gap.first;
        };
        const auto others = tree.paths.begin() + std::ptrdiff_t(i);
        if (std::none_of(tree.paths.begin(), others, has_it)) told.add(path, gap);
      }
    };
    blank(find_gaps(path, is_tube[i], blanked), no_tube);
    if (!is_cut.empty()) blank(find_cut_stretches(path, is_cut[i], blanked), cut_open);
    std::sort(blanked.begin(), blanked.end(),
              [](const Interval& a, const Interval& b) { return a.first < b.first; });
    int at = 0;
    for (const Interval& interval : blanked) {
      add(at, interval.first, false);
      add(interval.first, interval.last, true);
      at = interval.last;
    }
    add(at, int(path.points.size()) - 1, false);
  }
  std::vector<std::string> notes;
  no_tube.tell(notes);
  cut_open.tell(notes);
  return notes;
}

}  // namespace angio::centerline
