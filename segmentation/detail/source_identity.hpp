#pragma once

#include <string>

#include "dicom/identity.hpp"
#include "segmentation/detail/dicom_source.hpp"

namespace angio::segmentation::detail {

/// Whose scan it is, and of which study, as its header says; texts become UTF-8. To be used in a
/// guarded child only.
/// @param seed  of the UIDs that stand in for those that anonymisation took away
/// @throws IoError if the header cannot be read again
dicom::StudyIdentity source_identity(const DicomSource& source, const std::string& seed);

/// "XA", "CT", ... Likewise.
std::string source_modality(const DicomSource& source);

/// An identity without the patient, the dates and the descriptions: the study's UIDs alone.
dicom::StudyIdentity without_patient(const dicom::StudyIdentity& identity);

}  // namespace angio::segmentation::detail
