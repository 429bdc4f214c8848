#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.hpp"

/// The groups of the program `contact` that stand in files of their own.
namespace angio::simulation {

struct Row {
  std::string law;
  double value;
  double bar;
  const char* unit;
  bool at_least = false;  ///< the bar is a floor
};
using Rows = std::vector<Row>;

/// A short course.
SimulationOptions schedule();

/// Balloon and wall against Newton's method with exact distances.
Rows against_newton();
/// Balloon and wall touch and part, with a film between them.
Rows adhesion();
/// The same with the paper's contact.
Rows paper();
/// The same inflation `count` times: its bytes, and the memory that it leaves.
Rows soak(int count);

}  // namespace angio::simulation
