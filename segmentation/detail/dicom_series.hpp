#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/dicom_header.hpp"

namespace angio::segmentation::detail {

/// One frame of one file.
struct SliceReference {
  int header = 0;  ///< index into DicomSeries::headers
  int frame = 0;
};

/// The objects that could form one volume, and whether they do.
struct DicomSeries {
  std::string key;  ///< short hash of the series UID; -2, -3, ... for further stacks of a series
  std::vector<DicomHeader> headers;
  std::vector<SliceReference> slices;  ///< in the order of growing k
  VolumeGeometry geometry;             ///< LPS, right-handed; meaningful if usable
  bool is_volume_kind = false;         ///< of a kind that could be a volume, even if damaged
  bool usable = false;
  std::string verdict;                ///< "regular grid", or why not and what to do
  std::vector<std::string> warnings;  ///< about a usable series

  [[nodiscard]] std::size_t pixel_count() const;
};

/// Where the slices of a stack lie, or why they form no regular grid.
struct StackGeometry {
  VolumeGeometry geometry;
  std::vector<int> order;             ///< the given frames in the order of growing k
  std::string problem;                ///< empty if the grid is regular
  std::vector<std::string> warnings;  ///< e.g. an unevenness that was tolerated
};

/// The grid of a stack of parallel slices, told from positions and orientations alone.
///
///     n = i x j,   z_k = p_k . n ascending,   spacing_k = (z_last - z_0) / (count - 1)
///
/// A slice may lie off its place by 1 % of the spacing; up to 5 % is told in a warning. Refused are
/// one slice alone, different orientations, duplicate positions, missing slices, uneven spacing,
/// and a path of slices not along n (gantry tilt).
/// Source: DICOM PS3.3 C.7.6.2.1.1 (Eq. C.7.6.2.1-1).
StackGeometry stack_geometry(const std::vector<DicomFrame>& frames, int columns, int rows);

/// Every series under a folder, or in one file, by falling pixel count.
///
/// @param warnings  gets a line per file that is damaged and of no known series
std::vector<DicomSeries> find_series(const std::filesystem::path& path,
                                     std::vector<std::string>& warnings,
                                     const Progress& progress = {});

}  // namespace angio::segmentation::detail
