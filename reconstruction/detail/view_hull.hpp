#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/progress.hpp"
#include "core/vec3.hpp"
#include "reconstruction/detail/view_picture.hpp"

namespace angio::reconstruction::detail {

constexpr double kHullReach = 2.0;  ///< of a place from a view's line [mm]

/// The way to a place beside.
struct HullStep {
  int to = 0;
  float cost = 0.0F;
};

/// Places of a grid that may be vessel: where all views (of four or more all but one) see a line
/// near. A mm of path there costs
///
///     1 + sum_v (d_v / max(0.5 mm, r_v / 3))^2 + 4 ln^2(max r_v / min r_v)
///
/// d_v: from view v's line; r_v: the radii that the views give the vessel there.
struct Hull {
  double step = 0.5;  ///< [mm]
  Vec3 corner;
  std::vector<std::array<int, 3>> cell;
  std::vector<float> cost;              ///< a mm
  std::vector<float> radius;            ///< the views' median [mm]
  std::vector<int> pixel;               ///< nearest line, shape [places, views]; -1: too far
  std::vector<std::size_t> first_step;  ///< of each place, and the end
  std::vector<HullStep> steps;          ///< to the up to 26 places beside

  [[nodiscard]] Vec3 at(int place) const {
    const auto& c = cell[std::size_t(place)];
    return corner + step * Vec3{double(c[0]), double(c[1]), double(c[2])};
  }
  /// @param visit  with the place beside, and the cost of the way to it
  template <typename Visit>
  void for_each_neighbour(int here, const Visit& visit) const {
    for (std::size_t s = first_step[std::size_t(here)]; s < first_step[std::size_t(here) + 1]; ++s)
      visit(steps[s].to, steps[s].cost);
  }
};

/// What a hull is made for.
enum class Wanted { all_vessels, one_vessel };

/// @param views   at least two
/// @param reach   how far a view's line may lie from a place [mm]; more where the grid is coarse
/// @param most_bytes  that its places, the ways between them, and a tree's growth over them
///                    (detail/tree_growth.hpp) may take
/// @param wanted  tells what to advise where they take more
/// @throws InputError  nearly everything could be vessel, or takes more memory than that
Hull find_hull(const std::vector<ViewLookup>& views, double reach, std::uint64_t most_bytes,
               Wanted wanted, const Progress& progress = {});

/// The place that the views see nearest to a pixel in each; sum of the distances [mm].
/// @return -1: the hull is empty
int nearest_place(const Hull& hull, const std::vector<ViewLookup>& views,
                  const std::vector<std::array<double, 2>>& pixels);

/// Places from one to another at the least cost; empty: there is no way.
std::vector<int> cheapest_way(const Hull& hull, int start, int end);

}  // namespace angio::reconstruction::detail
