#pragma once

#include <vector>

#include "core/centerline.hpp"

namespace angio::meshing::detail {

/// A point of a tree's lines.
struct LinePlace {
  int path = 0;           ///< index in CenterlineTree::paths; the first that holds the place
  double abscissa = 0.0;  ///< [mm] on that path
  double distance = 0.0;  ///< from the point that was asked for [mm]
  double radius = 0.0;    ///< inscribed radius there [mm]
  int group_id = 0;       ///< of the tract there
};

/// Finds the nearest place of a tree's lines. Stretches that several paths share are held once,
/// under the first of these paths.
class NearestLine {
 public:
  explicit NearestLine(const CenterlineTree& tree);
  [[nodiscard]] LinePlace find(const Vec3& point) const;

 private:
  struct Node {
    Vec3 point;
    int path;
    int index;
  };
  void build(int first, int last, int axis);
  void search(int first, int last, int axis, const Vec3& point, int& best,
              double& best_squared) const;

  const CenterlineTree* tree_;
  std::vector<Node> nodes_;  ///< balanced k-d tree in place: the middle splits its range
  std::vector<std::vector<int>> groups_;  ///< GroupIds, shape [path_count][point_count]
};

/// Number of leading points that two paths share.
int shared_point_count(const CenterlinePath& a, const CenterlinePath& b);

}  // namespace angio::meshing::detail
