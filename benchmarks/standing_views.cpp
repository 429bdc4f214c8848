// How near vessels come to the truth that are found from angiograms of a C-arm that stood still
// (reconstruction/views.hpp): phantoms, projected exactly, with quantum noise, nothing given but
// the pictures and their headers.
//
//     standing_views [--plan N] [PHANTOM,...]... [--markdown FILE]
//
// PHANTOM as `angio phantom` takes it; none: seven of them, and forks. N: one plan alone, from 1.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iterator>
#include <string>
#include <vector>

#include "benchmarks/free_move.hpp"
#include "benchmarks/phantom_pictures.hpp"
#include "core/error.hpp"
#include "datasets/rotational_run.hpp"
#include "reconstruction/views.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

using benchmarks::formatted;

struct Plan {
  const char* name;
  datasets::RotationalRunOptions run;
  bool ends = false;  ///< of the longest line, from the truth, to 3 pixels
};

std::vector<Plan> plans() {
  std::vector<Plan> all(9);
  all[0].name = "2 views 60 degrees apart";
  all[0].run.views = {{-30.0, 0.0}, {30.0, 0.0}};
  all[0].run.body = false;
  all[1] = all[0];
  all[1].name = "the same, the longest vessel by its ends";
  all[1].ends = true;
  all[2] = all[0];
  all[2].name = "2 views, -30/20 and 40/-15 degrees";
  all[2].run.views = {{-30.0, 20.0}, {40.0, -15.0}};
  all[3] = all[2];
  all[3].name = "the same, each view shifted by 3 mm sd";
  all[3].run.wobble_mm = 3.0;
  all[4] = all[3];
  all[4].name = "the same shifts, the longest vessel by its ends";
  all[4].ends = true;
  all[5] = all[2];
  all[5].name = "3 views, with 0/40 degrees";
  all[5].run.views.push_back({0.0, 40.0});
  all[6] = all[2];
  all[6].name = "-30/20 and 40/-15 degrees, before a skull, the longest vessel by its ends";
  all[6].run.body = true;
  all[6].ends = true;
  all[7] = all[5];
  all[7].name = "3 views, each shifted by 3 mm sd";
  all[7].run.wobble_mm = 3.0;
  all[8] = all[7];
  all[8].name = "4 views, with -25/-25 degrees, shifted by 5 mm sd, turned by 1 degree sd";
  all[8].run.views.push_back({-25.0, -25.0});
  all[8].run.wobble_mm = 5.0;
  all[8].run.wobble_degrees = 1.0;
  for (Plan& plan : all) plan.run.frames = 1;
  return all;
}

reconstruction::VesselEnds ends_in(const angiogram::ConeBeamFrame& frame,
                                   const CenterlinePath& path) {
  constexpr double kBeside = 3.0;
  const angiogram::ConeBeamView view(frame);
  const auto first = view.see(path.points.front()), last = view.see(path.points.back());
  return {{first.column + kBeside, first.row}, {last.column, last.row - kBeside}};
}

/// The truth nearest to a place.
struct Nearest {
  double away = 1e9, radius = 0.0;
  Vec3 place;
  bool at_end = false;
};

Nearest nearest(const CenterlineTree& truth, const Vec3& place) {
  Nearest found;
  for (const CenterlinePath& path : truth.paths) {
    const double at = project(path, place);
    const CenterlineSample there = sample(path, at);
    if (distance(there.point, place) >= found.away) continue;
    found = {distance(there.point, place), there.inscribed_radius, there.point,
             std::min(at, path.abscissa.back() - at) < 2.0 * there.inscribed_radius};
  }
  return found;
}

std::vector<std::string> measure(const std::string& phantom, const Plan& plan) {
  const datasets::PhantomOptions options = datasets::parse_phantom(phantom);
  const auto made = datasets::make_rotational_run(options, plan.run);
  const std::size_t per_frame = std::size_t(made.mount.columns) * std::size_t(made.mount.rows);
  std::vector<std::size_t> indices(made.frames.size());
  for (std::size_t f = 0; f < indices.size(); ++f) indices[f] = f;
  const benchmarks::PhantomPictures pictures(made.pictures, per_frame, indices);
  const CenterlineTree& truth = made.phantom.truth.tree;
  reconstruction::RotationalRun run;
  reconstruction::ViewsOptions how;
  for (std::size_t f = 0; f < indices.size(); ++f) {
    run.frames.push_back(angiogram::c_arm_frame(plan.run.views[f], made.mount));
    if (plan.ends) how.ends.push_back(ends_in(made.frames[f], truth.paths.front()));
  }
  run.pictures = &pictures;
  std::vector<std::string> cells = {phantom, plan.name};
  const auto start = std::chrono::steady_clock::now();
  reconstruction::TreeOfViews found;
  try {
    found = reconstruction::reconstruct_views(run, how);
  } catch (const InputError& error) {
    cells.insert(cells.end(), {"refused", "", "", "", "", ""});
    return cells;
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  CenterlineTree tree = found.fit.tree;
  const Vec3 moved = benchmarks::move_freely(
      tree, [&](std::size_t /*line*/, const Vec3& point) { return nearest(truth, point).place; });
  double line = 0.0, bias = 0.0, squares = 0.0, count = 0.0;
  for (const CenterlinePath& path : tree.paths)
    for (std::size_t p = 0; p < path.points.size(); ++p) {
      const Nearest there = nearest(truth, path.points[p]);
      if (there.at_end) continue;
      line += there.away;
      bias += path.tube_radius[p] - there.radius;
      squares += std::pow(path.tube_radius[p] - there.radius, 2);
      ++count;
    }
  double covered = 0.0, of = 0.0;
  for (const CenterlinePath& path : truth.paths)
    for (const Vec3& point : path.points) {
      covered += nearest(tree, point).away < 1.0 ? 1.0 : 0.0;
      ++of;
    }
  cells.push_back(formatted("%.0f", 100.0 * covered / of));
  cells.push_back(formatted("%.3f", line / count));
  cells.push_back(formatted("%.2f", norm(moved)));
  cells.push_back(formatted("%+.3f", bias / count) +
                  formatted(", %.3f", std::sqrt(squares / count)));
  std::string throats;
  for (const datasets::LesionTruth& lesion : made.phantom.truth.lesions) {
    double least = 1e9;
    for (const CenterlinePath& path : tree.paths)
      for (std::size_t p = 0; p < path.points.size(); ++p)
        if (distance(path.points[p], lesion.lesion_point) < 2.5 * lesion.reference_diameter_mm)
          least = std::min(least, path.tube_radius[p]);
    throats += (throats.empty() ? "" : "; ") +
               (least < 1e8 ? formatted("%.2f", 2.0 * least) : std::string("not found")) +
               formatted(" for %.2f", lesion.mld_mm);
  }
  cells.push_back(throats.empty() ? "-" : throats);
  cells.push_back(formatted("%.1f", seconds));
  return cells;
}

}  // namespace
}  // namespace angio

namespace {

/// Of which the wanted vessel is measured where others leave it.
constexpr const char* kForks[] = {"ytype,stenosis=40,radius=1.2",
                                  "ytype,stenosis=80,radius=2.5",
                                  "ytype,stenosis=0,length=40",
                                  "trifurcation",
                                  "trifurcation,stenosis=75,radius=2",
                                  "coronary,stenosis=40",
                                  "coronary,stenosis=80"};

struct Arguments {
  std::vector<std::string> phantoms;
  std::size_t plan = 0;  ///< from 1; 0: all
};

/// @return false if they make no sense
bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--plan" && i + 1 < argc)
      arguments.plan = std::stoul(argv[++i]);
    else if (word.starts_with("-"))
      return false;
    else
      arguments.phantoms.push_back(word);
  }
  return arguments.plan <= angio::plans().size();
}

void measure_all(const Arguments& arguments, angio::benchmarks::ResultTable& table) {
  const std::vector<angio::Plan> plans = angio::plans();
  for (std::size_t p = 0; p < plans.size(); ++p)
    for (const std::string& phantom : arguments.phantoms)
      if (arguments.plan == 0 || arguments.plan == p + 1)
        table.row(angio::measure(phantom, plans[p]));
}

}  // namespace

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable table("Vessels found from angiograms of a C-arm that stood still",
                                       argc, argv);
  constexpr int kUsage = 64;
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    std::fprintf(stderr, "usage: standing_views [--plan N] [PHANTOM,...]... [--markdown FILE]\n");
    return kUsage;
  }
  table.paragraph(
      "Phantoms with a stenosis of 60 % where none is named, one picture a view, pixels of 0.3 mm "
      "at the isocentre, "
      "noise "
      "of 2 %, default options, nothing given but the pictures and their headers. Covered: part of "
      "the true lines with a found one within 1 mm. Lines are moved by their mean offset first: "
      "what "
      "all C-arms are moved by, and of two views a shift along their common planes, cannot be "
      "seen.");
  table.columns({"phantom", "views", "covered [%]", "line, mean [mm]", "moved by [mm]",
                 "radius, bias, RMSE [mm]", "throats, diameter [mm]", "time [s]"});
  if (arguments.phantoms.empty()) {
    measure_all({{"straight", "concentric", "unilateral", "tandem", "helix", "ytype", "coronary"},
                 arguments.plan},
                table);
    for (const std::size_t plan : {std::size_t{2}, std::size_t{5}})
      if (arguments.plan == 0) measure_all({{std::begin(kForks), std::end(kForks)}, plan}, table);
  } else {
    measure_all(arguments, table);
  }
  table.write();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "standing_views: %s\n", error.what());
  return 1;
}
