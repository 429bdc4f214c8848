// air_mesh [COUNT] [--markdown FILE]: air meshes of random stenosed vessels with random balloons
// (some folded), as they are built: points added, tets left out, flat and negative ones, and how
// well they fill the gap; then the time of a build, without the placing.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "air_mesh/build/gap_boundary.hpp"
#include "air_mesh/build/gap_mesh.hpp"
#include "core/error.hpp"
#include "testing/meshing/random_vessel.hpp"
#include "testing/result_table.hpp"

namespace angio::meshing {
namespace {

struct Tally {
  int built = 0, refused = 0, with_warnings = 0;
  int flat_or_negative = 0, outside = 0, gaps_not_filled = 0;
  std::vector<double> build_ms;
};

void check(const BalloonSetup& setup, Tally& tally) {
  const TetMesh& air = setup.air.tets;
  for (const Tet& t : air.tets) {
    const auto at = [&](std::size_t i) { return air.vertices[std::size_t(t[i])]; };
    tally.flat_or_negative += tet_volume(at(0), at(1), at(2), at(3)) > 0.0 ? 0 : 1;
  }
  const auto gap = air_mesh::close_region(setup.region.mesh);
  const double volume = enclosed_volume(gap->shell) - enclosed_volume(setup.balloon.start);
  tally.gaps_not_filled += std::abs(test::sum_of_tets(air) / volume - 1.0) < 1e-9 ? 0 : 1;
  tally.outside +=
      air.vertices.size() == setup.balloon.start.vertices.size() + setup.region.mesh.vertices.size()
          ? 0
          : 1;
  for (const std::string& warning : setup.warnings)
    if (warning.find("air tetrahedra") != std::string::npos) {
      ++tally.with_warnings;
      std::fprintf(stderr, "  %s\n", warning.c_str());
    }
  const auto begin = std::chrono::steady_clock::now();
  air_mesh::mesh_gap(setup.balloon.start, *gap,
                     setup.balloon.guidewire[setup.balloon.guidewire.size() / 2]);
  tally.build_ms.push_back(
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
}

void run(int count, benchmarks::ResultTable& results) {
  Draw draw{std::mt19937(11)};
  Tally tally;
  for (int i = 0; i < count; ++i) {
    Site site = random_site(draw);
    const BalloonOptions balloon = random_balloon(draw);
    try {
      const test::PlacedCase placed =
          test::place(std::move(site.vessel), site.abscissa, site.lesion_length,
                      site.reference_diameter, balloon);
      ++tally.built;
      check(placed.setup, tally);
    } catch (const InputError& error) {
      ++tally.refused;
      std::fprintf(stderr, "  refused: %s\n", error.what());
    }
  }
  std::sort(tally.build_ms.begin(), tally.build_ms.end());
  results.columns({"what", "value"});
  const auto add = [&](const char* what, int value) { results.row({what, std::to_string(value)}); };
  add("air meshes built", tally.built);
  add("refused, as no balloon fits", tally.refused);
  add("meshes with tets left out (added or flat)", tally.with_warnings);
  add("meshes with vertices of their own", tally.outside);
  add("flat or negative tets", tally.flat_or_negative);
  add("gaps not filled to 1e-9", tally.gaps_not_filled);
  if (!tally.build_ms.empty())
    results.row({"time of a build, median; worst",
                 benchmarks::formatted("%.0f; %.0f ms", tally.build_ms[tally.build_ms.size() / 2],
                                       tally.build_ms.back())});
}

}  // namespace
}  // namespace angio::meshing

int main(int argument_count, char** arguments) {
  try {
    angio::benchmarks::ResultTable results("Air meshes of random vessels", argument_count,
                                           arguments);
    angio::meshing::run(argument_count > 1 ? std::max(1, std::atoi(arguments[1])) : 200, results);
    results.write();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "air_mesh: %s\n", error.what());
    return 1;
  }
}
