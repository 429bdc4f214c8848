#pragma once

#include <vector>

#include "core/centerline.hpp"

namespace angio {

/// The tree that each path belongs to: all paths of a tree begin at its inlet. 0, 1, ... in the
/// order of the trees' first paths, shape [path].
std::vector<int> tree_of_paths(const CenterlineTree& lines);

/// The trees, each with an inlet of its own, in the same order.
std::vector<CenterlineTree> separate_trees(const CenterlineTree& lines);

/// The tree of the path with an id. @return without paths if there is none
CenterlineTree tree_with_path(const CenterlineTree& lines, int path_id);

}  // namespace angio
