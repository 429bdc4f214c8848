// What a reader who knows nothing of the method sees of a case's lines, of any case folder.
//
//     line_quality CASE... [--markdown FILE]            prints a row a case
//
// The table of the whole collection, with a person's readings beside it, is collection_table's.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "core/statistics.hpp"
#include "pipeline/case/case_files.hpp"
#include "testing/pipeline/line_measure.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {
namespace fs = std::filesystem;

void judge(const fs::path& folder, benchmarks::ResultTable& results) {
  const CenterlineTree tree = pipeline::read_centerlines(folder / "centerline/centerlines.vtp");
  const LineMeasure q = measure_lines(tree, folder);
  const Vec3 inlet = tree.paths.front().points.front();
  const auto count = [](auto value) { return fmt::format("{}", value); };
  results.row({folder.filename().string().empty() ? folder.parent_path().filename().string()
                                                  : folder.filename().string(),
               count(tree.paths.size()), count(q.points), count(q.outside), count(q.sharp_steps),
               count(q.sharp_radii), fmt::format("{:.0f}", q.largest_step),
               fmt::format("{:.0f}", q.largest_radius),
               fmt::format("{:.2f}", 100.0 * quantile(q.radius_errors, 0.5, 0.0)),
               fmt::format("{:.2f}", 100.0 * quantile(q.radius_errors, 0.95, 0.0)),
               fmt::format("{:.1f}", q.radius_off_percent()), count(q.jumps),
               fmt::format("{:.2f}", q.too_long),
               fmt::format("{:.1f} {:.1f} {:.1f}", inlet.x, inlet.y, inlet.z)});
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable results("Lines of case folders", argc, argv);
  results.columns({"case", "outlets", "points", "outside", "steps over 25 degrees",
                   "radii over 40 degrees", "largest step, degrees", "largest within a radius",
                   "radius error, median %", "95 %", "off by more than 2 %", "radius jumps",
                   "too long %", "inlet mm"});
  int failed = 0;
  for (int i = 1; i < argc; ++i) try {
      angio::judge(argv[i], results);
    } catch (const angio::Error& error) {
      fmt::print(stderr, "{}: {}\n", argv[i], error.what());
      ++failed;
    }
  results.write();
  return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const std::exception& error) {
  fmt::print(stderr, "line_quality: {}\n", error.what());
  return EXIT_FAILURE;
}
