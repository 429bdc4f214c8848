#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include <memory>
#include <vector>

#include "segmentation/detail/dicom_source.hpp"
#include "segmentation/detail/zip_archive.hpp"

namespace angio::segmentation::detail {

/// Opens DICOM files with DCMTK. To be used in a guarded child only: DCMTK's parser follows
/// whatever a file says.
class DicomLoader {
 public:
  /// @param read_limit_bytes  elements longer than this stay on disk, where there is one
  /// @return whether the whole file could be parsed; what was read until then is in `file`
  /// @throws InputError if an archive cannot be unpacked
  OFCondition load(const DicomSource& source, Uint32 read_limit_bytes, DcmFileFormat& file);

  /// Cheap test before the parser sees a file: a preamble, or a first group of 0002 or 0008.
  bool may_be_dicom(const DicomSource& source);

 private:
  const ZipArchive& archive(const std::filesystem::path& path);

  std::filesystem::path archive_path_;
  std::unique_ptr<ZipArchive> archive_;
  std::vector<char> bytes_;  ///< of the packed file in use
};

/// DCMTK's log could print attribute values, hence identity.
void silence_dcmtk();

/// What DCMTK reads at its first use (its dictionary, a file) is read here, before a guarded child
/// that has it needs it.
void prepare_dcmtk();

}  // namespace angio::segmentation::detail
