#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"
#include "segmentation/detail/dicom_header.hpp"
#include "segmentation/detail/stack_geometry.hpp"

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
  std::vector<SliceReference> members;  ///< the frames of the headers that belong to it
  std::vector<SliceReference> slices;   ///< those of the volume, in the order of growing k
  StackGeometry stack;                  ///< meaningful if usable
  bool is_volume_kind = false;          ///< of a kind that could be a volume, even if damaged
  bool usable = false;
  std::string verdict;                ///< "regular grid", or why not and what to do
  std::vector<std::string> warnings;  ///< about a usable series

  [[nodiscard]] std::size_t pixel_count() const;
  [[nodiscard]] bool lossy() const;
  [[nodiscard]] const DicomFrame& frame(const SliceReference& slice) const {
    return headers[std::size_t(slice.header)].frames[std::size_t(slice.frame)];
  }
};

struct FoundSeries {
  std::vector<DicomSeries> all;       ///< by falling pixel count
  std::vector<std::string> warnings;  ///< files that are damaged and of no known series, or locked
};

/// Every series under a folder, or in one file, an archive or a DICOMDIR.
FoundSeries find_series(const std::filesystem::path& path, const ReadOptions& options,
                        const Progress& progress = {});

/// The one that is read: the one that is asked for, or by rule the largest of a kind that could be
/// a volume, even if it is then refused; a smaller one must not stand in for it unasked.
/// @throws InputError if there is no such series, or it cannot be used
std::size_t choose_series(const std::vector<DicomSeries>& all, const ReadOptions& options);

/// A series in words, for messages.
std::string describe(const DicomSeries& series, std::size_t index);

}  // namespace angio::segmentation::detail
