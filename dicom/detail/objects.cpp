#include "dicom/detail/objects.hpp"

#include <dcmtk/oflog/oflog.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"

namespace angio::dicom::detail {
namespace fs = std::filesystem;
namespace {

constexpr const char* kNoDate = "19000101";  ///< where the standard wants one
constexpr const char* kNoTime = "000000";

void put(DcmItem& item, const DcmTagKey& tag, const std::string& value) {
  check(item.putAndInsertString(tag, value.c_str()), "attribute");
}

}  // namespace

void check(const OFCondition& condition, const char* what) {
  if (condition.bad())
    throw IoError(std::string("cannot make a DICOM object (") + what + ": " + condition.text() +
                  "). Please report it");
}

void put_identity(DcmItem& item, const StudyIdentity& study, const SeriesIdentity& series,
                  const std::string& version) {
  put(item, DCM_SpecificCharacterSet, "ISO_IR 192");
  put(item, DCM_PatientName, study.patient_name);
  put(item, DCM_PatientID, study.patient_id);
  put(item, DCM_PatientBirthDate, study.birth_date);
  put(item, DCM_PatientSex, study.sex);
  put(item, DCM_StudyInstanceUID, study.study_uid);
  put(item, DCM_StudyID, study.study_id);
  put(item, DCM_StudyDate, study.study_date);
  put(item, DCM_StudyTime, study.study_time);
  put(item, DCM_AccessionNumber, study.accession_number);
  put(item, DCM_ReferringPhysicianName, study.referring_physician);
  if (!study.study_description.empty()) put(item, DCM_StudyDescription, study.study_description);
  put(item, DCM_Modality, series.modality);
  put(item, DCM_SeriesDescription, series.description);
  put(item, DCM_SeriesNumber, std::to_string(series.number));
  put(item, DCM_SeriesInstanceUID, hashed_uid(series.seed + "series"));
  put(item, DCM_SOPInstanceUID, hashed_uid(series.seed + "object"));
  put(item, DCM_InstanceNumber, "1");
  put(item, DCM_Manufacturer, "angio");
  put(item, DCM_ManufacturerModelName, "angio");
  put(item, DCM_SoftwareVersions, version);
  put(item, DCM_ContentDate, study.study_date.empty() ? kNoDate : study.study_date);
  put(item, DCM_ContentTime, study.study_time.empty() ? kNoTime : study.study_time);
  for (const DcmTagKey& moment : {DCM_InstanceCreationDate, DCM_InstanceCreationTime,
                                  DCM_SeriesDate, DCM_SeriesTime, DCM_InstanceCreatorUID})
    item.findAndDeleteElement(moment);
}

void write_object(const fs::path& path, DcmDataset& dataset) {
  write_atomically(path, [&](const fs::path& temporary) {
    DcmFileFormat file(&dataset);
    if (file.saveFile(temporary.c_str(), EXS_LittleEndianExplicit).bad())
      throw IoError("could not write " + path.string() + " (is the disk full?). Free some space");
  });
}

void silence_log() { OFLog::configure(OFLogger::OFF_LOG_LEVEL); }

}  // namespace angio::dicom::detail
