#pragma once

#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <ostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "simulation/wall.hpp"

/// A layered wall as CalculiX reads it, and the displacements that it prints.
///
/// CalculiX gets the same wedges with a node in the middle of every edge (C3D15): its linear wedge
/// locks where the solid is nearly incompressible. Kilopascal and millimetre throughout, so that
/// forces are in mN.
namespace angio::simulation::ccx {

struct Nodes {
  std::vector<Vec3> places;  ///< those of the wall first
  std::vector<char> fixed;   ///< as LayeredWall::fixed
};

/// The text of the wall's elements; the middle nodes are added to `nodes`.
///
/// @param first  number of the first element less one
inline std::string elements_of(const LayeredWall& wall, Nodes& nodes, std::size_t first = 0) {
  nodes = {wall.vertices, wall.fixed};
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [place, is_new] =
        middles.insert({std::minmax(a, b), static_cast<int>(nodes.places.size())});
    if (is_new) {
      const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
      nodes.places.push_back(0.5 * (nodes.places[i] + nodes.places[j]));
      const bool on_rim =
          nodes.fixed[i] != 0 && nodes.fixed[j] != 0 && nodes.places[i].z == nodes.places[j].z;
      nodes.fixed.push_back(on_rim ? 8 : 0);
    }
    return place->second;
  };
  std::ostringstream out;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const Wedge& c = wall.wedges[w];
    out << first + w + 1;
    for (const int v : c) out << ", " << v + 1;
    for (const auto& [a, b] :
         {std::pair{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}})
      out << ", " << middle(c[static_cast<std::size_t>(a)], c[static_cast<std::size_t>(b)]) + 1;
    out << '\n';
  }
  return out.str();
}

inline void write_nodes(std::ostream& out, const std::vector<Vec3>& nodes, std::size_t first = 0) {
  for (std::size_t v = 0; v < nodes.size(); ++v)
    out << first + v + 1 << ", " << nodes[v].x << ", " << nodes[v].y << ", " << nodes[v].z << '\n';
}

inline void write_held(std::ostream& out, const std::vector<char>& fixed) {
  for (std::size_t v = 0; v < fixed.size(); ++v)
    for (int axis = 1; axis <= 3; ++axis)
      if ((fixed[v] >> axis & 1) != 0) out << v + 1 << ", " << axis << '\n';
}

/// The tables of displacements of the first `count` nodes, in the order in which they were printed,
/// shape [step][count]. @throws InputError if there are fewer than `steps`
inline std::vector<std::vector<Vec3>> read_displacements(const std::string& path, std::size_t count,
                                                         std::size_t steps = 1) {
  std::ifstream in(path);
  if (!in) throw IoError("cannot read " + path + ". Run ccx first", ExitCode::no_input);
  std::vector<std::vector<Vec3>> tables;
  std::size_t found = 0;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::size_t node = 0;
    Vec3 d;
    if (line.find("displacements") != std::string::npos) {
      tables.emplace_back(count);
      found = 0;
    }
    if (tables.empty() || !(words >> node >> d.x >> d.y >> d.z) || node == 0 || node > count)
      continue;
    tables.back()[node - 1] = d;
    ++found;
  }
  if (tables.size() < steps || found != count)
    throw InputError(path + " holds no displacements (ccx did not finish). See its output");
  return tables;
}

/// The main function of a comparison: PROGRAM write FILE.inp | compare FILE.dat.
///
/// @param compare  gives the exit code
template <class Write, class Compare>
int write_or_compare(int argc, char** argv, const LayeredWall& wall, const Write& write,
                     const Compare& compare) {
  try {
    const std::string what = argc == 3 ? argv[1] : "";
    if (what == "write") return write(wall, argv[2]), 0;
    if (what == "compare") return compare(wall, argv[2]);
    std::cerr << "usage: " << argv[0] << " write FILE.inp | compare FILE.dat\n";
    return static_cast<int>(ExitCode::usage);
  } catch (const Error& e) {
    std::cerr << "error: " << e.what() << '\n';
    return static_cast<int>(e.exit_code());
  }
}

}  // namespace angio::simulation::ccx
