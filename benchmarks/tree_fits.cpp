// How near a tree comes to the truth that is fitted to X-ray frames (reconstruction/tree_fit.hpp),
// and whether its radii are wrong by what it says: phantoms, projected exactly, in a body, with
// quantum noise. Each fit starts from the true tree, moved and of other radii.
//
//     tree_fits [--markdown FILE]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "benchmarks/free_move.hpp"
#include "benchmarks/phantom_pictures.hpp"
#include "datasets/rotational_run.hpp"
#include "reconstruction/tree_fit.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

using benchmarks::formatted;
using datasets::RotationalRunOfPhantom;
using datasets::RotationalRunOptions;

struct Plan {
  const char* name;
  RotationalRunOptions run;
  reconstruction::TreeFitOptions fit;
  bool ends_only = false;  ///< the first frame and the last
};

std::vector<Plan> plans() {
  std::vector<Plan> all(6);
  all[0].name = "2 views 60 degrees apart";
  all[0].run.frames = 3;
  all[0].run.arc_degrees = 60.0;
  all[0].ends_only = true;
  all[1] = all[0];
  all[1].name = "2 views 60 degrees apart, with mask frames";
  all[1].run.mask_run = true;
  all[2] = all[1];
  all[2].name = "the same, wobble of 1 mm, 0.5 degrees";
  all[2].run.wobble_mm = 1.0;
  all[2].run.wobble_degrees = 0.5;
  all[2].fit.frame_shift_sd_mm = 1.0;
  all[2].fit.frame_turn_sd_degrees = 0.5;
  all[3].name = "19 frames over 180 degrees";
  all[3].run.frames = 19;
  all[3].run.arc_degrees = 180.0;
  all[4].name = "60 frames over 200 degrees";
  all[4].run.frames = 60;
  all[5].name = "200 frames over 200 degrees";
  return all;
}

/// A third of a millimetre away, by turns to both sides, and of a radius that is the mean's.
CenterlineTree moved_tree(const CenterlineTree& truth) {
  CenterlineTree tree = truth;
  double sum = 0.0;
  std::size_t count = 0;
  for (const CenterlinePath& path : truth.paths)
    for (const double radius : path.inscribed_radius) {
      sum += radius;
      ++count;
    }
  for (CenterlinePath& path : tree.paths) {
    for (std::size_t p = 0; p < path.points.size(); ++p) {
      constexpr double kAway = 0.33, kWave = 0.5;
      path.points[p].x += kAway * std::sin(kWave * path.abscissa[p]);
      path.points[p].y += kAway * std::cos(kWave * path.abscissa[p]);
      path.inscribed_radius[p] =
          std::sqrt(path.inscribed_radius[p] * sum / double(count));  // half of what it is
    }
    path.abscissa = arc_length(path.points);
    path.tube_radius.clear();
  }
  return tree;
}

bool is_blanked(const CenterlinePath& path, std::size_t point) {
  return std::any_of(path.tracts.begin(), path.tracts.end(), [&](const CenterlineTract& tract) {
    return tract.blanking && int(point) >= tract.first_point && int(point) <= tract.last_point;
  });
}

struct Errors {
  std::vector<double> line_mm, radius_mm, score;
  std::vector<double> throat_mm;  ///< diameters
  Vec3 shift;
};

/// The truth at the point of a true line nearest to a fitted one, outside branchings and a diameter
/// from the ends.
void compare(const CenterlinePath& fitted, const std::vector<double>& sd,
             const CenterlinePath& truth, Errors& errors) {
  for (std::size_t p = 0; p < fitted.points.size(); ++p) {
    const double at = project(truth, fitted.points[p]);
    const CenterlineSample there = sample(truth, at);
    const double from_end = std::min(at, truth.abscissa.back() - at);
    if (from_end < 2.0 * there.inscribed_radius || is_blanked(truth, p)) continue;
    errors.line_mm.push_back(distance(there.point, fitted.points[p]));
    errors.radius_mm.push_back(fitted.tube_radius[p] - there.inscribed_radius);
    errors.score.push_back(errors.radius_mm.back() / sd[p]);
  }
}

Errors errors_of(const reconstruction::TreeFit& fit, const datasets::PhantomTruth& truth) {
  Errors errors;
  CenterlineTree tree = fit.tree;
  errors.shift = benchmarks::move_freely(tree, [&](std::size_t line, const Vec3& point) {
    const CenterlinePath& path = truth.tree.paths[line];
    return sample(path, project(path, point)).point;
  });
  for (std::size_t l = 0; l < tree.paths.size(); ++l)
    compare(tree.paths[l], fit.radius_sd[l], truth.tree.paths[l], errors);
  for (const datasets::LesionTruth& lesion : truth.lesions) {
    double least = 1e9;
    for (const CenterlinePath& path : tree.paths)
      for (std::size_t p = 0; p < path.points.size(); ++p)
        if (distance(path.points[p], lesion.lesion_point) < 1.5 * lesion.reference_diameter_mm)
          least = std::min(least, path.tube_radius[p]);
    errors.throat_mm.push_back(2.0 * least - lesion.mld_mm);
  }
  return errors;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / double(values.size());
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / double(values.size()));
}

std::vector<std::string> measure(const std::string& phantom, const Plan& plan) {
  datasets::PhantomOptions options;
  options.name = phantom;
  options.stenosis_percent = 60.0;
  const RotationalRunOfPhantom made = datasets::make_rotational_run(options, plan.run);
  std::vector<std::size_t> frames;
  for (std::size_t f = 0; f < made.frames.size(); ++f)
    if (!plan.ends_only || f == 0 || f + 1 == made.frames.size()) frames.push_back(f);
  const std::size_t per_frame = std::size_t(made.mount.columns) * std::size_t(made.mount.rows);
  const benchmarks::PhantomPictures pictures(made.pictures, per_frame, frames),
      masks(made.masks, per_frame, frames);
  reconstruction::RotationalRun run;
  for (const std::size_t f : frames)
    run.frames.push_back(angiogram::c_arm_frame({made.primary_angles_degrees[f], 0.0}, made.mount));
  run.pictures = &pictures;
  if (!made.masks.empty()) run.masks = &masks;
  constexpr double kAir = 60000.0;
  std::vector<std::string> cells = {phantom, plan.name};
  const auto start = std::chrono::steady_clock::now();
  const reconstruction::TreeFit fit =
      reconstruction::fit_tree(run, kAir, moved_tree(made.phantom.truth.tree), plan.fit);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Errors errors = errors_of(fit, made.phantom.truth);
  cells.push_back(formatted("%.3f", mean(errors.line_mm)));
  cells.push_back(formatted("%.3f", norm(errors.shift)));
  cells.push_back(formatted("%+.3f", mean(errors.radius_mm)));
  cells.push_back(formatted("%.3f", rms(errors.radius_mm)));
  std::string throats;
  for (const double error : errors.throat_mm)
    throats += (throats.empty() ? "" : ", ") + formatted("%+.3f", error);
  cells.push_back(throats.empty() ? "-" : throats);
  cells.push_back(formatted("%.2f", rms(errors.score)));
  cells.push_back(formatted("%d%s", fit.steps, fit.converged ? "" : ", not settled"));
  cells.push_back(formatted("%.1f", seconds));
  return cells;
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable table("Trees fitted to X-ray frames", argc, argv);
  table.paragraph(
      "Phantoms with a stenosis of 60 %, pixels of 0.3 mm at the isocentre, noise of 2 % behind a "
      "head wider than the detector. Each fit starts from the true tree, moved by a wave of 0.33 "
      "mm, with half of the logarithm of what tells its radii from their mean. Outside branchings "
      "and a diameter from the ends. Score: the radii's errors over the sd that the fit gives "
      "them, root mean square: 1 where it says what they are worth.");
  table.columns({"phantom", "frames", "line, mean [mm]", "moved by [mm]", "radius, bias [mm]",
                 "radius, RMSE [mm]", "throats, diameter [mm]", "score", "steps", "fit [s]"});
  for (const angio::Plan& plan : angio::plans())
    for (const char* phantom : {"straight", "tandem", "helix", "ytype", "coronary"})
      table.row(angio::measure(phantom, plan));
  table.write();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "tree_fits: %s\n", error.what());
  return 1;
}
