// air_mesh [COUNT]: air meshes of random stenosed vessels with random balloons (some folded), as
// they are built: points added, tets left out, flat and negative ones, and how well they fill the
// gap; then the time of a build, without the placing.

#include "meshing/detail/air_mesh.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "core/error.hpp"
#include "tests/meshing/placed_balloon.hpp"

namespace angio::meshing {
namespace {

struct Draw {
  std::mt19937 random;

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  int one_of(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }
};

struct Tally {
  int built = 0, refused = 0, with_warnings = 0;
  int flat_or_negative = 0, outside = 0, gaps_not_filled = 0;
  std::vector<double> build_ms;
};

// A straight stenosed tube, an arc, or a fork of two to four branches, with a lesion's place.
struct Site {
  test::Vessel vessel;
  double abscissa, lesion_length, reference_diameter;
};
Site random_site(Draw& draw) {
  const double radius = draw.between(1.0, 2.2);
  switch (draw.one_of(3)) {
    case 0: {
      const double half = draw.between(2.0, 6.0);
      return {
          test::make_tube(36.0, 0.3, test::stenosis(radius, 18.0, half, draw.between(0.2, 0.75))),
          18.0, 2.0 * half, 2.0 * radius};
    }
    case 1: {
      const double bend = draw.between(8.0, 25.0), angle = 34.0 / bend;
      return {test::make_arc(radius, bend, std::min(angle, 3.0), 0.3),
              0.5 * bend * std::min(angle, 3.0), 4.0, 2.0 * radius};
    }
    default:
      return {test::make_branching(2 + draw.one_of(3), radius, 0.75 * radius, 18.0, 16.0,
                                   draw.between(0.4, 0.8), 0.3),
              draw.between(12.0, 22.0), 4.0, 2.0 * radius};
  }
}

BalloonOptions random_balloon(Draw& draw) {
  BalloonOptions options;
  options.ring_count = 16 + draw.one_of(30);
  options.ring_vertex_count = 12 + draw.one_of(16);
  options.length_mm = draw.between(6.0, 12.0);
  options.start_diameter_mm = draw.between(0.5, 1.0);
  if (draw.one_of(5) == 0) options.folds = draw.one_of(2) == 0 ? 2 : 3;
  return options;
}

void check(const BalloonSetup& setup, Tally& tally) {
  const TetMesh& air = setup.air.tets;
  for (const Tet& t : air.tets) {
    const auto at = [&](std::size_t i) { return air.vertices[std::size_t(t[i])]; };
    tally.flat_or_negative += tet_volume(at(0), at(1), at(2), at(3)) > 0.0 ? 0 : 1;
  }
  const auto gap = detail::close_region(setup.region.mesh);
  const double volume = enclosed_volume(gap->shell) - enclosed_volume(setup.balloon.start);
  tally.gaps_not_filled += std::abs(test::sum_of_tets(air) / volume - 1.0) < 1e-9 ? 0 : 1;
  tally.outside +=
      air.vertices.size() == setup.balloon.start.vertices.size() + setup.region.mesh.vertices.size()
          ? 0
          : 1;
  for (const std::string& warning : setup.warnings)
    if (warning.find("air tetrahedra") != std::string::npos) {
      ++tally.with_warnings;
      std::printf("  %s\n", warning.c_str());
    }
  const auto begin = std::chrono::steady_clock::now();
  detail::mesh_gap(setup.balloon.start, *gap,
                   setup.balloon.guidewire[setup.balloon.guidewire.size() / 2]);
  tally.build_ms.push_back(
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
}

void run(int count) {
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
      std::printf("  refused: %s\n", error.what());
    }
    std::fflush(stdout);
  }
  std::sort(tally.build_ms.begin(), tally.build_ms.end());
  std::printf("air meshes built                     %d (refused as no balloon fits: %d)\n",
              tally.built, tally.refused);
  std::printf("with tets left out (added or flat)   %d\n", tally.with_warnings);
  std::printf("with vertices of their own           %d\n", tally.outside);
  std::printf("flat or negative tets                %d\n", tally.flat_or_negative);
  std::printf("gaps not filled to 1e-9              %d\n", tally.gaps_not_filled);
  if (!tally.build_ms.empty())
    std::printf("build, median and worst              %.0f and %.0f ms\n",
                tally.build_ms[tally.build_ms.size() / 2], tally.build_ms.back());
}

}  // namespace
}  // namespace angio::meshing

int main(int argument_count, char** arguments) {
  try {
    angio::meshing::run(argument_count > 1 ? std::max(1, std::atoi(arguments[1])) : 200);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "air_mesh: %s\n", error.what());
    return 1;
  }
}
