#include "reconstruction/detail/tree_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "reconstruction/detail/fit_noise.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr std::size_t kFramesAtATime = 8;  ///< whose equations are in memory
constexpr double kLogWidthSd = 0.7;        ///< a pixel sees a pixel's width, to a factor of two
constexpr double kFirstDamping = 1e-4, kLeastDamping = 1e-9, kMostDamping = 1e6;
constexpr int kFewSteps = 3;       ///< between two estimates of noise and smoothness
constexpr double kSettled = 2e-3;  ///< the greatest step, of the radius
constexpr double kSameSpread = 0.05;

struct SummedEquations {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double cost = 0.0;
  std::vector<FrameEquations> frames;  ///< without their `normal`
};

SummedEquations sum_equations(const std::vector<FitFrame>& frames, const FitState& state,
                              const MotionPrior& prior) {
  const SampledCurves sampled = sample_curves(state.curves);
  PriorEquations smooth = prior_equations(state.curves, state.smoothness);
  SummedEquations sum{std::move(smooth.normal), std::move(smooth.right), smooth.cost, {}};
  const Eigen::Index last = sum.right.size() - 1;
  const double log_width = std::log(state.width_pixels);
  constexpr double kInformation = 1.0 / (kLogWidthSd * kLogWidthSd);
  sum.normal(last, last) += kInformation;
  sum.right[last] -= kInformation * log_width;
  sum.cost += kInformation * log_width * log_width;
  sum.frames.resize(frames.size());
  for (std::size_t first = 0; first < frames.size(); first += kFramesAtATime) {
    const std::size_t count = std::min(kFramesAtATime, frames.size() - first);
    parallel_for_uneven(std::ptrdiff_t(count), [&](std::ptrdiff_t n) {
      const std::size_t f = first + std::size_t(n);
      sum.frames[f] =
          frame_equations(frames[f], state.frames[f], sampled, state.width_pixels, prior);
    });
    for (std::size_t f = first; f < first + count; ++f) {
      sum.normal += sum.frames[f].normal;
      sum.right += sum.frames[f].right;
      sum.cost += sum.frames[f].cost;
      sum.frames[f].normal.resize(0, 0);
    }
  }
  return sum;
}

FitState moved_state(const FitState& from, const SummedEquations& equations,
                     const Eigen::VectorXd& step) {
  constexpr double kMostWidening = 0.5;
  FitState to = from;
  move_curves(to.curves, {step.data(), step.data() + step.size() - 1});
  to.width_pixels *= std::exp(std::clamp(step[step.size() - 1], -kMostWidening, kMostWidening));
  for (std::size_t f = 0; f < to.frames.size(); ++f)
    move_state(to.frames[f], equations.frames[f], step);
  return to;
}

/// The greatest part of its radius by which a step moves a node, or changes its radius.
double size_of(const Eigen::VectorXd& step, const TreeCurves& curves) {
  double most = 0.0;
  for (const TreeCurve& curve : curves.curves)
    for (std::size_t n = 0; n < curve.node.size(); ++n) {
      const double* by = step.data() + curve.first_parameter + 3 * std::ptrdiff_t(n);
      const double away = std::hypot(by[0], by[1]) / std::exp(curve.log_radius[n]);
      most = std::max({most, away, std::abs(by[2])});
    }
  return most;
}

/// Contrast, background and noise of each frame under the tree as it is: linear, but for the noise.
void start_frames(const std::vector<FitFrame>& frames, FitState& state) {
  constexpr int kRounds = 3;
  const SampledCurves sampled = sample_curves(state.curves);
  const Eigen::VectorXd stay = Eigen::VectorXd::Zero(3 * state.curves.node_count() + 1);
  parallel_for_uneven(std::ptrdiff_t(frames.size()), [&](std::ptrdiff_t n) {
    const FitFrame& frame = frames[std::size_t(n)];
    FrameState& own = state.frames[std::size_t(n)];
    own.background.assign(2 * std::size_t(frame.hat_count), 0.0);
    own.noise = 1.0;
    for (int round = 0; round < kRounds; ++round) {
      const FrameEquations equations =
          frame_equations(frame, own, sampled, state.width_pixels, MotionPrior{});
      if (round > 0) own.noise = noise_of(equations);
      move_state(own, equations, stay);
    }
  });
}

/// Damped steps from a state while they lead down.
class Descent {
 public:
  Descent(const std::vector<FitFrame>& frames, const MotionPrior& prior, FitState state)
      : frames_(frames), prior_(prior), state_(std::move(state)) {
    start_again();
  }
  /// After the noise or the smoothness has changed.
  void start_again() { equations_ = sum_equations(frames_, state_, prior_); }
  /// @return the step's size; 0: no step leads down
  double step();

  [[nodiscard]] FitState& state() { return state_; }
  [[nodiscard]] const SummedEquations& equations() const { return equations_; }
  [[nodiscard]] Eigen::MatrixXd covariance() const {
    return equations_.normal.ldlt().solve(
        Eigen::MatrixXd::Identity(equations_.normal.rows(), equations_.normal.cols()));
  }

 private:
  const std::vector<FitFrame>& frames_;
  MotionPrior prior_;
  FitState state_;
  SummedEquations equations_;
  double damping_ = kFirstDamping;
};

double Descent::step() {
  constexpr double kMostSize = 0.5;
  for (; damping_ < kMostDamping; damping_ *= 10.0) {
    Eigen::MatrixXd damped = equations_.normal;
    damped.diagonal() *= 1.0 + damping_;
    const Eigen::VectorXd by = damped.ldlt().solve(equations_.right);
    const double size = size_of(by, state_.curves);
    if (!by.allFinite() || size > kMostSize) continue;
    FitState there = moved_state(state_, equations_, by);
    SummedEquations equations = sum_equations(frames_, there, prior_);
    if (!(equations.cost < equations_.cost)) continue;
    state_ = std::move(there);
    equations_ = std::move(equations);
    damping_ = std::max(kLeastDamping, 0.1 * damping_);
    return size;
  }
  damping_ = kFirstDamping;
  return 0.0;
}

bool are_similar(const Smoothness& a, const Smoothness& b) {
  return std::abs(std::log(a.place_sd / b.place_sd)) < kSameSpread &&
         std::abs(std::log(a.radius_sd / b.radius_sd)) < kSameSpread;
}

}  // namespace

TreeSolution solve_tree(const std::vector<FitFrame>& frames, FitState state,
                        const MotionPrior& prior, int most_steps, const Progress& progress) {
  start_frames(frames, state);
  Descent descent(frames, prior, std::move(state));
  TreeSolution solution;
  while (solution.steps < most_steps && !solution.converged) {
    double size = 0.0;
    for (int n = 0; n < kFewSteps && solution.steps < most_steps; ++n) {
      progress.report(double(solution.steps) / most_steps,
                      fmt::format("fitting the tree to the frames, step {}", solution.steps + 1));
      size = descent.step();
      ++solution.steps;
      if (size < kSettled) break;
    }
    solution.correlation = correlation_of(frames, descent.equations().frames);
    FitState& now = descent.state();
    for (std::size_t f = 0; f < frames.size(); ++f)
      now.frames[f].noise =
          noise_of(descent.equations().frames[f]) * std::sqrt(solution.correlation);
    const Smoothness before = now.smoothness;
    now.smoothness = likelier_smoothness(now.curves, before, descent.covariance());
    solution.converged = size < kSettled && are_similar(before, now.smoothness);
    descent.start_again();
  }
  solution.covariance = descent.covariance();
  solution.state = std::move(descent.state());
  return solution;
}

}  // namespace angio::reconstruction::detail
