#include "simulation/bodies/layered_wall.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace angio::simulation::detail {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

int column_count(const LayeredWall& wall) {
  int last = 0;
  for (const Triangle& t : wall.lumen_triangles) last = std::max({last, t[0], t[1], t[2]});
  return last + 1;
}

// Wedges join a level's copies to the next level's copies of the same columns.
void check_columns(const LayeredWall& wall, int columns) {
  const int levels = static_cast<int>(wall.vertices.size()) / columns;
  if (static_cast<int>(wall.vertices.size()) != levels * columns || levels < 2 ||
      levels > kMostColumnLevels)
    throw InputError("the layered wall has " + std::to_string(wall.vertices.size()) +
                     " vertices over a lumen of " + std::to_string(columns) +
                     " (whole copies of the lumen are needed, 1 to " +
                     std::to_string(kMostColumnLevels - 1) + " layers). Build it again");
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    for (std::size_t a = 0; a < 3; ++a)
      if (wall.wedges[w][a + 3] != wall.wedges[w][a] + columns ||
          wall.wedges[w][a] / columns != wall.layer[w])
        throw InputError("wedge " + std::to_string(w) +
                         " of the layered wall does not join a vertex to its own copy further out "
                         "(the solver moves columns of copies). Build the wall again");
}

LayeredWall renumbered(const LayeredWall& wall, const std::vector<int>& new_vertex) {
  LayeredWall result = wall;
  for (std::size_t v = 0; v < wall.vertices.size(); ++v) {
    result.vertices[at(new_vertex[v])] = wall.vertices[v];
    result.fixed[at(new_vertex[v])] = wall.fixed[v];
  }
  for (Wedge& wedge : result.wedges)
    for (int& v : wedge) v = new_vertex[at(v)];
  for (auto* surface : {&result.lumen_triangles, &result.outer_triangles})
    for (Triangle& t : *surface)
      for (int& v : t) v = new_vertex[at(v)];
  return result;
}

// Without a balance there is no wall; one that is not quite the shape that was seen is told.
void check_balance(const WallSolution& seen, std::vector<std::string>& warnings) {
  if (seen.converged) return;
  char text[300];
  if (seen.load < 1.0) {
    std::snprintf(text, sizeof text,
                  "the layered wall carries no more than %.0f %% of its blood pressure (it gives "
                  "way around %.1f %.1f %.1f mm: a layer is too thin or too soft there). Make the "
                  "wall thicker (wall.thickness_ratio) or its materials stiffer",
                  100.0 * seen.load, seen.place.x, seen.place.y, seen.place.z);
    throw InputError(text);
  }
  std::snprintf(text, sizeof text,
                "the layered wall leaves the shape that was seen by up to %.3f mm under its blood "
                "pressure, around %.1f %.1f %.1f mm",
                seen.displacement_mm, seen.place.x, seen.place.y, seen.place.z);
  warnings.emplace_back(text);
}

}  // namespace

ColumnLists list_columns(const SolidModel& model, int column_count) {
  std::vector<std::vector<int>> patches(at(column_count)), links(at(column_count));
  std::vector<std::vector<ColumnWedge>> wedges(at(column_count));
  const auto column = [&](int w, int a) { return model.corners[at(6 * w + a)] % column_count; };
  for (int w = 0; w < model.wedge_count(); ++w)
    for (int a = 0; a < 3; ++a) {
      const int i = column(w, a);
      patches[at(i)].push_back(model.patch[at(w)]);
      for (const int side : {1, 2}) links[at(i)].push_back(column(w, (a + side) % 3));
      wedges[at(i)].push_back({w, a, {}});
    }
  ColumnLists lists;
  lists.patch_begin = lists.wedge_begin = lists.link_begin = {0};
  for (int i = 0; i < column_count; ++i) {
    for (auto* list : {&patches[at(i)], &links[at(i)]}) {
      std::sort(list->begin(), list->end());
      list->erase(std::unique(list->begin(), list->end()), list->end());
    }
    const std::vector<int>& beside = links[at(i)];
    for (ColumnWedge& wedge : wedges[at(i)])
      for (int side = 0; side < 2; ++side)
        wedge.link[side] =
            lists.link_begin.back() +
            static_cast<int>(std::lower_bound(beside.begin(), beside.end(),
                                              column(wedge.wedge, (wedge.corner + 1 + side) % 3)) -
                             beside.begin());
    lists.patches.insert(lists.patches.end(), patches[at(i)].begin(), patches[at(i)].end());
    lists.links.insert(lists.links.end(), beside.begin(), beside.end());
    lists.wedges.insert(lists.wedges.end(), wedges[at(i)].begin(), wedges[at(i)].end());
    lists.patch_begin.push_back(static_cast<int>(lists.patches.size()));
    lists.wedge_begin.push_back(static_cast<int>(lists.wedges.size()));
    lists.link_begin.push_back(static_cast<int>(lists.links.size()));
  }
  return lists;
}

std::vector<std::array<int, 2>> patch_partners(const LayeredWall& wall) {
  const int columns = column_count(wall);
  const SolidModel model = make_solid_model(wall, {});
  std::vector<std::array<int, 2>> partners;
  for (int p = 0; p < model.patch_count(); ++p) {
    std::vector<int> members;
    for (int m = model.patch_begin[at(p)]; m < model.patch_begin[at(p) + 1]; ++m)
      for (int a = 0; a < 3; ++a)
        members.push_back(model.corners[at(6 * model.patch_wedges[at(m)] + a)] % columns);
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    for (std::size_t i = 0; i < members.size(); ++i)
      for (std::size_t j = i + 1; j < members.size(); ++j)
        partners.push_back({members[i], members[j]});
  }
  std::sort(partners.begin(), partners.end());
  partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
  return partners;
}

WallSolid make_wall_solid(const LayeredWall& wall, const std::vector<int>& order,
                          const WallOptions& options, const WallSolution* seen) {
  const int columns = static_cast<int>(order.size());
  check_columns(wall, columns);
  WallSolid solid;
  solid.levels = static_cast<int>(wall.vertices.size()) / columns;
  std::vector<int> new_vertex(wall.vertices.size());
  solid.caller_vertex.resize(wall.vertices.size());
  for (int level = 0; level < solid.levels; ++level)
    for (int i = 0; i < columns; ++i) {
      const int caller = level * columns + order[at(i)];
      new_vertex[at(caller)] = level * columns + i;
      solid.caller_vertex[at(level * columns + i)] = caller;
    }
  solid.wall = renumbered(wall, new_vertex);
  // In the caller's numbering: found here or given, it is the same. Of its state only vertices are
  // numbered.
  const WallSolution found = seen == nullptr ? prestress_wall(wall, options) : *seen;
  check_balance(found, solid.warnings);
  solid.seen = found.state;
  solid.seen.vertices = solid.wall.vertices;
  solid.model = make_solid_model(solid.wall, options);
  set_memory(solid.seen, solid.model);
  solid.columns = list_columns(solid.model, columns);
  solid.blood_pressure = units::pascal_from_kilopascal(options.blood_pressure_kpa);
  return solid;
}

}  // namespace angio::simulation::detail
