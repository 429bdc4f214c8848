#include "meshing/detail/nearest_line.hpp"

#include <algorithm>
#include <limits>

#include "core/error.hpp"

namespace angio::meshing::detail {

int shared_point_count(const CenterlinePath& a, const CenterlinePath& b) {
  const std::size_t limit = std::min(a.points.size(), b.points.size());
  std::size_t count = 0;
  while (count < limit && distance(a.points[count], b.points[count]) < 1e-6) ++count;
  return int(count);
}

NearestLine::NearestLine(const CenterlineTree& tree) : tree_(&tree) {
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    int first = 0;
    for (std::size_t q = 0; q < p; ++q)
      first = std::max(first, shared_point_count(path, tree.paths[q]));
    for (std::size_t i = std::size_t(first); i < path.points.size(); ++i)
      nodes_.push_back({path.points[i], int(p), int(i)});
    std::vector<int>& group = groups_.emplace_back(path.points.size(), 0);
    for (const CenterlineTract& tract : path.tracts)
      for (int i = tract.first_point; i <= tract.last_point && i < int(group.size()); ++i)
        group[std::size_t(i)] = tract.group_id;
  }
  if (nodes_.empty())
    throw InputError(
        "the centreline has no points (nothing says where the lumen runs). Run the "
        "stage centerline again");
  build(0, int(nodes_.size()), 0);
}

void NearestLine::build(int first, int last, int axis) {
  if (last - first < 2) return;
  const int middle = (first + last) / 2;
  std::nth_element(nodes_.begin() + first, nodes_.begin() + middle, nodes_.begin() + last,
                   [axis](const Node& a, const Node& b) {
                     if (a.point[axis] != b.point[axis]) return a.point[axis] < b.point[axis];
                     return a.path != b.path ? a.path < b.path : a.index < b.index;
                   });
  build(first, middle, (axis + 1) % 3);
  build(middle + 1, last, (axis + 1) % 3);
}

void NearestLine::search(int first, int last, int axis, const Vec3& point, int& best,
                         double& best_squared) const {
  if (first >= last) return;
  const int middle = (first + last) / 2;
  const Node& node = nodes_[std::size_t(middle)];
  const double squared = norm_squared(node.point - point);
  if (squared < best_squared) {
    best_squared = squared;
    best = middle;
  }
  const double offset = point[axis] - node.point[axis];
  const int next = (axis + 1) % 3;
  if (offset < 0.0) {
    search(first, middle, next, point, best, best_squared);
    if (offset * offset < best_squared) search(middle + 1, last, next, point, best, best_squared);
  } else {
    search(middle + 1, last, next, point, best, best_squared);
    if (offset * offset < best_squared) search(first, middle, next, point, best, best_squared);
  }
}

LinePlace NearestLine::find(const Vec3& point) const {
  int best = 0;
  double best_squared = std::numeric_limits<double>::infinity();
  search(0, int(nodes_.size()), 0, point, best, best_squared);
  const Node& node = nodes_[std::size_t(best)];
  const CenterlinePath& path = tree_->paths[std::size_t(node.path)];
  LinePlace place{node.path, path.abscissa[std::size_t(node.index)], 0.0, 0.0,
                  groups_[std::size_t(node.path)][std::size_t(node.index)]};
  // The nearest place of the segments on both sides of the nearest point.
  for (int i = std::max(node.index - 1, 0); i <= node.index && i + 1 < int(path.points.size());
       ++i) {
    const Vec3& a = path.points[std::size_t(i)];
    const Vec3 along = path.points[std::size_t(i) + 1] - a;
    const double squared = norm_squared(along);
    const double t = squared > 0.0 ? std::clamp(dot(point - a, along) / squared, 0.0, 1.0) : 0.0;
    const double d = norm_squared(point - (a + t * along));
    if (d <= best_squared) {
      best_squared = d;
      place.abscissa = path.abscissa[std::size_t(i)] +
                       t * (path.abscissa[std::size_t(i) + 1] - path.abscissa[std::size_t(i)]);
    }
  }
  place.distance = std::sqrt(best_squared);
  place.radius = sample(path, place.abscissa).inscribed_radius;
  return place;
}

}  // namespace angio::meshing::detail
