// air_follow CASE... [--frames] [--markdown FILE]: follows the air mesh over the frames that a case
// has written, without the solver: in how many of them it is whole, what it took, how long.
// A case run with simulation.write_every=1 has every frame of its run.
// Exit codes: 0 done; 64 usage.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "air_mesh/adaptive_air.hpp"
#include "air_mesh/build/build_air.hpp"
#include "formats/files.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

namespace fs = std::filesystem;

/// Balloon and wall, one after the other.
struct Surfaces {
  TriangleMesh balloon, wall;

  [[nodiscard]] std::vector<Vec3> vertices() const {
    std::vector<Vec3> both = balloon.vertices;
    both.insert(both.end(), wall.vertices.begin(), wall.vertices.end());
    return both;
  }
  [[nodiscard]] std::vector<Triangle> triangles() const {
    std::vector<Triangle> both = balloon.triangles;
    const int offset = int(balloon.vertices.size());
    for (const Triangle& t : wall.triangles)
      both.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    return both;
  }
};

Surfaces read_surfaces(const fs::path& balloon, const fs::path& wall) {
  return {formats::read_surface(balloon).mesh, formats::read_surface(wall).mesh};
}

std::vector<fs::path> frames_of(const fs::path& simulated, const std::string& body) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(simulated / "frames"))
    if (entry.path().filename().string().rfind(body, 0) == 0) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void follow(const fs::path& folder, bool each_frame, benchmarks::ResultTable& results) {
  const Surfaces start =
      read_surfaces(folder / "meshing" / "balloon.vtp", folder / "meshing" / "region.vtp");
  const std::vector<Tet> tets = formats::read_tets(folder / "meshing" / "air.vtu").mesh.tets;
  const auto rebuild = [&](const std::vector<Vec3>& x) {
    const auto middle = x.begin() + std::ptrdiff_t(start.balloon.vertices.size());
    return air_mesh::build_air({{x.begin(), middle}, start.balloon.triangles},
                               {{middle, x.end()}, start.wall.triangles});
  };
  air_mesh::AdaptiveAir air(tets, start.vertices(), start.triangles(),
                            {rebuild, air_mesh::mesh_hollow});
  const std::vector<fs::path> balloons = frames_of(folder / "simulation", "balloon_");
  const std::vector<fs::path> walls = frames_of(folder / "simulation", "vessel_");
  int without = 0, rebuilds = 0;
  double sum = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < std::min(balloons.size(), walls.size()); ++i) {
    const std::vector<Vec3> x = read_surfaces(balloons[i], walls[i]).vertices();
    const auto begin = std::chrono::steady_clock::now();
    air.follow(x);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    const air_mesh::AirReport report = air.take_report();
    without += air.is_whole() ? 0 : 1;
    rebuilds += report.rebuild_count;
    sum += ms;
    worst = std::max(worst, ms);
    if (each_frame)
      std::printf(
          "%s: %s, %d tets, %d out (%.2f %%), %d open, %d points, %d flips, %d rebuilt, %.0f ms\n",
          balloons[i].stem().c_str(), air.is_whole() ? "whole" : "not whole", report.tet_count,
          report.left_out_count, 100.0 * report.left_out_share, report.inverted_count,
          report.point_count, report.flip_count, report.rebuild_count, ms);
  }
  const double count = double(std::max<std::size_t>(1, balloons.size()));
  results.row({folder.filename().string(), std::to_string(balloons.size()), std::to_string(without),
               std::to_string(rebuilds), benchmarks::formatted("%.1f", sum / count),
               benchmarks::formatted("%.0f", worst)});
}

}  // namespace
}  // namespace angio

int main(int argument_count, char** arguments) {
  try {
    angio::benchmarks::ResultTable results("Air that follows", argument_count, arguments);
    std::vector<std::string> cases(arguments + 1, arguments + argument_count);
    const bool each_frame = std::erase(cases, "--frames") > 0;
    if (cases.empty()) {
      std::fprintf(stderr, "usage: air_follow CASE... [--frames] [--markdown FILE]\n");
      return 64;
    }
    results.columns({"case", "frames", "without whole air", "meshes built again",
                     "mean time of a frame ms", "longest ms"});
    for (const std::string& folder : cases) angio::follow(folder, each_frame, results);
    results.write();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "air_follow: %s\n", error.what());
    return 1;
  }
}
