#pragma once

#include <ostream>
#include <vector>

#include "simulation/chart.hpp"

/// Compliance charts of several shapes.
namespace angio::simulation::testing {

struct Charted {
  const char* name;
  const char* material;
  double wall_mm;
  std::vector<ChartPoint> chart;
};

inline void PrintTo(const Charted& balloon, std::ostream* out) { *out << balloon.name; }

/// The two representative 3.0 mm balloons, and charts that bend otherwise.
inline std::vector<Charted> charted_balloons() {
  return {
      {"semi_compliant",
       "pa12",
       0.02,
       {{4, 2.85}, {6, 2.93}, {8, 3.00}, {10, 3.06}, {12, 3.11}, {14, 3.16}}},
      {"non_compliant", "pet", 0.02, {{8, 2.93}, {12, 3.00}, {16, 3.04}, {20, 3.08}}},
      {"linear", "pa12", 0.025, {{2, 2.40}, {4, 2.45}, {6, 2.50}, {8, 2.55}, {10, 2.60}}},
      {"softening", "pa12", 0.03, {{6, 3.90}, {8, 3.96}, {10, 4.03}, {12, 4.11}, {14, 4.20}}},
      {"stiffer_than_its_wall", "pa12", 0.01, {{4, 2.98}, {8, 3.00}, {16, 3.02}}},
      {"with_a_point_at_rest", "pa12", 0.02, {{0, 2.70}, {6, 2.95}, {12, 3.05}}},
      {"elastomer", "polyurethane", 0.1, {{0.5, 2.0}, {1, 2.1}, {1.5, 2.22}}},
  };
}

}  // namespace angio::simulation::testing
