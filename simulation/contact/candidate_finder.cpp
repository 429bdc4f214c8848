#include "simulation/contact/candidate_finder.hpp"

#include <algorithm>

#include "simulation/step/bounded_motion.hpp"

namespace angio::simulation::detail {

CandidateSet CandidateFinder::find(const std::vector<Vec3>& x, int lasted) {
  lasted_ += lasted;
  if (!(scene_.self_distance > 0.0)) {
    const std::vector<Candidate> candidates = find_others(x);
    return index_candidates(x.size(), candidates, search_radius_);
  }
  // Neighbours on a surface are near each other, layers everywhere: their candidates are used up
  // far sooner than those of what is around, of which a wide set is kept.
  const double free_move =
      2.0 * (most_move(scene_.balloon.has_folds, scene_.self_distance) + kSelfSlack) * distance_;
  const double radius = range_ + free_move, self_radius = scene_.self_distance + free_move;
  if (first_ || !(radius < search_radius_ - closed_at_most(x))) {
    others_ = find_others(x);
    x_others_ = x;
  }
  std::vector<Candidate> candidates;
  for (Candidate other : others_)
    if (is_near(x, radius, other)) candidates.push_back(other);
  add_balloon_self_candidates(scene_, x, self_radius, candidates);
  add_wall_self_candidates(scene_, x, self_radius, candidates);
  CandidateSet set = index_candidates(x.size(), candidates, radius);
  set.radii.self = self_radius;
  return set;
}

std::vector<Candidate> CandidateFinder::find_others(const std::vector<Vec3>& x) {
  if (!first_ && lasted_ < frames_) slack_ = std::min(1.5 * slack_, kMostSlack);
  if (!first_ && lasted_ > 2 * frames_) slack_ = std::max(slack_ / 1.5, kLeastSlack);
  first_ = false;
  lasted_ = 0;
  // A search reaches 2 x 2 contact distances beyond the range at most (useful_move).
  search_radius_ = range_ + (4.0 + 2.0 * slack_) * distance_;
  std::vector<Candidate> candidates;
  if (of_wall_) candidates = find_candidates(scene_, x, search_radius_);
  if (scene_.rod.count > 0) add_rod_candidates(scene_, x, distance_, search_radius_, candidates);
  return candidates;
}

double CandidateFinder::closed_at_most(const std::vector<Vec3>& x) const {
  double moved[kBodyCount] = {};
  for (std::size_t v = 0; v < x.size(); ++v) {
    double& body = moved[int(scene_.bodies.of(int(v)))];
    body = std::max(body, distance(x[v], x_others_[v]));
  }
  return most_of_pairs(moved);
}

}  // namespace angio::simulation::detail
