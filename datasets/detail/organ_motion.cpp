#include "datasets/detail/organ_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "core/units.hpp"
#include "datasets/detail/scan.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kSecondsPerMinute = 60.0;
constexpr double kBeatSd = 0.03;

struct Key {
  double phase = 0.0, excursion = 0.0;
};
/// One beat, and a key beyond each of its ends.
constexpr std::array<Key, 10> kBeat = {{{-0.08, 0.06},
                                        {0.0, 0.12},
                                        {0.06, 0.25},
                                        {0.35, 1.0},
                                        {0.52, 0.25},
                                        {0.65, 0.04},
                                        {0.75, 0.0},
                                        {0.84, 0.02},
                                        {1.0, 0.12},
                                        {1.06, 0.25}}};

/// The slope at a key: the weighted harmonic mean of those to its neighbours, none at an extremum.
double slope_at(std::size_t k) {
  const auto step = [](std::size_t to) { return kBeat[to].phase - kBeat[to - 1].phase; };
  const auto rise = [&](std::size_t to) {
    return (kBeat[to].excursion - kBeat[to - 1].excursion) / step(to);
  };
  const double before = rise(k), after = rise(k + 1);
  if (!(before * after > 0.0)) return 0.0;
  const double w0 = 2.0 * step(k + 1) + step(k), w1 = step(k + 1) + 2.0 * step(k);
  return (w0 + w1) / (w0 / before + w1 / after);
}

}  // namespace

double heart_excursion(double phase) {
  const double p = phase - std::floor(phase);
  std::size_t k = 1;
  while (kBeat[k + 1].phase <= p) ++k;
  const double length = kBeat[k + 1].phase - kBeat[k].phase, t = (p - kBeat[k].phase) / length;
  const double h = t * t * (3.0 - 2.0 * t);
  return (1.0 - h) * kBeat[k].excursion + h * kBeat[k + 1].excursion +
         length * t * (1.0 - t) * ((1.0 - t) * slope_at(k) - t * slope_at(k + 1));
}

double breath_excursion(double time_s, double breaths_per_min) {
  const double s = std::sin(units::kPi * time_s * breaths_per_min / kSecondsPerMinute);
  return s * s * s * s * s * s;
}

std::vector<double> r_waves(double beats_per_min, double from_s, double to_s, std::uint64_t seed) {
  const double beat = kSecondsPerMinute / beats_per_min;
  const std::uint64_t own = seed ^ 0x4ea7ULL;
  // A part of a beat that is even over it, by the normal distribution's own integral.
  const double part = 0.5 * std::erfc(normal_number(own, 0) / std::sqrt(2.0));
  std::vector<double> times = {from_s - part * beat};
  for (std::uint64_t n = 1; times.back() <= to_s; ++n)
    times.push_back(times.back() +
                    beat * std::clamp(1.0 + kBeatSd * normal_number(own, n), 0.8, 1.2));
  return times;
}

double cardiac_phase(const std::vector<double>& r_waves, double time_s) {
  const auto after = std::upper_bound(r_waves.begin(), r_waves.end(), time_s);
  ANGIO_EXPECT(after != r_waves.begin() && after != r_waves.end());
  return (time_s - after[-1]) / (after[0] - after[-1]);
}

std::vector<Vec3> systolic_ways(const TriangleMesh& surface, double largest_mm) {
  constexpr double kSteepest = 0.5;
  const Vec3 axis = normalized(Vec3{1.0, -1.0, -1.0});
  double extent = 0.0, longest = 0.0;
  for (const Vec3& v : surface.vertices) extent = std::max(extent, norm(v));
  std::vector<Vec3> ways;
  for (const Vec3& v : surface.vertices) {
    const double along = dot(axis, v);
    ways.push_back(0.45 * axis - 0.5 / extent * (v - along * axis) +
                   0.35 * along / (extent * extent) * cross(axis, v));
    longest = std::max(longest, norm(ways.back()));
  }
  const double scale = largest_mm / longest;
  if (scale > kSteepest * extent)
    throw OptionError("run.heartbeat_mm: at most " +
                      std::to_string(int(kSteepest * extent * longest)) +
                      " of this phantom (its vessels would fold)");
  for (Vec3& way : ways) way *= scale;
  return ways;
}

RunMotion plan_motion(const RotationalRunOptions& run, std::uint64_t seed) {
  RunMotion motion;
  const double step = run.frame_time_ms / 1000.0, last = step * (run.frames - 1);
  std::vector<double> beats;
  if (run.heartbeat_mm > 0.0) {
    beats = r_waves(run.heart_rate_per_min, 0.0, last, seed);
    for (const double time : beats)
      if (const double frame = std::round(time / step); frame >= 0.0 && frame < run.frames)
        motion.r_wave_frames.push_back(int(frame));
  }
  for (int f = 0; f < run.frames; ++f) {
    const double time = f * step;
    motion.cardiac_phases.push_back(beats.empty() ? kRestingPhase : cardiac_phase(beats, time));
    motion.heart_excursions.push_back(beats.empty()
                                          ? 0.0
                                          : heart_excursion(motion.cardiac_phases.back()) -
                                                heart_excursion(kRestingPhase));
    const double breath = run.breathing_mm * breath_excursion(time, run.breaths_per_min);
    // The diaphragm goes down and the chest's wall forward.
    motion.breathing_shifts_mm.push_back(breath * normalized(Vec3{0.0, -0.3, -1.0}));
    motion.filled_parts.push_back(run.inflow_s > 0.0 ? std::min(1.0, time / run.inflow_s) : 1.0);
  }
  return motion;
}

TriangleMesh moved_surface(const TriangleMesh& surface, const std::vector<Vec3>& ways,
                           const RunMotion& motion, std::size_t frame) {
  TriangleMesh moved = surface;
  for (std::size_t v = 0; v < moved.vertices.size(); ++v) {
    moved.vertices[v] += motion.breathing_shifts_mm[frame];
    if (!ways.empty()) moved.vertices[v] += motion.heart_excursions[frame] * ways[v];
  }
  return moved;
}

}  // namespace angio::datasets::detail
