#pragma once

#include <cstdint>
#include <vector>

#include "core/progress.hpp"
#include "reconstruction/detail/view_hull.hpp"

namespace angio::reconstruction::detail {

/// What of each view's lines is accounted for.
class Explained {
 public:
  /// @param views  must outlive this
  explicit Explained(const std::vector<ViewLookup>& views);
  [[nodiscard]] bool is(std::size_t view, int pixel) const {
    return is_explained_[view][std::size_t(pixel)] != 0;
  }
  /// By a vessel through a place.
  void mark(const Vec3& place, double radius, double step);
  /// Part of each view's lines.
  [[nodiscard]] std::vector<double> parts() const;

 private:
  const std::vector<ViewLookup>& views_;
  std::vector<std::vector<std::uint8_t>> is_explained_;
};

/// A tree of places: each has one from which it was reached, the root none.
struct Grown {
  std::vector<int> place;  ///< of the hull, in the order of growth
  std::vector<int> from;   ///< index here, -1: the root
  double explained = 0.0;  ///< parts of the views' lines, summed
};

/// A stretch between two ends or forks: its places, both ends included.
struct GrownStretch {
  int first = 0, last = 0;  ///< nodes
  std::vector<int> nodes;
};

std::vector<std::vector<int>> neighbours_of(const Grown& grown);
std::vector<GrownStretch> stretches_of(const std::vector<std::vector<int>>& neighbours);

/// The tree of places that explains the most of the views' lines, from where the vessels are the
/// widest on, by the paths that explain the most of what is not yet explained: the second largest
/// of the views' lengths, for one view alone would make a vessel of any line that lies behind a
/// true one. What explains less than 1.25 radii, or 3 mm, of its own in a second view is taken out.
Grown grow_tree(const Hull& hull, const std::vector<ViewLookup>& views, const Progress& progress);

}  // namespace angio::reconstruction::detail
