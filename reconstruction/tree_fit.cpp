#include "reconstruction/tree_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/tree_solver.hpp"

namespace angio::reconstruction {
namespace {

using namespace detail;
constexpr std::size_t kFewestPixels = 50;  ///< near the tree, of a frame that is fitted
constexpr int kMostNodes = 700;            ///< the normal matrix grows with their square
constexpr int kMostChoices = 2;            ///< of pixels: again where the tree has moved

/// The size of a pixel where the frames look, the median over points of the tree and frames [mm].
double pixel_at(const RotationalRun& run, const CenterlineTree& tree) {
  std::vector<double> sizes;
  for (const angiogram::ConeBeamFrame& frame : run.frames) {
    const FrameRays rays(frame);
    for (const CenterlinePath& path : tree.paths)
      if (!path.points.empty())
        sizes.push_back(rays.pixel_mm * rays.view.see(path.points[path.points.size() / 2]).depth);
  }
  if (sizes.empty()) throw InputError("there is no line to fit to the frames");
  const double size = median(std::move(sizes));
  if (!(size > 0.0)) throw InputError("the tree lies behind the X-ray source. Check the geometry");
  return size;
}

double mean_radius(const CenterlineTree& tree) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const CenterlinePath& path : tree.paths)
    for (const double radius : measured_radius(path)) {
      sum += radius;
      ++count;
    }
  return sum / double(std::max<std::size_t>(count, 1));
}

TreeCurves curves_of(const CenterlineTree& tree, double pixel_mm, double node_spacing_mm) {
  constexpr double kSamplesPerNode = 3.0;
  double spacing =
      node_spacing_mm > 0.0 ? node_spacing_mm : std::max(pixel_mm, 0.5 * mean_radius(tree));
  for (;; spacing *= 1.25) {
    TreeCurves curves = make_curves(tree, spacing, spacing / kSamplesPerNode);
    if (curves.node_count() <= kMostNodes) return curves;
  }
}

/// The frames that see the tree, and their numbers in the run.
struct SeenFrames {
  std::vector<FitFrame> frames;
  std::vector<std::size_t> index;
};

SeenFrames seen_frames(const RotationalRun& run, double air, const TreeCurves& curves,
                       double width_pixels, const std::vector<std::vector<char>>& left_out) {
  const SampledCurves sampled = sample_curves(curves);
  SeenFrames seen;
  for (std::size_t f = 0; f < run.frames.size(); ++f) {
    std::vector<float> integrals = read_line_integrals(run, int(f), 1, air);
    if (!left_out.empty())
      for (std::size_t i = 0; i < left_out[f].size(); ++i)
        if (left_out[f][i] != 0) integrals[i] = std::numeric_limits<float>::quiet_NaN();
    FitFrame frame = choose_pixels(run.frames[f], integrals, sampled, width_pixels);
    if (frame.pixels.size() < kFewestPixels) continue;
    seen.frames.push_back(std::move(frame));
    seen.index.push_back(f);
  }
  if (seen.frames.empty())
    throw InputError(
        "no frame sees the vessel (the geometry is another run's, or the vessel lies outside the "
        "field). Check both");
  return seen;
}

/// The radius of the section at a place, its sd, and the ball's that fits into the tube there.
struct FittedPlace {
  Vec3 point;
  double radius = 0.0, ball_radius = 0.0, ball_sd = 0.0;
};

/// The ball touches the wall where the slope of the radius lets it: r_b(s) = min over t of
/// |(c(t) - c(s), r(t))|.
FittedPlace fitted_place(const TreeSolution& solution, const TreeCurve& curve, double abscissa) {
  const CurvePoint here = curve.at(curve.place(abscissa));
  FittedPlace fitted{here.point, std::exp(here.log_radius), 0.0, 0.0};
  fitted.ball_radius = fitted.radius;
  SplinePlace touched = curve.place(abscissa);
  for (const SplinePlace& place : curve.samples) {
    const CurvePoint there = curve.at(place);
    const double ball = std::hypot(distance(there.point, here.point), std::exp(there.log_radius));
    if (ball >= fitted.ball_radius) continue;
    fitted.ball_radius = ball;
    touched = place;
  }
  double variance = 0.0;
  const auto parameter = [&](std::size_t a) {
    return curve.first_parameter + 3 * (touched.first_node + int(a)) + 2;
  };
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b)
      variance +=
          touched.value[a] * touched.value[b] * solution.covariance(parameter(a), parameter(b));
  const double wall = std::exp(curve.at(touched).log_radius);
  fitted.ball_sd = std::sqrt(std::max(0.0, variance)) * wall * wall / fitted.ball_radius;
  return fitted;
}

void write_tree(const TreeSolution& solution, const CenterlineTree& start, TreeFit& fit) {
  fit.tree = start;
  for (std::size_t p = 0; p < start.paths.size(); ++p) {
    CenterlinePath& path = fit.tree.paths[p];
    std::vector<double>& sd = fit.radius_sd.emplace_back();
    path.inscribed_radius.clear();
    path.section_area.clear();
    path.equivalent_radius.clear();
    for (std::size_t n = 0; n < path.points.size(); ++n) {
      const CurvePlace& at = solution.state.curves.places[p][n];
      const FittedPlace place =
          fitted_place(solution, solution.state.curves.curves[std::size_t(at.curve)], at.abscissa);
      path.points[n] = place.point;
      path.inscribed_radius.push_back(place.ball_radius);
      path.equivalent_radius.push_back(place.radius);
      path.section_area.push_back(units::kPi * place.radius * place.radius);
      sd.push_back(place.ball_sd);
    }
    path.tube_radius = path.inscribed_radius;
    path.abscissa = arc_length(path.points);
  }
}

TreeFit to_fit(const TreeSolution& solution, const SeenFrames& seen, const RotationalRun& run,
               const CenterlineTree& start) {
  TreeFit fit;
  write_tree(solution, start, fit);
  fit.frames = run.frames;
  fit.contrast_per_mm.assign(run.frames.size(), 0.0);
  for (std::size_t f = 0; f < seen.frames.size(); ++f) {
    const FrameState& own = solution.state.frames[f];
    fit.frames[seen.index[f]] = moved(run.frames[seen.index[f]], own.motion);
    fit.contrast_per_mm[seen.index[f]] = own.contrast;
    fit.noise += own.noise / std::sqrt(solution.correlation) / double(seen.frames.size());
  }
  fit.correlation = solution.correlation;
  fit.blur_pixels = solution.state.width_pixels;
  fit.place_sd_mm = solution.state.smoothness.place_sd;
  fit.log_radius_sd = solution.state.smoothness.radius_sd;
  fit.steps = solution.steps;
  fit.converged = solution.converged;
  return fit;
}

}  // namespace

void TreeFitOptions::validate() const {
  if (!(node_spacing_mm == 0.0 || (node_spacing_mm >= 0.2 && node_spacing_mm <= 10.0)))
    throw OptionError("fit.node_spacing_mm: must be in [0.2, 10], or 0 for half the mean radius");
  if (!(frame_shift_sd_mm >= 0.0 && frame_shift_sd_mm <= 20.0))
    throw OptionError("fit.frame_shift_sd_mm: must be in [0, 20]");
  if (!(frame_turn_sd_degrees >= 0.0 && frame_turn_sd_degrees <= 20.0))
    throw OptionError("fit.frame_turn_sd_degrees: must be in [0, 20]");
  if (most_steps < 1 || most_steps > 1000)
    throw OptionError("fit.most_steps: must be in [1, 1000]");
}

std::size_t radii_without_sd(const TreeFit& fit) {
  std::size_t count = 0;
  for (const std::vector<double>& line : fit.radius_sd)
    count += std::size_t(
        std::count_if(line.begin(), line.end(), [](double sd) { return !std::isfinite(sd); }));
  return count;
}

TreeFit fit_tree(const RotationalRun& run, double air, const CenterlineTree& start,
                 const TreeFitOptions& options, const Progress& progress) {
  options.validate();
  ANGIO_EXPECT(run.pictures != nullptr && !run.frames.empty());
  ANGIO_EXPECT(options.left_out.empty() || options.left_out.size() == run.frames.size());
  const double pixel_mm = pixel_at(run, start);
  const MotionPrior prior{options.frame_turn_sd_degrees * units::kPi / 180.0,
                          options.frame_shift_sd_mm};
  FitState state;
  state.curves = curves_of(start, pixel_mm, options.node_spacing_mm);
  TreeSolution solution;
  SeenFrames seen;
  for (int choice = 0; choice < kMostChoices; ++choice) {
    seen = seen_frames(run, air, state.curves, state.width_pixels, options.left_out);
    state.frames.resize(seen.frames.size());
    solution = solve_tree(seen.frames, std::move(state), prior, options.most_steps, progress);
    if (choice + 1 < kMostChoices) state = solution.state;
  }
  const auto& frames = solution.state.frames;
  if (std::none_of(frames.begin(), frames.end(),
                   [](const FrameState& frame) { return frame.contrast > 0.0; }))
    throw InputError(
        "no frame shows contrast medium in the vessel (it was not filled, or the frames are "
        "subtracted the other way round). Give the run with the medium in it");
  return to_fit(solution, seen, run, start);
}

}  // namespace angio::reconstruction
