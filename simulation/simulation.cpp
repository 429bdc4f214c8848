#include "simulation/simulation.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/beside.hpp"
#include "core/error.hpp"
#include "core/in_order.hpp"
#include "core/units.hpp"
#include "simulation/backends/step_solver.hpp"
#include "simulation/bodies/air.hpp"
#include "simulation/bodies/drawn_wire.hpp"
#include "simulation/pbd/policy.hpp"
#include "simulation/run/frame_state.hpp"
#include "simulation/run/measure.hpp"
#include "simulation/run/schedule.hpp"
#include "simulation/run/success.hpp"
#include "simulation/step/make_views.hpp"

namespace angio::simulation {
namespace {

using namespace detail;

constexpr double kWarnResidual = 0.05;
constexpr std::size_t kMostWaiting = 8;  // frames behind the solver, for each thread
constexpr int kMostAtOnce = 16;          // that are completed: each holds its state

void summarize(const SimulationFrame& frame, bool is_air_whole, SimulationSummary& summary) {
  ++summary.frame_count;
  summary.simulated_s = frame.time_s;
  if (frame.pressure_atm > summary.peak_pressure_atm || frame.frame == 0) {
    summary.peak_pressure_atm = std::max(0.0, frame.pressure_atm);
    summary.peak_diameter_mm = frame.balloon_diameter_mm;
    summary.peak_frame = frame.frame;
  }
  summary.max_penetration_mm =
      std::max(summary.max_penetration_mm, frame.contact.max_penetration_mm);
  summary.inverted_air_tets = std::max(summary.inverted_air_tets, frame.air.inverted_count);
  summary.flip_count += frame.air.flip_count;
  summary.air_rebuild_count += frame.air.rebuild_count;
  summary.worst_residual = std::max(summary.worst_residual, frame.residual);
  summary.mean_sweeps += frame.sweep_count;
  if (is_air_whole)
    summary.air_left_out_percent =
        std::max(summary.air_left_out_percent, 100.0 * frame.air.left_out_share);
  else
    ++summary.frames_without_air;
}

/// Of the model and the treatment first, then of how well the solver has done.
void add_warnings(const SimulationOptions& options, int slow_frames, SimulationSummary& summary) {
  char text[300];
  for (std::string& warning : pbd_warnings(options)) summary.warnings.push_back(std::move(warning));
  const double asked = options.inflation.peak_pressure_atm;
  const double rated = options.inflation.rated_burst_atm;
  if (rated > 0.0 && summary.peak_pressure_atm > rated) {
    std::snprintf(text, sizeof text,
                  "the peak pressure, %.2f atm, is above the balloon's rated burst pressure, %.2f "
                  "atm",
                  summary.peak_pressure_atm, rated);
    summary.warnings.emplace_back(text);
  }
  if (summary.peak_pressure_atm < 0.99 * asked) {
    std::snprintf(text, sizeof text,
                  "the balloon reached %.2f atm of the %.2f atm asked for: its wall of %.3f mm %s "
                  "carries no more, or it was still filling; try a stiffer balloon or a longer "
                  "inflation (inflation.inflate_s)",
                  summary.peak_pressure_atm, asked, options.balloon.wall_mm,
                  options.balloon.name.c_str());
    summary.warnings.emplace_back(text);
  }
  if (summary.max_penetration_mm > 0.0) {
    std::snprintf(text, sizeof text, "balloon and wall cross by up to %.4f mm",
                  summary.max_penetration_mm);
    summary.warnings.emplace_back(text);
  }
  if (slow_frames > 0) {
    std::snprintf(
        text, sizeof text,
        "the forces on balloon and wall are off balance by up to %.1f %%, and by more than "
        "%.0f %% in %d of %d frames; the solver needs shorter time steps or more sweeps "
        "to balance them (simulation.frame_s, simulation.sweeps)",
        100.0 * summary.worst_residual, 100.0 * kWarnResidual, slow_frames, summary.frame_count);
    summary.warnings.emplace_back(text);
  }
}

void add_times(const StepTimes& step, TimeSplit& sum) {
  sum.pairs += step.search + step.refresh;
  sum.balloon += step.balloon;
  sum.wall += step.wall;
  sum.rest += step.rest;
}

// Adds the time of a piece of work to `sum` [s].
template <class Work>
auto timed(double& sum, const Work& work) {
  struct Stopwatch {
    double& sum;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    ~Stopwatch() {
      sum += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
  } stopwatch{sum};
  return work();
}

// Ends a run that is no result any more.
struct RunHasFailed {};

// A run on one backend, from the start.
class Run {
 public:
  Run(const SimulationModel& model, const SimulationOptions& options,
      const std::function<void(const SimulationFrame&)>& on_frame, const Progress& progress,
      bool has_spare_thread)
      : model_(model),
        options_(options),
        on_frame_(on_frame),
        progress_(progress),
        has_spare_thread_(has_spare_thread),
        shared_scene_(std::make_shared<const Scene>(make_scene(model, options))) {
    if (max_penetration(scene_, scene_.start) > 0.0)
      throw InputError(
          "the balloon crosses the vessel wall before it is inflated (contact cannot part them). "
          "Try a smaller balloon.start_diameter_mm");
  }

  SimulationSummary on(Backend backend) {
    const auto solver = make_solver(backend);
    SimulationSummary summary = begun_summary(backend, *solver);
    const double outside = outside_pressure(options_),
                 volume = balloon_volume(scene_, scene_.start);
    const Control control = make_control(scene_, options_, expected_volume(model_, scene_, volume));
    const Inflator& inflator = control.inflator;
    slow_frames_ = 0;
    air_mesh::AdaptiveAir air;
    std::optional<DrawnWire> wire;
    SuccessWatch watch(scene_, model_, options_);
    const auto follow = [&](BegunFrame& begun) {
      timed(summary.time.air, [&] { air.follow(begun.state->x); });
      begun.output.air = air.take_report();
      begun.is_air_whole = scene_.air.empty() || air.is_whole();
    };
    // Frames queue up behind the solver: for their air, to be completed (several at once, each to
    // be judged in its turn), for the wire to be drawn, and to be handed over. What a thread uses
    // is declared before it, so that it ends first.
    std::atomic<bool> has_failed = false;
    Beside delivery(has_spare_thread_, kMostWaiting);
    Beside drawing(has_spare_thread_, kMostWaiting);
    drawing.run([&] { wire.emplace(model_, options_.guidewire); });
    const auto judge = [&](BegunFrame& begun) {
      if (has_failed) return;
      watch.judge(begun.look, begun.output);
      has_failed = !watch.failure().empty();
      count(begun, summary);
      drawing.run([&, output = std::move(begun.output)]() mutable {
        if (output.guidewire.empty())
          timed(summary.time.wire, [&] { output.guidewire = wire->follow(output.balloon); });
        delivery.run([&, output = std::move(output)] { deliver(output, summary); });
      });
    };
    InOrder in_order;
    Beside completion(has_spare_thread_, kMostWaiting,
                      std::min(omp_get_max_threads(), kMostAtOnce));
    const auto hand_over = [&](BegunFrame&& begun) {
      completion.run([&, begun = std::make_shared<BegunFrame>(std::move(begun))] {
        if (has_failed) return;
        timed(begun->outputs_s, [&] {
          add_state(model_, shared_scene_, begun->state, outside, begun->output);
          begun->look = watch.look(*begun->state);
        });
        in_order.run(begun->output.frame, [&judge, begun] { judge(*begun); });
      });
    };
    Beside following(has_spare_thread_, kMostWaiting);
    following.run([&] { air = make_air(model_, scene_); });
    // The paper's contact is projected on each frame's tets: the solver waits for them.
    const bool needs_air = pbd_policy(options_).contact;
    if (needs_air) following.wait();
    double whole = 0.0, taken = 0.0;
    const auto take = [&](int frame, State&& state) {
      if (has_failed) throw RunHasFailed();
      add_times(state.report.times, summary.time);
      BegunFrame begun;
      begun.output = begun_frame(frame, inflator);
      begun.state = std::make_shared<const State>(std::move(state));
      if (needs_air) {
        follow(begun);
        solver->set_air(air.tets());
      }
      timed(summary.time.waiting, [&] {
        if (needs_air) return hand_over(std::move(begun));
        following.run([&, begun = std::move(begun)]() mutable {
          follow(begun);
          hand_over(std::move(begun));
        });
      });
      progress_.report(double(frame + 1) / inflator.frame_count(), name(inflator.phase(frame)));
    };
    const auto wait_for_all = [&] {
      for (Beside* stage : {&following, &completion, &drawing, &delivery}) stage->wait();
    };
    timed(whole, [&] {
      try {
        solver->run(control, [&](int frame, State&& state) {
          timed(taken, [&] { take(frame, std::move(state)); });
        });
      } catch (const RunHasFailed&) {  // what is to come would be none either
      } catch (const Error& error) {
        // Another backend goes on behind the frames that this one has left.
        if (error.exit_code() == ExitCode::unavailable) wait_for_all();
        throw;
      }
    });
    wait_for_all();
    summary.time.solver = whole - taken;
    summary.failure = watch.failure();
    summary.worst_pressure_ratio = watch.worst_pressure_ratio();
    finish(slow_frames_, summary);
    return summary;
  }

 private:
  /// A frame as the solver leaves it.
  struct BegunFrame {
    SimulationFrame output;
    std::shared_ptr<const State> state;
    bool is_air_whole = true;
    SuccessWatch::Look look;
    double outputs_s = 0.0;
  };

  void count(const BegunFrame& begun, SimulationSummary& summary) {
    summary.time.outputs += begun.outputs_s;
    slow_frames_ += begun.output.residual > kWarnResidual ? 1 : 0;
    summary.open_frames += begun.output.sweep_count >= most_sweeps_ ? 1 : 0;
    summarize(begun.output, begun.is_air_whole, summary);
  }
  void deliver(const SimulationFrame& output, SimulationSummary& summary) {
    if (output.frame < delivered_) return;  // by a backend that failed later
    ++delivered_;
    if (on_frame_) timed(summary.time.files, [&] { on_frame_(output); });
  }
  [[nodiscard]] std::unique_ptr<StepSolver> make_solver(Backend backend) const {
    return backend == Backend::cuda ? make_cuda_solver(scene_, options_)
                                    : make_cpu_solver(scene_, options_);
  }
  [[nodiscard]] static SimulationSummary begun_summary(Backend backend, const StepSolver& solver) {
    SimulationSummary summary;
    summary.backend = backend == Backend::cuda ? "cuda" : "cpu";
    summary.device = solver.device();
    return summary;
  }
  [[nodiscard]] SimulationFrame begun_frame(int frame, const Inflator& inflator) const {
    SimulationFrame output;
    output.frame = frame;
    output.time_s = frame * options_.frame_s;
    output.phase = inflator.phase(frame);
    return output;
  }
  void finish(int slow_frames, SimulationSummary& summary) const {
    summary.mean_sweeps /= std::max(1, summary.frame_count - 1);
    summary.warnings = scene_.wall.solid.warnings;
    if (summary.failure.empty()) add_warnings(options_, slow_frames, summary);
  }

  const SimulationModel& model_;
  const SimulationOptions& options_;
  const std::function<void(const SimulationFrame&)>& on_frame_;
  const Progress& progress_;
  bool has_spare_thread_;
  std::shared_ptr<const Scene> shared_scene_;  ///< with the frames' stresses
  const Scene& scene_ = *shared_scene_;
  int most_sweeps_ = make_rules(scene_, options_).most_sweeps;
  int slow_frames_ = 0;  ///< frames that ended off balance, of the run under way
  int delivered_ = 0;
};

// The GPU where there is one that works, else the CPU: with a notice if a GPU has failed.
SimulationSummary run_anywhere(Run& run) {
  if (!has_cuda_device()) return run.on(Backend::cpu);
  try {
    return run.on(Backend::cuda);
  } catch (const Error& error) {
    if (error.exit_code() != ExitCode::unavailable) throw;
    SimulationSummary summary = run.on(Backend::cpu);
    summary.warnings.insert(summary.warnings.begin(),
                            "the CPU was used instead: " + std::string(error.what()));
    return summary;
  }
}

}  // namespace

const char* name(Phase phase) {
  switch (phase) {
    case Phase::insert:
      return "insert";
    case Phase::inflate:
      return "inflate";
    case Phase::hold:
      return "hold";
    case Phase::deflate:
      return "deflate";
    case Phase::rest:
      return "rest";
  }
  return "";
}

CudaSupport cuda_support() {
#ifdef ANGIO_HAS_CUDA
  return {true, cuda_device_name()};
#else
  return {};
#endif
}

SimulationSummary simulate(const SimulationModel& model, const SimulationOptions& options,
                           const std::function<void(const SimulationFrame&)>& on_frame,
                           const Progress& progress, bool has_spare_thread) {
  options.validate();
  const auto begin = std::chrono::steady_clock::now();
  Run run(model, options, on_frame, progress, has_spare_thread);
  SimulationSummary summary =
      options.backend == Backend::automatic ? run_anywhere(run) : run.on(options.backend);
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return summary;
}

}  // namespace angio::simulation
