#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "benchmarks/calculix/ccx_wall.hpp"
#include "core/error.hpp"
#include "simulation/wall.hpp"

/// A narrowed wall segment of neo-Hookean layers under pressure, rims held along the vessel, here
/// and in CalculiX.
/// wall_segment.sh runs both:  wall_segment write FILE.inp;  ccx FILE;  wall_segment compare
/// FILE.dat.
namespace {

using namespace angio;
using namespace angio::simulation;

constexpr double kPressureKpa = 4.0, kShearKpa = 40.0, kBulkRatio = 50.0;

LayeredWall segment() {
  TubeWall tube;
  tube.around = 36;
  tube.along = 18;
  tube.length_mm = 4.0;
  tube.inner_radius_mm = [](double angle, double z) {
    return 1.2 - 0.3 * std::exp(-2.0 * (z - 2.0) * (z - 2.0)) * (1.0 + 0.4 * std::cos(angle));
  };
  tube.outer_radius_mm = [](double, double) { return 1.75; };
  tube.layer_shares.assign(4, 1.0);
  tube.layer_regions.assign(4, WallRegion::media);
  LayeredWall wall = make_tube_wall(tube);
  // Two vertices of the outer rim keep the segment from moving as a rigid body; they carry no load.
  const std::size_t rim = wall.vertices.size() / 5 * 4;
  wall.fixed[rim] = 2 + 4 + 8;
  wall.fixed[rim + static_cast<std::size_t>(tube.around / 2)] = 4 + 8;
  return wall;
}

WallOptions options() {
  WallOptions o;
  o.materials.fill({.shear_kpa = kShearKpa, .bulk_kpa = kBulkRatio * kShearKpa});
  o.foundation_kpa_per_mm = 0.0;
  return o;
}

void write_calculix(const LayeredWall& wall, const std::string& path) {
  ccx::Nodes nodes;
  const std::string elements = ccx::elements_of(wall, nodes);
  std::ofstream out(path);
  out << std::fixed;  // a field holds 20 characters
  out.precision(12);
  out << "*NODE, NSET=NALL\n";
  ccx::write_nodes(out, nodes.places);
  out << "*ELEMENT, TYPE=C3D15, ELSET=EALL\n" << elements;
  // C10 = G/2, D1 = 2/K
  out << "*MATERIAL, NAME=WALL\n*HYPERELASTIC, NEO HOOKE\n"
      << 0.5 * kShearKpa << ", " << 2.0 / (kBulkRatio * kShearKpa)
      << "\n*SOLID SECTION, ELSET=EALL, MATERIAL=WALL\n*BOUNDARY\n";
  ccx::write_held(out, nodes.fixed);
  out << "*STEP, NLGEOM, INC=200\n*STATIC\n0.1, 1.0\n*DLOAD\n";
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    if (wall.layer[w] == 0) out << w + 1 << ", P1, " << kPressureKpa << '\n';
  out << "*NODE PRINT, NSET=NALL, FREQUENCY=1000\nU\n*END STEP\n";
  if (!out.flush()) throw IoError("cannot write " + path + ". Check the folder and the disk");
}

int compare(const LayeredWall& wall, const std::string& path) {
  const std::vector<Vec3> theirs = ccx::read_displacements(path, wall.vertices.size()).back();
  const WallSolution ours = solve_wall(wall, options(), unloaded_state(wall), kPressureKpa);
  double most = 0.0, worst = 0.0, squares = 0.0, size = 0.0;
  for (std::size_t v = 0; v < theirs.size(); ++v) {
    const Vec3 mine = ours.state.vertices[v] - wall.vertices[v];
    most = std::max(most, norm(theirs[v]));
    worst = std::max(worst, distance(mine, theirs[v]));
    squares += norm_squared(mine - theirs[v]);
    size += norm_squared(theirs[v]);
  }
  std::printf(
      "\nNarrowed wall segment under pressure, the same wedges; differences in %% of the largest "
      "displacement.\n\n"
      "| wedges | largest displacement mm | at most | root mean square | bar | |\n"
      "|---|---|---|---|---|---|\n| %zu | %.4f | %.2f | %.2f | 1 | %s |\n",
      wall.wedges.size(), most, 100.0 * worst / most, 100.0 * std::sqrt(squares / size),
      ours.converged ? "converged" : "NOT converged");
  return ours.converged && worst <= 0.01 * most ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return ccx::write_or_compare(argc, argv, segment(), write_calculix, compare);
}
