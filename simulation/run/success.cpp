#include "simulation/run/success.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "simulation/pbd/policy.hpp"

namespace angio::simulation::detail {
namespace {

constexpr double kCrossing = 1e-3;     // of the contact distance
constexpr double kMostPressure = 5.0;  // over the peak

constexpr const char* kSmallerBalloon =
    "Try a smaller balloon (balloon.nominal_diameter_mm), a shorter one (balloon.length_mm), or "
    "another place (lesion.abscissa_mm)";
constexpr const char* kFinerSteps =
    "Try a shorter simulation.frame_s, a smaller or shorter balloon (balloon.nominal_diameter_mm, "
    "balloon.length_mm), or another place (lesion.abscissa_mm)";

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

}  // namespace

PatchPressure patch_pressure(const Scene& scene, const State& state, double radius) {
  constexpr int kRings = 2, kChunks = 16;
  const int first = scene.bodies.wall().first, count = scene.bodies.wall().count;
  const auto place = [&](int v) { return state.x[std::size_t(first + v)]; };
  std::vector<double> area(std::size_t(count), 0.0);
  for (const Triangle& t : scene.wall.triangles) {
    const Vec3 &a = state.x[std::size_t(t[0])], &b = state.x[std::size_t(t[1])],
               &c = state.x[std::size_t(t[2])];
    for (const int v : t) area[std::size_t(v - first)] += norm(cross(b - a, c - a)) / 6.0;
  }
  std::vector<int> touched;
  for (int v = 0; v < count; ++v)
    if (state.contact_pressure[std::size_t(v)] > 0.0) touched.push_back(v);
  const auto worst_of = [&](std::size_t begin, std::size_t end) {
    PatchPressure worst;
    std::vector<int> mark(std::size_t(count), -1), patch;
    for (std::size_t n = begin; n < end; ++n) {
      const int v = touched[n];
      patch.assign(1, v);
      mark[std::size_t(v)] = v;
      std::size_t next = 0;
      for (int ring = 1; next < patch.size(); ++ring)
        for (const std::size_t ring_end = patch.size(); next < ring_end; ++next) {
          const auto i = std::size_t(patch[next]);
          for (int k = scene.wall.neighbor_begin[i]; k < scene.wall.neighbor_begin[i + 1]; ++k) {
            const int u = scene.wall.neighbors[std::size_t(k)] - first;
            if (mark[std::size_t(u)] == v) continue;
            if (ring > kRings && distance(place(u), place(v)) > radius) continue;
            mark[std::size_t(u)] = v;
            patch.push_back(u);
          }
        }
      double whole = 0.0, force = 0.0;
      for (const int u : patch) {
        whole += area[std::size_t(u)];
        force += area[std::size_t(u)] * state.contact_pressure[std::size_t(u)];
      }
      if (force > worst.pressure * whole) worst = {force / whole, v};
    }
    return worst;
  };
  PatchPressure parts[kChunks];
  parallel_for_uneven(kChunks, [&](std::ptrdiff_t k) {
    const auto at = [&](std::ptrdiff_t chunk) {
      return touched.size() * std::size_t(chunk) / kChunks;
    };
    if (at(k) < at(k + 1)) parts[k] = worst_of(at(k), at(k + 1));
  });
  PatchPressure worst;
  for (const PatchPressure& part : parts)
    if (part.pressure > worst.pressure) worst = part;
  return worst;
}

SuccessWatch::SuccessWatch(const Scene& scene, const SimulationModel& model,
                           const SimulationOptions& options)
    : scene_(scene),
      model_(model),
      is_judged_(pbd_policy(options).balances()),
      peak_pressure_(units::pascal_from_atm(options.inflation.peak_pressure_atm)),
      contact_distance_(options.contact.distance_mm) {}

void SuccessWatch::fail(const SimulationFrame& frame, const std::string& what,
                        const std::string& advice) {
  if (failure_.empty())
    failure_ = "the simulation did not end right: " + what +
               text(" in frame %d (%s, %.2f s), where it was stopped. ", frame.frame,
                    name(frame.phase), frame.time_s) +
               advice;
}

SuccessWatch::Look SuccessWatch::look(const State& state) const {
  if (!is_judged_) return {};
  const bool is_finite = std::isfinite(state.volume) &&
                         std::all_of(state.x.begin(), state.x.end(),
                                     [](const Vec3& p) { return std::isfinite(p.x + p.y + p.z); });
  if (!is_finite) return {false, {}};
  return {true, patch_pressure(scene_, state, 0.5 * model_.reference_radius_mm)};
}

void SuccessWatch::judge(const Look& look, const SimulationFrame& frame) {
  if (!is_judged_) return;
  if (!look.is_finite)
    return fail(frame, "positions are not finite (it has diverged)", kFinerSteps);
  if (frame.contact.max_penetration_mm > kCrossing * contact_distance_)
    fail(frame,
         text("balloon and vessel wall cross by %.4f mm (they are too near each other there for "
              "their contact to be resolved)",
              frame.contact.max_penetration_mm),
         kSmallerBalloon);
  const double ratio = look.patch.pressure / peak_pressure_;
  worst_ratio_ = std::max(worst_ratio_, ratio);
  if (ratio > kMostPressure) {
    const int vertex =
        scene_.caller_vertex[std::size_t(scene_.bodies.wall().first + look.patch.vertex)];
    const double abscissa =
        model_.wall_abscissa.empty() ? 0.0 : model_.wall_abscissa[std::size_t(vertex)];
    fail(
        frame,
        text("the wall carries %.1f times the balloon's pressure, %.0f kPa, %.1f mm along the line "
             "(the balloon is wedged in there)",
             ratio, units::kilopascal_from_pascal(look.patch.pressure), abscissa),
        kSmallerBalloon);
  }
  // Without a wall the balloon itself says whether it has a state of rest: a warning.
  if (scene_.bodies.wall().count > 0 && frame.residual > kOffBalance)
    fail(frame,
         text("the forces are off balance by %.0f %% (the balloon finds no state of rest)",
              100.0 * frame.residual),
         kFinerSteps);
}

}  // namespace angio::simulation::detail
