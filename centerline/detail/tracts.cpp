#include "centerline/detail/tracts.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "centerline/detail/polyline.hpp"

namespace angio::centerline {
namespace {

/// How many points two paths have in common from the inlet.
int count_shared(const CenterlinePath& a, const CenterlinePath& b) {
  const std::size_t most = std::min(a.points.size(), b.points.size());
  std::size_t i = 0;
  while (i < most && a.points[i] == b.points[i]) ++i;
  return int(i);
}

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
  explicit Splitter(const CenterlineTree& tree)
      : tree_(tree), count_(tree.paths.size()), shared_(count_ * count_), exit_(count_ * count_) {
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = 0; j < i; ++j)
        shared(i, j) = shared(j, i) = count_shared(tree.paths[i], tree.paths[j]);
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = 0; j < count_; ++j)
        if (i != j) exit(i, j) = find_exit(tree.paths[i], tree.paths[j], shared(i, j));
  }

  /// The branchings on one path, from the inlet on, without overlap.
  [[nodiscard]] std::vector<Interval> branchings(std::size_t i) const {
    std::map<int, Interval> by_parting;
    for (std::size_t j = 0; j < count_; ++j) {
      if (j == i) continue;
      const int parting = shared(i, j);
      Interval& interval =
          by_parting.try_emplace(parting, Interval{start_of(i, parting), 0}).first->second;
      interval.last = std::max(interval.last, exit(i, j));
    }
    std::vector<Interval> merged;
    for (const auto& entry : by_parting) {
      const Interval& next = entry.second;
      if (!merged.empty() && next.first <= merged.back().last)
        merged.back().last = std::max(merged.back().last, next.last);
      else
        merged.push_back(next);
    }
    return merged;
  }

  [[nodiscard]] int shared(std::size_t i, std::size_t j) const { return shared_[i * count_ + j]; }

 private:
  int& shared(std::size_t i, std::size_t j) { return shared_[i * count_ + j]; }
  int& exit(std::size_t i, std::size_t j) { return exit_[i * count_ + j]; }
  [[nodiscard]] int exit(std::size_t i, std::size_t j) const { return exit_[i * count_ + j]; }

  /// Where the branching begins at which path i and others part: the same for all of them.
  [[nodiscard]] int start_of(std::size_t i, int parting) const {
    int start = std::max(parting - 1, 0);
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
};

}  // namespace

void assign_tracts(CenterlineTree& tree) {
  const Splitter splitter(tree);
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
    int at = 0;
    for (const Interval& branching : splitter.branchings(i)) {
      add(at, branching.first, false);
      add(branching.first, branching.last, true);
      at = branching.last;
    }
    add(at, int(path.points.size()) - 1, false);
  }
}

}  // namespace angio::centerline
