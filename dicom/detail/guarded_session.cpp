#include "dicom/detail/guarded_session.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmnet/dcmtrans.h>
#include <dcmtk/dcmnet/dul.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "dicom/detail/objects.hpp"

namespace angio::dicom::detail {
namespace {

enum class Word : int { beat, failed, done };

constexpr auto kBeat = std::chrono::milliseconds(200);
constexpr double kSilentSeconds = 30.0;  ///< a heartbeat that long late: the child is stuck
constexpr std::size_t kMemoryBytes = std::size_t(4) << 30;
constexpr int kCpuSeconds = 3600;

/// Beats until it is destroyed.
class Heart {
 public:
  explicit Heart(ChildOutput& output)
      : thread_([this, &output] {
          while (!stopped_) {
            output.put(Word::beat);
            output.put(fraction_.load());
            output.flush();
            std::this_thread::sleep_for(kBeat);
          }
        }) {}
  ~Heart() {
    stopped_ = true;
    thread_.join();
  }
  Heart(const Heart&) = delete;
  Heart& operator=(const Heart&) = delete;
  void set(double fraction) { fraction_ = fraction; }

 private:
  std::atomic<bool> stopped_{false};
  std::atomic<double> fraction_{0.0};
  std::thread thread_;
};

struct Failure {
  int exit_code = 0;
  std::string message;
};

void set_timeouts(double timeout_s) {
  const Sint32 seconds = Sint32(timeout_s);
  dcmConnectionTimeout.set(seconds);
  dcmSocketSendTimeout.set(seconds);
  dcmSocketReceiveTimeout.set(seconds);
}

void work_in_child(ChildOutput& output, double timeout_s,
                   const std::function<std::vector<std::int64_t>(const TellFraction&)>& work) {
  silence_log();
  umask(0077);
  set_timeouts(timeout_s);
  std::vector<std::int64_t> result;
  Failure failure;
  {
    Heart heart(output);
    try {
      result = work([&](double fraction) { heart.set(fraction); });
    } catch (const Error& error) {
      failure = {int(error.exit_code()), error.what()};
    }
  }
  output.put(failure.message.empty() ? Word::done : Word::failed);
  if (failure.message.empty()) {
    output.put(result);
  } else {
    output.put(failure.exit_code);
    output.put(failure.message);
  }
  output.flush();
}

}  // namespace

std::vector<std::int64_t> run_session(
    const ArchiveAddress& address, const std::string& step, const Progress& progress,
    const std::function<std::vector<std::int64_t>(const TellFraction&)>& work) {
  std::optional<std::vector<std::int64_t>> result;
  Failure failure;
  ChildLimits limits{kMemoryBytes, kCpuSeconds, kSilentSeconds};
  limits.confinement = Confinement::none;  // it speaks with a network, and writes what comes
  const ChildResult end = run_guarded(
      limits, [&](ChildOutput& output) { work_in_child(output, address.timeout_s, work); },
      [&](ChildInput& input) {
        for (;;) {
          Word word{};
          input.get(word);
          if (word == Word::beat) {
            double fraction = 0.0;
            input.get(fraction);
            progress.report(fraction, step);
          } else if (word == Word::failed) {
            input.get(failure.exit_code);
            input.get(failure.message);
            return;
          } else {
            input.get(result.emplace());
            return;
          }
        }
      });
  if (!failure.message.empty()) throw Error(ExitCode(failure.exit_code), failure.message);
  if (end.end != ChildEnd::done || !result)
    throw IoError("speaking with " + address.ae_title +
                  " broke down (what it sent is damaged, or "
                  "memory is short). Try again");
  return *result;
}

}  // namespace angio::dicom::detail
