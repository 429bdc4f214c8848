// What a reader who knows nothing of the method sees of a case's lines, of any case folder.
//
//     line_quality CASE...            prints a header and a row a case, comma separated
//
// The table of the whole collection, with a person's readings beside it, is collection_table's.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "benchmarks/line_measure.hpp"
#include "core/error.hpp"
#include "pipeline/case/case_files.hpp"

namespace angio {
namespace {
namespace fs = std::filesystem;

void judge(const fs::path& folder) {
  const CenterlineTree tree = pipeline::read_centerlines(folder / "centerline/centerlines.vtp");
  const LineMeasure q = measure_lines(tree, folder);
  const Vec3 inlet = tree.paths.front().points.front();
  fmt::print(
      "{},{},{},{},{},{},{:.0f},{:.0f},{:.2f},{:.2f},{:.1f},{},{:.2f},{:.1f} {:.1f} {:.1f}\n",
      folder.filename().string().empty() ? folder.parent_path().filename().string()
                                         : folder.filename().string(),
      tree.paths.size(), q.points, q.outside, q.sharp_steps, q.sharp_radii, q.largest_step,
      q.largest_radius, 100.0 * quantile(q.radius_errors, 0.5),
      100.0 * quantile(q.radius_errors, 0.95), q.radius_off_percent(), q.jumps, q.too_long, inlet.x,
      inlet.y, inlet.z);
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) {
  fmt::print(
      "case,outlets,points,outside,steps_over_25,radii_over_40,largest_step_degrees,"
      "largest_within_radius_degrees,radius_error_median_percent,radius_error_95_percent,"
      "radius_off_2_percent,radius_jumps,too_long_percent,inlet\n");
  int failed = 0;
  for (int i = 1; i < argc; ++i) try {
      angio::judge(argv[i]);
    } catch (const angio::Error& error) {
      fmt::print(stderr, "{}: {}\n", argv[i], error.what());
      ++failed;
    }
  return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
