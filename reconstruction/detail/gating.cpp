#include "reconstruction/detail/gating.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/heart_signal.hpp"
#include "reconstruction/detail/plane_frames.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kLeastBeats = 3.0;
constexpr double kLeastPixels = 0.5;
constexpr double kLeastRatio = 10.0;        ///< at a rate that R waves tell,
constexpr double kLeastRatioSought = 20.0;  ///< and at the best of many
constexpr int kLeastFramesOfBeat = 24;      ///< that tell a beat from noise
constexpr std::size_t kLeastGated = 6;
constexpr double kLeastStep = units::kPi / 180.0;  ///< between frames of a run without R waves

double median_beat(const std::vector<double>& r_waves) {
  std::vector<double> lengths;
  for (std::size_t n = 1; n < r_waves.size(); ++n) lengths.push_back(r_waves[n] - r_waves[n - 1]);
  const auto middle = lengths.begin() + std::ptrdiff_t(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

double fraction(double phase) { return phase - std::floor(phase); }

std::vector<int> all_frames(const RotationalRun& run) {
  std::vector<int> frames(run.frames.size());
  std::iota(frames.begin(), frames.end(), 0);
  return frames;
}

/// What tells the beats.
struct Phases {
  std::vector<double> of_frame;  ///< empty: nothing does
  Beat beat;
  double beats = 0.0;  ///< within the run
};

Phases find_phases(const RotationalRun& run, const std::vector<double>& signal,
                   const ReconstructionOptions& options) {
  const double length = run.times_s.back() - run.times_s.front();
  Phases phases;
  if (run.r_waves_s.size() >= 2) {
    phases.of_frame = cardiac_phases(run.times_s, run.r_waves_s);
    phases.beat = beat_of(signal, run.times_s, phases.of_frame);
    phases.beat.rate_per_s = 1.0 / median_beat(run.r_waves_s);
  } else {
    phases.beat = find_beat(signal, run.times_s);
    for (const double time : run.times_s)
      phases.of_frame.push_back(fraction(phases.beat.rate_per_s * (time - run.times_s.front()) -
                                         phases.beat.resting_phase +
                                         options.phase_percent / 100.0));
  }
  phases.beats = length * phases.beat.rate_per_s;
  return phases;
}

bool can_be_timed(const RotationalRun& run) {
  return run.times_s.size() == run.frames.size() && int(run.frames.size()) >= kLeastFramesOfBeat;
}

}  // namespace

std::vector<double> cardiac_phases(const std::vector<double>& times_s,
                                   const std::vector<double>& r_waves_s) {
  ANGIO_EXPECT(r_waves_s.size() >= 2);
  const double beat = median_beat(r_waves_s);
  std::vector<double> phases;
  for (const double time : times_s) {
    const auto after = std::upper_bound(r_waves_s.begin(), r_waves_s.end(), time);
    if (after == r_waves_s.begin())
      phases.push_back(fraction((time - r_waves_s.front()) / beat));
    else if (after == r_waves_s.end())
      phases.push_back(fraction((time - r_waves_s.back()) / beat));
    else
      phases.push_back((time - after[-1]) / (after[0] - after[-1]));
  }
  return phases;
}

std::vector<int> frames_of_phase(const std::vector<double>& phases, double middle, double width) {
  std::vector<int> frames;
  for (std::size_t f = 0; f < phases.size(); ++f)
    if (std::abs(fraction(phases[f] - middle + 0.5) - 0.5) <= 0.5 * width + 1e-9)
      frames.push_back(int(f));
  return frames;
}

GatedRun::GatedRun(const RotationalRun& run, const std::vector<int>& frames)
    : pictures_(run.pictures, frames), masks_(run.masks, frames), run_(run) {
  run_.pictures = &pictures_;
  if (run.masks) run_.masks = &masks_;
  run_.frames.clear();
  run_.times_s.clear();
  for (const int frame : frames) {
    run_.frames.push_back(run.frames[std::size_t(frame)]);
    if (!run.times_s.empty()) run_.times_s.push_back(run.times_s[std::size_t(frame)]);
  }
}

std::vector<float> GatedRun::Reader::read(int first, int count) const {
  std::vector<float> pixels;
  for (int n = first; n < first + count;) {  // neighbours at once
    const int from = frames_[std::size_t(n)];
    int number = 1;
    while (n + number < first + count && frames_[std::size_t(n + number)] == from + number)
      ++number;
    const std::vector<float> some = all_->read(from, number);
    pixels.insert(pixels.end(), some.begin(), some.end());
    n += number;
  }
  return pixels;
}

Gate gate_run(const RotationalRun& run, double air, const ReconstructionOptions& options,
              const Progress& progress) {
  Gate gate{all_frames(run), {}, {}};
  const bool must = options.gating == Gating::on;
  if (options.gating == Gating::off) return gate;
  if (!can_be_timed(run)) {
    if (must)
      throw InputError(fmt::format(
          "the run cannot be gated (its frames' times are not stated, or it has fewer than {} "
          "frames). Leave reconstruction.gating at auto",
          kLeastFramesOfBeat));
    return gate;
  }
  const Orbit orbit = fit_orbit(run.frames);
  if (!must && run.r_waves_s.size() < 2 && orbit.arc() < kLeastStep * double(run.frames.size()))
    return gate;
  const double pixel = plane_grid(run.frames, orbit).sample_mm;
  const Phases phases = find_phases(run, axial_shifts(run, air, orbit, pixel, progress), options);
  GatingQuality& quality = gate.quality;
  quality.signal_rms_mm = phases.beat.amplitude_mm;
  quality.signal_f_ratio = phases.beat.f_ratio;
  quality.beats = phases.beats;
  quality.heart_rate_per_min = 60.0 * phases.beat.rate_per_s;
  quality.by_r_waves = run.r_waves_s.size() >= 2;
  const double least_ratio = quality.by_r_waves ? kLeastRatio : kLeastRatioSought;
  const bool beats_in_frames =
      phases.beat.amplitude_mm > kLeastPixels * pixel && phases.beat.f_ratio > least_ratio;
  if (must && !beats_in_frames && !quality.by_r_waves)
    throw InputError(
        "the run cannot be gated (it names no R waves, and nothing in its frames comes back with a "
        "heartbeat). Leave reconstruction.gating at auto");
  if (!must && !beats_in_frames) return gate;
  const std::vector<int> frames = frames_of_phase(phases.of_frame, options.phase_percent / 100.0,
                                                  options.phase_width_percent / 100.0);
  if (!must && (phases.beats < kLeastBeats || frames.size() < kLeastGated)) {
    gate.warning = fmt::format(
        "the vessels move with the heart, but the run holds {:.1f} beats, {} frames of a phase: it "
        "was not gated, and vessels are blurred",
        phases.beats, frames.size());
    return gate;
  }
  gate.frames = frames;
  quality.is_gated = true;
  return gate;
}

}  // namespace angio::reconstruction::detail
