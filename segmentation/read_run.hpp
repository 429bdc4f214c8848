#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation {

/// The frames of a run on disk.
class RunPictures {
 public:
  RunPictures() = default;
  RunPictures(const RunPictures&) = delete;
  RunPictures& operator=(const RunPictures&) = delete;
  virtual ~RunPictures() = default;
  /// Frames [first, first + count), rescaled as the file says, never inverted; what a round or
  /// polygonal shutter covers takes the nearest open pixel's value.
  /// @return shape [count, rows, columns]
  /// @throws InputError  the pixels are damaged
  [[nodiscard]] std::vector<float> read(int first, int count) const;
  /// The same, put where the caller wants them.
  virtual void read_into(int first, int count, float* pixels) const = 0;
  /// Frames that need not follow each other.
  /// @return shape [frames.size(), rows, columns]
  [[nodiscard]] virtual std::vector<float> read_some(const std::vector<int>& frames) const = 0;
  /// What a round or polygonal shutter covers.
  /// @return shape [rows, columns], 1: covered; empty: nothing is
  [[nodiscard]] virtual std::vector<char> covered() const { return {}; }

 protected:
  [[nodiscard]] virtual std::size_t per_frame() const = 0;  ///< pixels
};

/// A run of projections that turns, so that a volume can be made of it.
struct LoadedRun {
  ProjectionRun run;  ///< its angles settled, one a frame (none of a stack)
  int columns = 0, rows = 0, frame_count = 0;
  /// Where a stack's header has its first pixel on the detector [mm]; none: it does not say it.
  std::optional<std::array<double, 2>> first_pixel_mm;
  std::shared_ptr<const RunPictures> pictures;
  std::shared_ptr<const RunPictures> masks;  ///< frame by frame; null: there is no mask run
  std::string source_description;            ///< "X-Ray Angiographic Image Storage, 200 frames"
  std::vector<std::string> warnings;         ///< what was left out, and doubtful
};

/// Who says where the frames were taken.
enum class RunGeometry {
  by_header,
  given,  ///< in a file of its own: the header need not say it, and a volume file is a stack of
          ///< frames
};

/// The rotational run of an input, if that is what it is: the run that `options.series` names, or,
/// where no series is of a kind that could be a volume, the one of the most pixels. Another run of
/// the same size, number of frames and angles (to a degree) is its mask run, if one of the two
/// names a contrast medium and the other does not.
///
/// @return nothing where the input is something else, which read_volume() reads or refuses
/// @throws InputError  it is a run that says it turns, but cannot be used: why, and what would do
std::optional<LoadedRun> read_run(const std::filesystem::path& path, const ReadOptions& options,
                                  RunGeometry geometry = RunGeometry::by_header,
                                  const Progress& progress = {});

/// Is it one? Reads headers only.
bool is_rotational_run(const std::filesystem::path& path, const ReadOptions& options);

}  // namespace angio::segmentation
