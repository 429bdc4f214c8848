#pragma once

#include <vector>

#include "core/centerline.hpp"

namespace angio::centerline {

/// A stretch of a tree's lines between two partings, or between one and an end. Every point of the
/// tree lies on one branch only: that where lines part belongs to the branch before.
struct Branch {
  int path = 0;                ///< index of the first (longest) path that runs through it
  int first = 0, last = 0;     ///< its points on that path, both inclusive
  int parent = -1;             ///< the branch before; -1: it begins at the inlet
  std::vector<int> daughters;  ///< the branches behind, the longest path's first
};

/// The branches of a tree, parents before their daughters. Lines share a branch as long as their
/// points are the same.
std::vector<Branch> find_branches(const CenterlineTree& tree);

/// For each point of a path, whether a branching hides its radius (CenterlineTract::blanking).
std::vector<char> find_hidden(const CenterlinePath& path);

}  // namespace angio::centerline
