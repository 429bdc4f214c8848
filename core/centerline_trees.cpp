#include "core/centerline_trees.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace angio {

std::vector<int> tree_of_paths(const CenterlineTree& lines) {
  std::vector<Vec3> inlets;
  std::vector<int> trees;
  for (const CenterlinePath& path : lines.paths) {
    const Vec3 inlet = path.points.empty() ? Vec3{} : path.points.front();
    const auto known = std::find(inlets.begin(), inlets.end(), inlet);
    trees.push_back(int(known - inlets.begin()));
    if (known == inlets.end()) inlets.push_back(inlet);
  }
  return trees;
}

std::vector<CenterlineTree> separate_trees(const CenterlineTree& lines) {
  std::vector<CenterlineTree> trees;
  const std::vector<int> tree = tree_of_paths(lines);
  for (std::size_t p = 0; p < tree.size(); ++p) {
    if (tree[p] == int(trees.size())) trees.emplace_back();
    trees[std::size_t(tree[p])].paths.push_back(lines.paths[p]);
  }
  return trees;
}

CenterlineTree tree_with_path(const CenterlineTree& lines, int path_id) {
  for (CenterlineTree& tree : separate_trees(lines))
    if (std::any_of(tree.paths.begin(), tree.paths.end(),
                    [&](const CenterlinePath& path) { return path.id == path_id; }))
      return std::move(tree);
  return {};
}

}  // namespace angio
