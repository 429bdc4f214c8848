#include "simulation/guard.hpp"

#include <omp.h>

#include <algorithm>
#include <exception>
#include <future>
#include <mutex>

#include "core/error.hpp"
#include "simulation/pbd/policy.hpp"

namespace angio::simulation {
namespace {

constexpr double kLargestTolerance = 0.1;  // that SimulationOptions allows

/// Numbers that look random: SplitMix64 (Steele, Lea, Flood 2014, OOPSLA,
/// doi:10.1145/2660193.2660195).
class Moves {
 public:
  Moves(std::uint64_t seed, double most) : state_(seed), most_(most) {}
  Vec3 next() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }

 private:
  double number() {  // in [-most, most)
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return most_ * (double(z >> 11) * 0x1p-52 - 1.0);
  }
  std::uint64_t state_;
  double most_;
};

/// The progress of two runs as one, from two threads; it stops both.
class SharedProgress {
 public:
  explicit SharedProgress(const Progress& whole) : whole_(whole) {}

  /// @param run  0 or 1
  [[nodiscard]] Progress of(int run) {
    return Progress([this, run](double fraction, std::string_view step) {
      const std::lock_guard lock(mutex_);
      if (is_stopped_) throw Interrupted();
      fraction_[run] = fraction;
      try {
        whole_.report(0.5 * (fraction_[0] + fraction_[1]), step);
      } catch (...) {
        is_stopped_ = true;
        stopped_by_ = std::current_exception();
        throw;
      }
    });
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
  }
  /// Throws what the sink has thrown.
  void throw_if_stopped_outside() {
    const std::lock_guard lock(mutex_);
    if (stopped_by_) std::rethrow_exception(stopped_by_);
  }

 private:
  const Progress& whole_;
  std::mutex mutex_;
  double fraction_[2] = {0.0, 0.0};
  bool is_stopped_ = false;
  std::exception_ptr stopped_by_;
};

/// Gives the caller's parallel loops fewer threads for a while.
class FewerThreads {
 public:
  explicit FewerThreads(int count) : before_(omp_get_max_threads()) { omp_set_num_threads(count); }
  ~FewerThreads() { omp_set_num_threads(before_); }
  FewerThreads(const FewerThreads&) = delete;
  FewerThreads& operator=(const FewerThreads&) = delete;

 private:
  int before_;
};

struct Second {
  std::optional<SimulationSummary> summary;
  std::string failure;
};

/// A second run that fails, in whatever way, is an answer.
Second run_second(const SimulationModel& model, const SimulationOptions& options,
                  const FrameSink& on_frame, const Progress& progress) {
  Second second;
  try {
    second.summary = simulate(model, options, on_frame, progress);
    second.failure = second.summary->failure;
  } catch (const Interrupted&) {
    second.failure = "it was stopped";
  } catch (const std::exception& error) {
    second.failure = error.what();
  }
  return second;
}

SimulationModel second_model(const SimulationModel& model, const SimulationOptions& options,
                             const Disturbance& by) {
  SimulationModel second = disturbed(model, by);
  // Nothing that is compared is of the air, unless the paper's contact is its tets.
  if (!detail::pbd_policy(options).contact) second.air.clear();
  return second;
}

/// Both runs begin with one pre-stress, which all threads find. What two of them would differ by is
/// how near each comes to balance (WallSolution::displacement_mm), which is no answer of the
/// balloon's.
SimulationModel with_prestress(SimulationModel model, const SimulationOptions& options) {
  if (!model.layered_wall.vertices.empty() && model.wall_seen == nullptr)
    model.wall_seen = std::make_shared<const WallSolution>(
        prestress_wall(model.layered_wall, options.layered_wall));
  return model;
}

bool takes_a_gpu(Backend backend) {
  return backend == Backend::cuda ||
         (backend == Backend::automatic && !cuda_support().device.empty());
}

}  // namespace

SimulationModel disturbed(SimulationModel model, const Disturbance& by) {
  Moves moves(by.seed, by.move_mm);
  for (std::size_t v = 0; v < model.balloon.vertices.size(); ++v) {
    const Vec3 move = moves.next();
    if (model.balloon_fixed[v] != 0) continue;
    model.balloon.vertices[v] += move;
    model.balloon_rest[v] += move;
  }
  const std::size_t columns = model.wall.vertices.size();
  for (std::size_t v = 0; v < columns; ++v) {
    const Vec3 move = moves.next();
    if (model.wall_fixed[v] != 0) continue;
    model.wall.vertices[v] += move;
    for (std::size_t copy = v; copy < model.layered_wall.vertices.size(); copy += columns)
      model.layered_wall.vertices[copy] += move;
  }
  return model;
}

GuardedSummary simulate_guarded(const SimulationModel& given, const SimulationOptions& options,
                                const Disturbance& by, const FrameSink& on_frame,
                                const FrameSink& on_second_frame, const Progress& progress) {
  const SimulationModel model = with_prestress(given, options);
  const SimulationModel other_model = second_model(model, options, by);
  SimulationOptions other = options;
  other.tolerance = std::min(by.tolerance_factor * options.tolerance, kLargestTolerance);
  SharedProgress shared(progress);
  const Progress first_progress = shared.of(0), second_progress = shared.of(1);
  const int threads = omp_get_max_threads();
  const bool at_once = threads > 1 && !takes_a_gpu(options.backend);
  GuardedSummary result;
  Second second;
  if (at_once) {
    auto beside = std::async(std::launch::async, [&] {
      omp_set_num_threads(threads / 2);
      return run_second(other_model, other, on_second_frame, second_progress);
    });
    try {
      const FewerThreads fewer(threads - threads / 2);
      // The second run, which follows no air and writes nothing, ends earlier: its thread is free.
      result.first = simulate(model, options, on_frame, first_progress, true);
    } catch (...) {
      shared.stop();
      shared.throw_if_stopped_outside();
      throw;  // once the second has ended, too
    }
    if (!result.first.failure.empty()) shared.stop();
    second = beside.get();
  } else {
    result.first = simulate(model, options, on_frame, first_progress);
    if (!result.first.failure.empty()) return result;
    other.backend = result.first.backend == "cuda" ? Backend::cuda : Backend::cpu;
    second = run_second(other_model, other, on_second_frame, second_progress);
  }
  if (!result.first.failure.empty()) return result;
  shared.throw_if_stopped_outside();
  result.second = std::move(second.summary);
  result.second_failure = std::move(second.failure);
  return result;
}

}  // namespace angio::simulation
