#include "simulation/step/make_views.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.hpp"
#include "simulation/bodies/element_colors.hpp"
#include "simulation/contact/candidates.hpp"

namespace angio::simulation::detail {

double balloon_volume(const Scene& scene, const std::vector<Vec3>& x) {
  double volume = 0.0;
  const Vec3 origin = x[0];
  for (const Triangle& t : scene.balloon_triangles)
    volume += dot(x[std::size_t(t[0])] - origin,
                  cross(x[std::size_t(t[1])] - origin, x[std::size_t(t[2])] - origin));
  return volume / 6.0;
}

State start_state(const Scene& scene, double pressure) {
  State state;
  state.x = scene.start;
  state.plastic.assign(std::size_t(scene.clusters.count()), Mat3::identity());
  state.contact_pressure.assign(std::size_t(scene.wall_count), 0.0);
  state.solid_points = scene.solid.model.points;
  state.solid_plastic_strain.assign(state.solid_points.size(), 0.0);
  state.pressure = pressure;
  state.volume = balloon_volume(scene, state.x);
  return state;
}

Precision precision_for(const Scene& scene, const SimulationOptions& options) {
  if (scene.solid.levels > 0) return Precision::twofold;  // thin, nearly incompressible layers
  // Its tets do not settle: what one rounding changes is a millionfold larger at the end.
  if (options.gas_model == GasModel::per_tet) return Precision::twofold;
  double reach = 0.0, edge = 0.0;
  for (int v = 0; v < scene.balloon_count; ++v)
    reach = std::max(reach, norm(scene.start[std::size_t(v)] - scene.origin));
  for (const Edge& e : scene.balloon_edges)
    edge += distance(scene.start[std::size_t(e[0])], scene.start[std::size_t(e[1])]);
  edge /= double(scene.balloon_edges.size());
  // Bounds of motion leave the least gap: it must stand out from the spacing of positions.
  constexpr double kSpacingsInLeastGap = 40.0;
  double far = 0.0;
  for (const Vec3& p : scene.start) far = std::max(far, norm(p - scene.origin));
  const double spacing = double(std::numeric_limits<float>::epsilon()) * far;
  if (scene.wall_count > 0 &&
      kSpacingsInLeastGap * spacing > kLeastGap * options.contact_distance_mm)
    return Precision::twofold;
  // On a vertex: the skin's force for a strain s is about E h s edge, the load p edge^2, E = 6 (C1
  // + C2); rounding errors of half a spacing in six triangles largely cancel.
  const double strain = 0.25 * double(std::numeric_limits<float>::epsilon()) * reach / edge;
  const double stiffness = 6.0 * (scene.skin.base.c1 + scene.skin.base.c2) * scene.wall_mm;
  const double load = units::pascal_from_atm(options.inflation.peak_pressure_atm) * edge;
  return stiffness * strain < 0.5 * StepRules{}.residual * load ? Precision::single
                                                                : Precision::twofold;
}

PaperTets paper_tets(const Scene& scene, const SimulationOptions& options,
                     const std::vector<Tet>& air) {
  PaperTets result;
  for (Tet t : air) {
    const auto of_balloon = [&](int v) { return v < scene.balloon_count; };
    const auto corners = std::count_if(t.begin(), t.end(), of_balloon);
    if (*std::max_element(t.begin(), t.end()) >= scene.vertex_count()) continue;  // in the air
    if (corners == 0 || corners == 4) continue;
    bool even = true;
    for (std::size_t i = 0; i < 4; ++i)  // those of the balloon first
      for (std::size_t k = 3; k > i; --k)
        if (of_balloon(t[k]) && !of_balloon(t[k - 1])) {
          std::swap(t[k], t[k - 1]);
          even = !even;
        }
    if (!even)  // within a side the order is free
      corners == 1 ? std::swap(t[2], t[3]) : std::swap(t[0], t[1]);
    result.vertices.insert(result.vertices.end(), t.begin(), t.end());
    result.balloon_corners.push_back(int(corners));
  }
  if (air.empty())
    throw InputError(
        "contact.model paper needs an air mesh between balloon and wall, and there is none. Run "
        "the stage meshing again, or use contact.model barrier");
  const ElementColors colors = color_elements(result.vertices, 4, scene.vertex_count());
  result.vertices = in_order(colors, result.vertices, 4);
  result.balloon_corners = in_order(colors, result.balloon_corners);
  result.color_begin = colors.begin;
  for (std::size_t v = 0; v < scene.mass.size(); ++v)
    result.inverse_mass.push_back(scene.fixed[v] ? 0.0 : 1.0 / scene.mass[v]);
  double area = 0.0;
  for (const double a : scene.wall_area) area += a;
  const double face = area / double(scene.wall_triangles.size());
  const bool given = options.paper_volume_2_mm3 > 0.0;
  result.volume_1 = given ? options.paper_volume_1_mm3 : face * options.adhesion_gap_1_mm / 3.0;
  result.volume_2 = given ? options.paper_volume_2_mm3 : face * options.adhesion_gap_2_mm / 3.0;
  return result;
}

std::vector<char> kept_items(const PaperTets& before, const std::vector<char>& triggered,
                             const PaperTets& now) {
  const auto corners = [](const PaperTets& tets, std::size_t t) {
    const int* v = &tets.vertices[4 * t];
    Tet sorted{v[0], v[1], v[2], v[3]};
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  std::set<Tet> held;
  for (std::size_t t = 0; t < triggered.size(); ++t)
    if (triggered[t] != 0) held.insert(corners(before, t));
  std::vector<char> result;
  for (std::size_t t = 0; t < now.balloon_corners.size(); ++t)
    result.push_back(held.count(corners(now, t)) > 0 ? 1 : 0);
  return result;
}

PaperGasTets paper_gas_tets(const Scene& scene) {
  if (scene.guidewire.empty())
    throw InputError(
        "simulation.gas_model per_tet needs a guidewire in the balloon, and there is none. Run the "
        "stage meshing again, or use simulation.gas_model = enclosed");
  PaperGasTets tets;
  tets.whole = balloon_volume(scene, scene.start);
  for (const Triangle& t : scene.balloon_triangles) {
    const Vec3 &a = scene.start[std::size_t(t[0])], &b = scene.start[std::size_t(t[1])],
               &c = scene.start[std::size_t(t[2])];
    const Vec3 middle = (a + b + c) / 3.0;
    const Vec3 apex = *std::min_element(
        scene.guidewire.begin(), scene.guidewire.end(),
        [&](const Vec3& p, const Vec3& q) { return distance(p, middle) < distance(q, middle); });
    const double volume = tet_volume(apex, a, b, c);
    if (!(volume > 1e-9 * tets.whole)) continue;
    tets.apex.push_back(apex);
    tets.triangles.insert(tets.triangles.end(), t.begin(), t.end());
    tets.volume.push_back(volume);
  }
  const ElementColors colors = color_elements(tets.triangles, 3, scene.balloon_count);
  tets.apex = in_order(colors, tets.apex);
  tets.triangles = in_order(colors, tets.triangles, 3);
  tets.volume = in_order(colors, tets.volume);
  tets.color_begin = colors.begin;
  return tets;
}

double mean_tet_pressure(const PaperGasTets& tets, double growth, double outside,
                         const std::vector<Vec3>& x) {
  double volume = 0.0, target = 0.0;
  for (std::size_t t = 0; t < tets.volume.size(); ++t) {
    const auto at = [&](std::size_t k) { return x[std::size_t(tets.triangles[3 * t + k])]; };
    volume += tet_volume(tets.apex[t], at(0), at(1), at(2));
    target += growth * tets.volume[t];
  }
  return outside * target / volume;
}

StepRules make_rules(const Scene& scene, const SimulationOptions& options) {
  constexpr int kMostSweeps = 120;
  constexpr int kPaperSweeps = 20;  // what the paper projects never balances: a count, no tolerance
  constexpr int kMostFactor = 6;    // up to this many times the number asked for
  constexpr int kLastFactor = 24;
  constexpr double kLeastShare = 0.25;  // of the rest radius: none is more exact for a slim start
  StepRules rules;
  rules.least_sweeps = options.sweeps;
  rules.most_sweeps = options.sweeps > 0 ? kMostFactor * options.sweeps : kMostSweeps;
  if (options.contact_model == ContactModel::paper || options.gas_model == GasModel::per_tet)
    rules.least_sweeps = rules.most_sweeps = options.sweeps > 0 ? options.sweeps : kPaperSweeps;
  rules.later_sweeps = rules.most_sweeps / 2;
  if (scene.wall_count > 0 && rules.least_sweeps < rules.most_sweeps)
    rules.last_sweeps = kLastFactor * rules.most_sweeps;
  rules.still = options.gas_model == GasModel::per_tet;
  rules.tolerance = options.tolerance;
  // Of a cylinder of the balloon's volume and length.
  double length = 0.0;
  for (std::size_t v = 0; v < std::size_t(scene.balloon_count); ++v)
    length = std::max(length, norm(scene.start[v] - scene.origin));
  const double volume = balloon_volume(scene, scene.start);
  rules.radius =
      std::max(std::sqrt(volume / (units::kPi * 2.0 * length)), kLeastShare * scene.rest_radius);
  rules.least_load = 0.1 * units::pascal_from_atm(options.inflation.peak_pressure_atm);
  return rules;
}

CandidateSet CandidateFinder::find(const std::vector<Vec3>& x, int lasted) {
  lasted_ += lasted;
  if (!(scene_.self_distance > 0.0)) {
    const std::vector<Candidate> candidates = find_others(x);
    return index_candidates(x.size(), candidates, reach_, lists_);
  }
  // Neighbours on a surface are near each other, layers everywhere: their candidates are used up
  // far sooner than those of what is around, of which a wide set is kept.
  const double room = 2.0 * (most_travel(scene_) + kOwnSlack) * distance_, reach = range_ + room;
  if (first_ || !(reach < reach_ - closed_at_most(x))) {
    others_ = find_others(x);
    x_others_ = x;
  }
  std::vector<Candidate> candidates;
  for (Candidate other : others_)
    if (is_near(x, reach, other)) candidates.push_back(other);
  add_skin_candidates(scene_, x, scene_.self_distance + room, candidates);
  add_wall_candidates(scene_, x, scene_.self_distance + room, candidates);
  CandidateSet set = index_candidates(x.size(), candidates, reach, lists_);
  set.skin_reach = scene_.self_distance + room;
  return set;
}

std::vector<Candidate> CandidateFinder::find_others(const std::vector<Vec3>& x) {
  if (!first_ && lasted_ < frames_) slack_ = std::min(1.5 * slack_, kMostSlack);
  if (!first_ && lasted_ > 2 * frames_) slack_ = std::max(slack_ / 1.5, kLeastSlack);
  first_ = false;
  lasted_ = 0;
  // A search reaches 2 x 2 contact distances beyond the range at most (useful_travel).
  reach_ = range_ + (4.0 + 2.0 * slack_) * distance_;
  std::vector<Candidate> candidates;
  if (of_wall_) candidates = find_candidates(scene_, x, reach_);
  if (scene_.rod.count > 0) add_rod_candidates(scene_, x, distance_, reach_, candidates);
  return candidates;
}

double CandidateFinder::closed_at_most(const std::vector<Vec3>& x) const {
  double gone[2] = {0.0, 0.0};
  for (std::size_t v = 0; v < x.size(); ++v) {
    double& side = gone[int(v) < scene_.balloon_count ? 0 : 1];
    side = std::max(side, distance(x[v], x_others_[v]));
  }
  return gone[0] + gone[1];
}

}  // namespace angio::simulation::detail
