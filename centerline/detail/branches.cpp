#include "centerline/detail/branches.hpp"

#include <algorithm>

namespace angio::centerline {
namespace {

/// The first point from `from` on at which two paths differ.
int find_parting(const CenterlinePath& a, const CenterlinePath& b, int from) {
  const auto most = int(std::min(a.points.size(), b.points.size()));
  int i = from;
  while (i < most && a.points[std::size_t(i)] == b.points[std::size_t(i)]) ++i;
  return i;
}

/// Adds the branch that begins at point `first` of these paths, and what follows it.
void add_branches(const CenterlineTree& tree, const std::vector<int>& paths, int first, int parent,
                  std::vector<Branch>& branches) {
  const CenterlinePath& leader = tree.paths[std::size_t(paths.front())];
  auto end = int(leader.points.size());
  for (const int p : paths)
    end = std::min(end, find_parting(leader, tree.paths[std::size_t(p)], first));
  int index = parent;
  if (end > first) {
    index = int(branches.size());
    branches.push_back({paths.front(), first, end - 1, parent, {}});
    if (parent >= 0) branches[std::size_t(parent)].daughters.push_back(index);
  }
  std::vector<int> rest;  // a path that ends here has no more points
  for (const int p : paths)
    if (int(tree.paths[std::size_t(p)].points.size()) > end) rest.push_back(p);
  while (!rest.empty()) {
    const Vec3 next = tree.paths[std::size_t(rest.front())].points[std::size_t(end)];
    const auto others = std::stable_partition(rest.begin(), rest.end(), [&](int p) {
      return tree.paths[std::size_t(p)].points[std::size_t(end)] == next;
    });
    add_branches(tree, {rest.begin(), others}, end, index, branches);
    rest.erase(rest.begin(), others);
  }
}

}  // namespace

std::vector<Branch> find_branches(const CenterlineTree& tree) {
  std::vector<Branch> branches;
  std::vector<int> all(tree.paths.size());
  for (std::size_t p = 0; p < all.size(); ++p) all[p] = int(p);
  if (!all.empty()) add_branches(tree, all, 0, -1, branches);
  return branches;
}

std::vector<char> find_hidden(const CenterlinePath& path) {
  std::vector<char> hidden(path.points.size(), 0);
  for (const CenterlineTract& tract : path.tracts) {
    if (!tract.blanking) continue;
    // Tracts share their border points, which belong to the tube.
    for (int i = tract.first_point + 1; i < tract.last_point; ++i) hidden[std::size_t(i)] = 1;
  }
  return hidden;
}

}  // namespace angio::centerline
