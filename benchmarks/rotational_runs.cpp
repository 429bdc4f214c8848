// How near the lumen comes to the truth that is reconstructed from the X-ray frames of a rotational
// run: phantoms, projected exactly, in a body, with quantum noise; with and without a wobble of the
// C-arm that the geometry does not tell; with a mask run; of few frames; of a heart that beats.
//
//     rotational_runs [--markdown FILE]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "benchmarks/accuracy_measures.hpp"
#include "benchmarks/phantom_pictures.hpp"
#include "centerline/centerline.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/rotational_run.hpp"
#include "reconstruction/reconstruction.hpp"
#include "segmentation/segmentation.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

using benchmarks::formatted;
using datasets::RotationalRunOfPhantom;
using datasets::RotationalRunOptions;

struct Plan {
  const char* name;
  RotationalRunOptions run;
  reconstruction::Method method = reconstruction::Method::automatic;
  double stenosis_percent = 60.0;
  std::vector<const char*> phantoms = {"straight", "tandem", "helix", "ytype"};
};

/// A coronary tree that beats, 4.4 s long.
RotationalRunOptions beating() {
  RotationalRunOptions run;
  run.frames = 133;
  run.heartbeat_mm = 8.0;
  return run;
}

std::vector<Plan> plans() {
  std::vector<Plan> all(6);
  all[0].name = "200 frames";
  all[1].name = "200 frames, wobble 0.5 mm, 0.3 degrees";
  all[1].run.wobble_mm = 0.5;
  all[1].run.wobble_degrees = 0.3;
  all[2].name = "200 frames and their mask run";
  all[2].run.mask_run = true;
  all[3].name = "60 frames";
  all[3].run.frames = 60;
  all[4].name = "19 frames over 180 degrees";
  all[4].run.frames = 19;
  all[4].run.arc_degrees = 180.0;
  all[5] = all[4];
  all[5].name = "19 frames over 180 degrees, 80 %";
  all[5].stenosis_percent = 80.0;
  all[5].phantoms = {"concentric", "unilateral", "tandem", "helix", "ytype"};
  for (const auto& [name, frames] : {std::pair{"19 frames, iterated", 19},
                                     {"13 frames", 13},
                                     {"13 frames, iterated", 13},
                                     {"10 frames, back-projected", 10},
                                     {"10 frames, iterated", 10}}) {
    all.push_back(all[4]);
    all.back().name = name;
    all.back().run.frames = frames;
    all.back().method = std::string_view(name).ends_with("iterated")
                            ? reconstruction::Method::few_views
                            : reconstruction::Method::fdk;
  }
  constexpr auto kAutomatic = reconstruction::Method::automatic;
  all.push_back({"133 frames, at rest", beating(), kAutomatic, 60.0, {"coronary"}});
  all.back().run.heartbeat_mm = 0.0;
  all.push_back({"133 frames, heartbeat 8 mm", beating(), kAutomatic, 60.0, {"coronary"}});
  all.push_back({"the same without R waves", beating(), kAutomatic, 60.0, {"coronary"}});
  all.back().run.tells_r_waves = false;
  for (const auto& [name, breath] : {std::pair{"133 frames, heartbeat 8 mm, breath 3 mm", 3.0},
                                     {"133 frames, heartbeat 8 mm, breath 5 mm", 5.0},
                                     {"133 frames, heartbeat 8 mm, breath 8 mm", 8.0}}) {
    all.push_back({name, beating(), kAutomatic, 60.0, {"coronary"}});
    all.back().run.breathing_mm = breath;
  }
  return all;
}

/// What is found, moved onto the truth: where all of the C-arm stands is not in its frames.
void take_out_shift(CenterlineTree& found, const CenterlineTree& truth, Vec3& shift) {
  constexpr int kRounds = 5;
  shift = {};
  for (int round = 0; round < kRounds; ++round) {
    Vec3 sum;
    std::size_t count = 0;
    for (const CenterlinePath& path : found.paths)
      for (std::size_t p = path.points.size() / 8; p < path.points.size() * 7 / 8; ++p) {
        double nearest = 1e300;
        Vec3 to;
        for (const CenterlinePath& other : truth.paths)
          for (std::size_t s = 1; s < other.points.size(); ++s) {
            const Vec3 a = other.points[s - 1], d = other.points[s] - a;
            const double length = norm_squared(d);
            const double t =
                length > 0.0 ? std::clamp(dot(path.points[p] - a, d) / length, 0.0, 1.0) : 0.0;
            const Vec3 away = a + t * d - path.points[p];
            if (norm(away) < nearest) {
              nearest = norm(away);
              to = away;
            }
          }
        sum += to;
        ++count;
      }
    const Vec3 by = sum / double(std::max<std::size_t>(count, 1));
    shift += by;
    for (CenterlinePath& path : found.paths)
      for (Vec3& point : path.points) point += by;
  }
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? NAN : sum / double(values.size());
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return values.empty() ? NAN : std::sqrt(sum / double(values.size()));
}

/// The run as its header tells it.
reconstruction::RotationalRun told_run(const RotationalRunOfPhantom& made) {
  reconstruction::RotationalRun run;
  const double step = made.options.frame_time_ms / 1000.0;
  for (std::size_t f = 0; f < made.frames.size(); ++f) {
    run.frames.push_back(angiogram::c_arm_frame({made.primary_angles_degrees[f], 0.0}, made.mount));
    run.times_s.push_back(double(f) * step);
  }
  if (made.options.tells_r_waves)
    for (const int frame : made.motion.r_wave_frames) run.r_waves_s.push_back(frame * step);
  return run;
}

/// The overlap with the truth, once what is found is moved by `shift`.
double dice_of(Volume<float> level_set, const datasets::PhantomOptions& options,
               const Vec3& shift) {
  const datasets::detail::Anatomy anatomy =
      datasets::detail::make_anatomy(datasets::detail::with_size(options));
  level_set.geometry.origin +=
      shift + 0.5 * (anatomy.shape.lower_corner() + anatomy.shape.upper_corner());
  Accuracy accuracy;
  compare_volumes(level_set, anatomy.shape, accuracy);
  return accuracy.dice;
}

std::vector<std::string> measure(const std::string& phantom, const Plan& plan) {
  datasets::PhantomOptions options;
  options.name = phantom;
  options.stenosis_percent = plan.stenosis_percent;
  const RotationalRunOfPhantom made = datasets::make_rotational_run(options, plan.run);
  const std::size_t per_frame = std::size_t(made.mount.columns) * std::size_t(made.mount.rows);
  const benchmarks::PhantomPictures pictures(made.pictures, per_frame),
      masks(made.masks, per_frame);
  reconstruction::RotationalRun run = told_run(made);
  run.pictures = &pictures;
  if (!made.masks.empty()) run.masks = &masks;
  reconstruction::ReconstructionOptions reconstruction_options;
  reconstruction_options.method = plan.method;
  const auto start = std::chrono::steady_clock::now();
  const reconstruction::Reconstruction result =
      reconstruction::reconstruct_volume(run, reconstruction_options);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::vector<std::string> cells = {phantom, plan.name};
  try {
    const segmentation::Segmentation lumen = segmentation::segment_vessels(result.volume, {});
    centerline::CenterlineOptions lines;
    lines.voxel_mm = result.volume.geometry.longest_spacing();
    CenterlineTree tree = centerline::extract_centerline(lumen.level_set, lines).tree;
    Vec3 shift;
    take_out_shift(tree, made.phantom.truth.tree, shift);
    Accuracy accuracy;
    compare_trees(tree, made.phantom.truth, accuracy);
    cells.push_back(formatted("%.3f", mean(accuracy.line_mm)));
    cells.push_back(formatted("%.3f", norm(shift)));
    cells.push_back(formatted("%+.3f", mean(accuracy.radius_mm)));
    cells.push_back(formatted("%.3f", rms(accuracy.radius_mm)));
    constexpr double kLost = 10.0;  // no line is near
    std::string throats;
    for (const double error : accuracy.throat)
      throats += (throats.empty() ? "" : ", ") +
                 (error < kLost ? formatted("%+.1f", 100.0 * error) : "lost");
    cells.push_back(throats.empty() ? "-" : throats);
    cells.push_back(formatted("%d / %d", accuracy.lesions_missed, accuracy.lesions_invented));
    cells.push_back(formatted("%.3f", dice_of(lumen.level_set, options, shift)));
  } catch (const std::exception& error) {
    cells.insert(cells.end(), {"-", "-", "-", "-", "-", error.what(), "-"});
  }
  cells.push_back(formatted("%.2f, %.2f", result.quality.given_residual_pixels,
                            result.quality.residual_pixels));
  cells.push_back(formatted("%d of %d", int(result.used.size()), int(run.frames.size())) + ", " +
                  reconstruction::kMethodNames[int(result.quality.method)]);
  cells.push_back(formatted("%.1f", seconds));
  return cells;
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable table("Lumens reconstructed from rotational X-ray runs", argc,
                                       argv);
  table.paragraph(
      "Phantoms with a stenosis of 60 %, or as is said, pixels of 0.3 mm at the isocentre, an arc "
      "of "
      "200 degrees, noise of 2 % behind a head wider than the detector, default options. Hearts "
      "beat 70 times a minute, frames are 33 ms apart, breaths are 15 a minute. Lines are moved by "
      "their mean offset first: where a C-arm stands that does not keep to its header cannot be "
      "seen in its frames.");
  table.columns({"phantom", "run", "line, mean [mm]", "moved by [mm]", "radius, bias [mm]",
                 "radius, RMSE [mm]", "throats [%]", "lesions missed / invented", "Dice",
                 "residual, given and used [pixels]", "frames used, method", "reconstruction [s]"});
  for (const angio::Plan& plan : angio::plans())
    for (const char* phantom : plan.phantoms) table.row(angio::measure(phantom, plan));
  table.write();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "rotational_runs: %s\n", error.what());
  return 1;
}
