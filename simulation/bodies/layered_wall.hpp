#pragma once

#include <array>
#include <string>
#include <vector>

#include "simulation/bodies/layered_model.hpp"
#include "simulation/step/solid_column.hpp"

/// The layered wall within a scene: renumbered as its lumen, pre-stressed, and sorted by columns.
namespace angio::simulation::detail {

/// Arrays of SolidColumns.
struct ColumnLists {
  std::vector<int> patch_begin, patches;
  std::vector<int> wedge_begin;
  std::vector<ColumnWedge> wedges;
  std::vector<int> link_begin, links;
};

struct WallSolid {
  LayeredWall wall;  ///< vertex of column i at a level: level * column_count + i
  SolidModel model;  ///< of `wall`
  WallState seen;    ///< with its pre-stress
  int levels = 0;    ///< vertices of a column; 0: there is no solid
  ColumnLists columns;
  std::vector<char> led;           ///< columns that go with their neighbours, [column]
  std::vector<int> caller_vertex;  ///< of a vertex, in the caller's numbering
  double blood_pressure = 0.0;     ///< [Pa]
  std::vector<std::string> warnings;
};

/// @param column_count  vertices of the solid's first level
ColumnLists list_columns(const SolidModel& model, int column_count);

/// Pairs of columns that share a patch: they may not be moved at the same time.
std::vector<std::array<int, 2>> patch_partners(const LayeredWall& wall);

/// @param wall   copies of the lumen's vertices, level by level; otherwise InputError
/// @param order  the caller's lumen vertex of each column
/// @param seen   the wall's pre-stress; null: it is found
WallSolid make_wall_solid(const LayeredWall& wall, const std::vector<int>& order,
                          const WallOptions& options, const WallSolution* seen = nullptr);

}  // namespace angio::simulation::detail
