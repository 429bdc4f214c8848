#include "segmentation/detail/rotational_run.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kLeastTurn = 40.0;  ///< [degrees]
constexpr double kOneTurn = 360.0;
constexpr double kStillMm = 0.5;
constexpr int kLeastFrames = 3;

double range(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return *most - *least;
}

double turn_of(const ProjectionRun& run) {
  return std::max(range(run.primary_angles_degrees), range(run.secondary_angles_degrees));
}

/// What to try where increments may be steps from frame to frame.
std::string hint_of_steps(const ProjectionRun& run) {
  double sum = 0.0, least = kOneTurn, most = 0.0;
  for (std::size_t frame = 1; frame < run.primary_angles_degrees.size(); ++frame) {
    const double step = run.primary_angles_degrees[frame] - run.base_angles_degrees[0];
    sum += step;
    least = std::min(least, std::abs(step));
    most = std::max(most, std::abs(step));
  }
  if (most > 2.0 * least) return {};  // they grow, as angles do
  if (std::abs(sum) < kLeastTurn || std::abs(sum) > kOneTurn) return {};
  return "; its increments add up to " + format_number(std::abs(sum)) +
         " degrees: where they are steps from frame to frame, give --angles cumulative";
}

bool fits(const std::vector<double>& angles, int frames) {
  return angles.size() == 1 || int(angles.size()) == frames;
}

}  // namespace

bool turns(const ProjectionRun& run) {
  return turn_of(run) >= kLeastTurn || (run.positioner_motion == "DYNAMIC" && turn_of(run) > 0.0);
}

std::string refusal_of_distances(const ProjectionRun& run) {
  if (!run.source_to_detector_mm || !run.source_to_isocentre_mm)
    return "the run does not state its distances from the source to the detector and to the "
           "isocentre (an anonymiser may have removed them). Export it again, or give its "
           "geometry with --geometry";
  if (*run.source_to_detector_mm <= *run.source_to_isocentre_mm)
    return "the run's detector is nearer to the source than its isocentre (" +
           format_number(*run.source_to_detector_mm) + " and " +
           format_number(*run.source_to_isocentre_mm) +
           " mm; its header is damaged). Give its geometry with --geometry";
  constexpr double kLeastMm = 300.0;  // of the smallest C-arms, for hands: 360
  if (*run.source_to_detector_mm < kLeastMm)
    return "the run's detector is said to be " + format_number(*run.source_to_detector_mm) +
           " mm from the source, which is no C-arm's (a distance in cm?). Give its geometry with "
           "--geometry";
  if (!(run.detector_spacing_mm[0] > 0.0))
    return "the run does not state its detector's pixel spacing. Export it again, or give its "
           "geometry with --geometry";
  return {};
}

std::string refusal_of_turn(const DicomHeader& header, const ProjectionRun& run) {
  if (!header.problem.empty()) return header.problem;
  const int frames = int(header.frames.size());
  if (frames < kLeastFrames)
    return "the run has " + std::to_string(frames) +
           " frames (a volume needs views from many sides). Give a rotational run";
  if (turn_of(run) < kLeastTurn)
    return "the run turns by " + format_number(turn_of(run)) +
           " degrees (depth is not told by an arc under 40). Give a rotational run, 180 degrees "
           "or more" +
           hint_of_steps(run);
  if (run.primary_angles_degrees.size() > 1 && !run.has_base_angle)
    return "the run tells by how much its primary angle changes, but not from where (the angle "
           "that "
           "the increments count from is missing: the volume would be turned, and every angle that "
           "is told). Export it again, or give its geometry with --geometry";
  if (run.positioner_motion == "STATIC")
    return "the run says that its positioner stands still, but its angles span " +
           format_number(turn_of(run)) +
           " degrees (its header contradicts itself). Export it again, or give its geometry with "
           "--geometry";
  if (!fits(run.primary_angles_degrees, frames) || !fits(run.secondary_angles_degrees, frames))
    return "the run has " +
           std::to_string(fits(run.primary_angles_degrees, frames)
                              ? run.secondary_angles_degrees.size()
                              : run.primary_angles_degrees.size()) +
           " angles for " + std::to_string(frames) +
           " frames (frames or angles are missing). Export it again";
  if (std::string why = refusal_of_distances(run); !why.empty()) return why;
  if (std::remainder(run.picture_turn_degrees, 90.0) != 0.0)
    return "the run's field of view is turned by " + format_number(run.picture_turn_degrees) +
           " degrees (0, 90, 180 and 270 are the values of FieldOfViewRotation). Export it again, "
           "or give its geometry with --geometry";
  if (run.table_travel_mm > kStillMm)
    return "the table moves by " + format_number(run.table_travel_mm) +
           " mm during the run (the patient is not where the angles say). Give a run with a table "
           "that stands still";
  return {};
}

}  // namespace angio::segmentation::detail
