#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include <filesystem>
#include <string>

#include "dicom/identity.hpp"

/// What the objects that we write have in common.
namespace angio::dicom::detail {

/// A series that holds one object.
struct SeriesIdentity {
  std::string modality, description;
  std::string seed;  ///< of its UIDs
  int number = 1;
};

/// @throws IoError naming `what`
void check(const OFCondition& condition, const char* what);

/// Puts patient, study, series, equipment and the object's own UID in place of what is there. Dates
/// are the study's: the same input gives the same bytes, and the true day would tell of the
/// patient.
void put_identity(DcmItem& item, const StudyIdentity& study, const SeriesIdentity& series,
                  const std::string& version);

/// @throws IoError
void write_object(const std::filesystem::path& path, DcmDataset& dataset);

/// DCMTK's log could print attribute values, hence identity.
void silence_log();

}  // namespace angio::dicom::detail
