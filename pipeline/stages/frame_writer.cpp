#include "pipeline/stages/frame_writer.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "core/atomic_file.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/stages/layered_wall.hpp"
#include "simulation/balloon_measures.hpp"

namespace angio::pipeline {
namespace {

constexpr std::size_t kMostWaiting = 8;                 // frames
constexpr std::chrono::milliseconds kTablesEvery{300};  // a viewer looks no more often

/// What a row of the time series tells.
simulation::SimulationFrame without_shape(const simulation::SimulationFrame& frame) {
  simulation::SimulationFrame row;
  row.frame = frame.frame;
  row.time_s = frame.time_s;
  row.phase = frame.phase;
  row.pressure_atm = frame.pressure_atm;
  row.balloon_volume_mm3 = frame.balloon_volume_mm3;
  row.balloon_diameter_mm = frame.balloon_diameter_mm;
  row.end_diameters_mm = frame.end_diameters_mm;
  row.contact = frame.contact;
  row.air = frame.air;
  return row;
}

}  // namespace

void PeakAndLast::add(SharedFrame frame) {
  if (peak_ == nullptr || frame->pressure_atm >= peak_->pressure_atm) peak_ = frame;
  last_ = std::move(frame);
}

std::vector<Vec3> balloon_in_lumen(const simulation::SimulationFrame& frame) {
  return frame.contact.count > 0 ? frame.balloon : std::vector<Vec3>();
}

FrameWriter::FrameWriter(std::filesystem::path folder, const simulation::SimulationModel& model,
                         const TreatedLumen& lumen, int write_every)
    : folder_(std::move(folder)),
      model_(model),
      lumen_(lumen),
      follower_(lumen),
      write_every_(write_every),
      measuring_(false, kMostWaiting),
      writing_(false, kMostWaiting, omp_get_max_threads()) {}

void FrameWriter::add(const simulation::SimulationFrame& frame) {
  rows_.push_back(without_shape(frame));
  const SharedFrame shared = share(frame);
  kept_.add(shared);
  if (frame.frame % write_every_ != 0) return;
  measuring_.run([this, shared] {
    mld_[shared->frame] = follower_.measure(shared->wall, balloon_in_lumen(*shared)).mld_mm;
  });
  write(shared);
  if (std::chrono::steady_clock::now() - last_tables_ > kTablesEvery) write_tables();
}

void FrameWriter::finish() {
  for (const SharedFrame& frame : kept_.both()) write(frame);
  measuring_.wait();
  // What metrics.json tells is measured as there.
  for (const SharedFrame& frame : kept_.both())
    mld_[frame->frame] =
        lumen_.measures(lumen_.profile(frame->wall, balloon_in_lumen(*frame))).lesion.mld_mm;
  write_tables();
}

void FrameWriter::write_tables() {
  writing_.wait();
  measuring_.wait();
  std::sort(steps_.begin(), steps_.end(), [](const auto& a, const auto& b) {
    return std::tie(a.time_s, a.part) < std::tie(b.time_s, b.part);
  });
  formats::write_collection(folder_ / "simulation.pvd", steps_);
  std::string table = std::string(kTimeSeriesHeader) + "\n";
  for (const simulation::SimulationFrame& row : rows_)
    if (row.frame <= mld_.rbegin()->first)
      table += time_series_row(row, lumen_mld(row.frame)) + "\n";
  write_text_atomically(folder_ / "timeseries.csv", table);
  last_tables_ = std::chrono::steady_clock::now();
}

void FrameWriter::write(const SharedFrame& frame) {
  if (!written_.insert(frame->frame).second) return;
  writing_.run([this, frame] { write_frame(folder_ / "frames", model_, *frame); });
  const auto add_step = [&](int part, const char* body, const char* extension) {
    steps_.push_back(
        {frame->time_s, part, fmt::format("frames/{}_{:06d}.{}", body, frame->frame, extension)});
  };
  add_step(0, "balloon", "vtp");
  add_step(1, "vessel", "vtp");
  if (!frame->guidewire.empty()) add_step(3, "guidewire", "vtp");
  if (frame->layered_wall.empty()) return;
  add_step(2, "wall", "vtu");
  writing_.run([this, frame, file = folder_ / steps_.back().file] {
    write_wall_frame(file, model_.layered_wall, *frame);
  });
}

double FrameWriter::most_dogboning_percent() const {
  double most = std::numeric_limits<double>::quiet_NaN();
  for (const simulation::SimulationFrame& row : rows_)
    if (row.phase == simulation::Phase::inflate || row.phase == simulation::Phase::hold)
      most = std::fmax(most, simulation::dogboning_percent(row));  // NaN counts for nothing
  return most;
}

double FrameWriter::lumen_mld(int frame) const {
  const auto behind = mld_.lower_bound(frame);
  if (behind->first == frame) return behind->second;
  const auto before = std::prev(behind);
  const double share = double(frame - before->first) / double(behind->first - before->first);
  return (1.0 - share) * before->second + share * behind->second;
}

}  // namespace angio::pipeline
