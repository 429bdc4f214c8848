#pragma once

#include <algorithm>
#include <vector>

#include "simulation/contact/candidate_set.hpp"
#include "simulation/contact/candidates.hpp"
#include "simulation/pbd/policy.hpp"

namespace angio::simulation::detail {

/// The gap beyond which nothing acts between two surfaces [mm].
inline double contact_range(const SimulationOptions& options) {
  return options.contact.adhesion_traction_kpa > 0.0
             ? std::max(options.contact.distance_mm, options.contact.adhesion_gap_2_mm)
             : options.contact.distance_mm;
}

/// What a search for pairs of one surface reaches beyond `most_move`, over the contact distance.
inline constexpr double kSelfSlack = 1.5;
/// What a search on the GPU reaches beyond the range, at most, over the contact distance.
inline constexpr double kMostReach = 20.0;

/// Finds a run's candidates, on the CPU, from positions relative to the scene's origin.
class CandidateFinder {
 public:
  /// @param frames  that a set of candidates should last: their radius follows from how long the
  ///                last set did
  CandidateFinder(const Scene& scene, const SimulationOptions& options, int frames)
      : scene_(scene),
        distance_(options.contact.distance_mm),
        range_(contact_range(options)),
        of_wall_(!pbd_policy(options).contact),
        frames_(frames) {}

  /// @param lasted  frames that were begun with the last set
  CandidateSet find(const std::vector<Vec3>& x, int lasted);

 private:
  static constexpr double kLeastSlack = 1.0, kMostSlack = 20.0;  // over the contact distance

  /// Pairs of the balloon with the wall and the guidewire, within `search_radius_`.
  [[nodiscard]] std::vector<Candidate> find_others(const std::vector<Vec3>& x);
  [[nodiscard]] double closed_at_most(const std::vector<Vec3>& x) const;

  const Scene& scene_;
  double distance_, range_, slack_ = 4.0, search_radius_ = 0.0;
  bool of_wall_;  // else only the guidewire's: the reference method's contact has none
  int frames_, lasted_ = 0;
  bool first_ = true;
  // With pairs of one surface: the others as they were found last.
  std::vector<Candidate> others_;
  std::vector<Vec3> x_others_;
};

}  // namespace angio::simulation::detail
