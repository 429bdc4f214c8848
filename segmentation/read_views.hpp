#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/read_run.hpp"

namespace angio::segmentation {

/// More are hardly of one vessel: which belong together must be said.
inline constexpr int kMostViews = 6;

/// Angiograms of a C-arm that stood still, from several sides: each a run of its own, its angles
/// those of all its frames.
struct LoadedViews {
  std::vector<LoadedRun> views;
  std::vector<int> numbers;           ///< of each, as `angio inspect` lists them
  std::string source_description;     ///< "3 views, X-Ray Angiographic Image Storage"
  std::vector<std::string> warnings;  ///< what was left out, and doubtful
};

/// The views of an input, if that is what it is: runs of X-ray projections that do not turn, where
/// no series is of a kind that could be a volume and no run turns. All that can be used are taken,
/// or those that `options.views` names; of two from the same side (to 10 degrees) the longer one.
///
/// @return nothing where there are no two views, 30 degrees apart or more, and none is asked for
/// @throws InputError  views are asked for, and there are none of that number, or they cannot be
///                     used; there are more than kMostViews, and none is asked for; or their
///                     pictures need more memory than is allowed
std::optional<LoadedViews> read_views(const std::filesystem::path& path, const ReadOptions& options,
                                      const Progress& progress = {});

/// Are there some? Reads headers only.
bool are_views(const std::filesystem::path& path, const ReadOptions& options);

/// A view as `angio inspect` lists it.
struct ViewSummary {
  int number = 0;      ///< 1, 2, ...: for `options.views`
  std::string series;  ///< short hash of the series UID
  double primary_degrees = 0.0, secondary_degrees = 0.0;
  int frame_count = 0;
  std::string problem;  ///< why it cannot be used; empty: it can
};
std::vector<ViewSummary> list_views(const std::filesystem::path& path, const ReadOptions& options);

}  // namespace angio::segmentation
