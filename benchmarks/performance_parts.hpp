#pragma once

#include <string>

#include "simulation/simulation.hpp"
#include "testing/result_table.hpp"

/// The parts of the program `performance` that stand in files of their own, and what all share.
namespace angio::simulation {

using benchmarks::formatted;
using benchmarks::ResultTable;

double now();  ///< a clock [s]
/// The GPU's name; empty if there is none.
const std::string& gpu_name();
inline bool has_gpu() { return !gpu_name().empty(); }
/// @param threads  0 for a GPU
std::string backend_name(int threads);

/// The seed paper's balloon (Table 2) of its rubber, 0.5 mm x 10 mm, by rings and vertices around.
SimulationModel paper_balloon(int rings = 26, int around = 20);
/// 0 to 0.48 MPa in 100 frames of 25 ms, to a hoop stretch of about 1.3, held for 20.
SimulationOptions ramp();

/// A course with a wall: the tubes of the seed paper's vessels, by their number of vertices.
struct WallCase {
  const char* name;
  int rings, around;
  bool folded;
};
/// The paper's rubber balloon, blown up unfolded, or a wrapped balloon of PA-12.
SimulationModel wall_model(const WallCase& c, SimulationOptions& options);

void angioplasty(ResultTable& results);
void layered_walls(ResultTable& results);
void paper(ResultTable& results);
void air_mesh(ResultTable& results);

/// Backends and precisions against each other.
void compare(ResultTable& results);
/// A few frames of small scenes, for tools that watch a program's memory.
void check();

}  // namespace angio::simulation
