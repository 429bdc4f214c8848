#include "segmentation/detail/source_identity.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "segmentation/detail/dicom_parse.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr Uint32 kReadLimitBytes = 4096;

/// What no character set explains becomes a question mark.
std::string plain(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) > 0x7e; }, '?');
  return text;
}

DcmDataset& load_header(const DicomSource& source, DcmFileFormat& file) {
  DicomLoader loader;
  if (loader.load(source, kReadLimitBytes, file).bad())
    throw IoError("the scan cannot be read again (it was moved or changed). Run from it again");
  return *file.getDataset();
}

}  // namespace

dicom::StudyIdentity source_identity(const DicomSource& source, const std::string& seed) {
  DcmFileFormat file;
  DcmDataset& dataset = load_header(source, file);
  const bool is_utf8 = dataset.convertToUTF8().good();
  const auto words = [&](const DcmTagKey& tag) {
    return is_utf8 ? text(dataset, tag) : plain(text(dataset, tag));
  };
  const auto uid_or = [&](const DcmTagKey& tag, const char* what) {
    const std::string uid = text(dataset, tag);
    return uid.empty() ? dicom::hashed_uid(seed + what) : uid;
  };
  dicom::StudyIdentity identity;
  identity.patient_name = words(DCM_PatientName);
  identity.patient_id = words(DCM_PatientID);
  identity.birth_date = words(DCM_PatientBirthDate);
  identity.sex = words(DCM_PatientSex);
  identity.study_uid = uid_or(DCM_StudyInstanceUID, "study");
  identity.study_id = words(DCM_StudyID);
  identity.study_date = words(DCM_StudyDate);
  identity.study_time = words(DCM_StudyTime);
  identity.study_description = words(DCM_StudyDescription);
  identity.accession_number = words(DCM_AccessionNumber);
  identity.referring_physician = words(DCM_ReferringPhysicianName);
  identity.frame_of_reference_uid = uid_or(DCM_FrameOfReferenceUID, "frame of reference");
  return identity;
}

std::string source_modality(const DicomSource& source) {
  DcmFileFormat file;
  return text(load_header(source, file), DCM_Modality);
}

dicom::StudyIdentity without_patient(const dicom::StudyIdentity& identity) {
  dicom::StudyIdentity bare;
  bare.study_uid = identity.study_uid;
  bare.frame_of_reference_uid = identity.frame_of_reference_uid;
  return bare;
}

}  // namespace angio::segmentation::detail
