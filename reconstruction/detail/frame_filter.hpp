#pragma once

#include "reconstruction/detail/ramp_filter.hpp"
#include "reconstruction/detail/volume_task.hpp"

namespace angio::reconstruction::detail {

/// Line integrals of some frames, filtered, on their planes.
class FrameFilter {
 public:
  explicit FrameFilter(const VolumeTask& task);

  FilteredFrames filter(int first, int count);
  [[nodiscard]] double truncated_percent() const {
    return rows_ == 0 ? 0.0 : 100.0 * double(truncated_) / double(rows_);
  }

 private:
  void filter_rows(std::vector<float>& plane, std::size_t frame, const PlaneFrame& place,
                   std::size_t& truncated) const;

  const VolumeTask& task_;
  RampFilter ramp_;
  std::size_t rows_ = 0, truncated_ = 0;
};

}  // namespace angio::reconstruction::detail
