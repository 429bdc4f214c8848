#include "segmentation/detail/projection_angles.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kFullTurn = 360.0;
constexpr double kStillDegrees = 0.5;  ///< a C-arm's sway
constexpr double kUnevenRatio = 3.0;   ///< largest step to the median one

void add_up(std::vector<double>& angles, double base) {
  double angle = base;
  for (double& increment : angles) increment = angle += increment - base;
}

void judge_turn(const std::vector<double>& angles, const std::string& name, ProjectionRun& run) {
  const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
  const double range = *most - *least;
  if (range < kStillDegrees) return;
  if (range > kFullTurn) {
    run.notes.push_back(name + " angles: they span " + format_number(range) +
                        " degrees, more than a turn (increments may be meant from the base: leave "
                        "--angles cumulative out)");
    return;
  }
  std::vector<double> steps;
  bool back = false;
  const double way = angles.back() >= angles.front() ? 1.0 : -1.0;
  for (std::size_t f = 1; f < angles.size(); ++f) {
    back = back || way * (angles[f] - angles[f - 1]) < -kStillDegrees;
    steps.push_back(std::abs(angles[f] - angles[f - 1]));
  }
  std::sort(steps.begin(), steps.end());
  if (back)
    run.notes.push_back(name + " angles: they go back and forth, as a rotating C-arm does not");
  else if (steps.back() > kUnevenRatio * std::max(steps[steps.size() / 2], kStillDegrees))
    run.notes.push_back(name + " angles: the steps are uneven, up to " +
                        format_number(steps.back()) + " degrees (frames may be missing)");
}

void settle(std::vector<double>& angles, double base, int frame_count, AngleIncrements increments,
            const std::string& name, ProjectionRun& run) {
  if (angles.empty()) {
    run.notes.push_back(name + " angle: not stated");
    return;
  }
  if (angles.size() > 1 && int(angles.size()) != frame_count)
    run.notes.push_back(name + " angles: " + std::to_string(angles.size()) + " for " +
                        std::to_string(frame_count) + " frames");
  if (angles.size() < 2) return;
  const bool alike = std::abs(angles.front() - base) > 1e-6 &&
                     std::all_of(angles.begin(), angles.end(), [&](double angle) {
                       return std::abs(angle - angles.front()) < 1e-6;
                     });
  if (increments == AngleIncrements::cumulative)
    add_up(angles, base);
  else if (alike)
    run.notes.push_back(name + " angles: every increment is " +
                        format_number(angles.front() - base) +
                        " degrees; if the C-arm turned, they are steps from frame to frame (give "
                        "--angles cumulative)");
  judge_turn(angles, name, run);
}

}  // namespace

void settle_angles(ProjectionRun& run, int frame_count, AngleIncrements increments) {
  settle(run.primary_angles_degrees, run.base_angles_degrees[0], frame_count, increments, "primary",
         run);
  settle(run.secondary_angles_degrees, run.base_angles_degrees[1], frame_count, increments,
         "secondary", run);
}

}  // namespace angio::segmentation::detail
