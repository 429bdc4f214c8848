#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

#include "segmentation/detail/dicom_parse.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr std::size_t kMaxValueCount = std::size_t(1) << 16;
constexpr double kMsPerSecond = 1000.0;
constexpr double kMsPerDay = 86400.0 * kMsPerSecond;

bool ascends(const std::vector<double>& times) {
  return std::adjacent_find(times.begin(), times.end(),
                            [](double a, double b) { return !(a < b); }) == times.end();
}

/// The time of day of a DICOM date and time, YYYYMMDDHHMMSS.FFFFFF [ms].
std::optional<double> ms_of_day(const std::string& date_time) {
  constexpr std::size_t kTime = 8, kLeast = kTime + 6;
  if (date_time.size() < kLeast ||
      !std::all_of(date_time.begin(), date_time.begin() + kLeast,
                   [](unsigned char c) { return c >= '0' && c <= '9'; }))
    return {};
  const double hours = std::stoi(date_time.substr(kTime, 2)),
               minutes = std::stoi(date_time.substr(kTime + 2, 2)),
               seconds = std::strtod(date_time.c_str() + kTime + 4, nullptr);
  return ((hours * 60.0 + minutes) * 60.0 + seconds) * kMsPerSecond;
}

/// What each frame's functional groups say of its time.
struct FrameClock {
  std::vector<double> times_ms;
  std::vector<double> delays_ms;  ///< since the R wave before it
};

FrameClock clock_of_groups(DcmDataset& dataset) {
  FrameClock clock;
  DcmSequenceOfItems* per_frame = nullptr;
  dataset.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, per_frame);
  DcmObject* object = nullptr;
  while (per_frame && (object = per_frame->nextInContainer(object)) != nullptr) {
    auto* groups = dynamic_cast<DcmItem*>(object);
    if (!groups) return {};
    if (DcmItem* content = first_item(*groups, DCM_FrameContentSequence))
      for (const DcmTagKey& tag : {DCM_FrameReferenceDateTime, DCM_FrameAcquisitionDateTime})
        if (const auto time = ms_of_day(text(*content, tag))) {
          clock.times_ms.push_back(*time);
          break;
        }
    if (DcmItem* heart = first_item(*groups, DCM_CardiacSynchronizationSequence))
      for (const DcmTagKey& tag :
           {DCM_ActualCardiacTriggerDelayTime, DCM_NominalCardiacTriggerDelayTime})
        if (const auto delay = number(*heart, tag)) {
          clock.delays_ms.push_back(*delay);
          break;
        }
  }
  for (std::size_t f = 1; f < clock.times_ms.size(); ++f)  // past midnight
    if (clock.times_ms[f] < clock.times_ms[f - 1] - 0.5 * kMsPerDay) clock.times_ms[f] += kMsPerDay;
  for (std::size_t f = clock.times_ms.size(); f-- > 0;) clock.times_ms[f] -= clock.times_ms[0];
  return clock;
}

/// One R wave for the frames that say the same of it, to half of the time between frames.
std::vector<double> beats_of_delays(const std::vector<double>& times,
                                    const std::vector<double>& delays) {
  if (times.size() < 2 || delays.size() != times.size()) return {};
  const double same = 0.5 * times.back() / double(times.size() - 1);
  std::vector<double> beats;
  for (std::size_t f = 0; f < times.size(); ++f)
    if (const double beat = times[f] - delays[f]; beats.empty() || beat > beats.back() + same)
      beats.push_back(beat);
  return beats;
}

std::vector<double> beats_of_pointer(DcmDataset& dataset, const std::vector<double>& times,
                                     ProjectionRun& run) {
  std::vector<double> beats;
  Uint16 frame = 0;
  bool fits = true;
  for (unsigned long place = 0; dataset.findAndGetUint16(DCM_RWavePointer, frame, place).good() &&
                                beats.size() < kMaxValueCount;
       ++place)
    if (frame >= 1 && frame <= times.size())
      beats.push_back(times[std::size_t(frame) - 1]);
    else
      fits = false;
  if (beats.empty() && fits) return {};
  if (fits && ascends(beats)) return beats;
  run.notes.push_back(times.empty()
                          ? "R waves: they name frames whose times are not stated; left out"
                          : "R waves: they do not name frames of the run in their order; left out");
  return {};
}

/// The times that the steps between frames add up to. The first step is 0: before it is nothing.
std::vector<double> added_up(std::vector<double> steps) {
  double time = 0.0;
  for (std::size_t f = 0; f < steps.size(); ++f) steps[f] = f == 0 ? 0.0 : time += steps[f];
  return steps;
}

}  // namespace

std::vector<double> decimal_numbers(DcmItem& item, const DcmTagKey& tag) {
  DcmElement* element = nullptr;
  item.findAndGetElement(tag, element);
  auto* decimals = dynamic_cast<DcmDecimalString*>(element);
  OFVector<Float64> values;
  if (!decimals || decimals->getFloat64Vector(values).bad() || values.size() > kMaxValueCount ||
      !std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }))
    return {};
  return {values.begin(), values.end()};
}

void parse_run_times(DcmDataset& dataset, int frame_count, ProjectionRun& run) {
  const std::size_t count = std::size_t(std::max(frame_count, 0));
  const std::vector<double> steps = decimal_numbers(dataset, DCM_FrameTimeVector);
  const auto rate = number(dataset, DCM_CineRate);
  double sum = 0.0;
  for (const double step : steps) sum += step;
  if (const auto time = number(dataset, DCM_FrameTime))
    run.frame_time_ms = time;
  else if (steps.size() > 1)
    run.frame_time_ms = sum / double(steps.size() - 1);
  else if (rate && *rate > 0.0)
    run.frame_time_ms = kMsPerSecond / *rate;

  const FrameClock clock = clock_of_groups(dataset);
  if (clock.times_ms.size() == count && count > 1 && ascends(clock.times_ms)) {
    run.frame_times_ms = clock.times_ms;
  } else if (steps.size() == count && count > 1) {
    run.frame_times_ms = added_up(steps);
  } else if (run.frame_time_ms && *run.frame_time_ms > 0.0) {
    for (std::size_t f = 0; f < count; ++f)
      run.frame_times_ms.push_back(double(f) * *run.frame_time_ms);
  }
  if (!ascends(run.frame_times_ms)) {
    run.notes.emplace_back("frame times: they do not ascend; left out");
    run.frame_times_ms.clear();
  }
  if (!run.frame_time_ms && run.frame_times_ms.size() > 1)
    run.frame_time_ms = run.frame_times_ms.back() / double(count - 1);
  run.r_wave_times_ms = beats_of_pointer(dataset, run.frame_times_ms, run);
  if (run.r_wave_times_ms.empty())
    run.r_wave_times_ms = beats_of_delays(run.frame_times_ms, clock.delays_ms);
}

}  // namespace angio::segmentation::detail
