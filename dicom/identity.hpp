#pragma once

#include <string>
#include <vector>

namespace angio::dicom {

/// Under which patient and study an archive files an object. Texts are UTF-8.
struct StudyIdentity {
  std::string patient_name, patient_id, birth_date, sex;
  std::string study_uid, study_id, study_date, study_time, study_description;
  std::string accession_number, referring_physician;
  std::string frame_of_reference_uid;  ///< in which the coordinates are
};

/// An image that a result was made from.
struct SourceObject {
  std::string sop_class_uid, instance_uid;
};

/// The scan behind a case, as its archive knows it.
struct SourceLink {
  StudyIdentity identity;
  std::string modality;
  std::string series_uid;
  std::vector<SourceObject> objects;
};

/// A UID made of a hash: 2.25 and a number of 128 bits (DICOM PS3.5 B.2). The same text gives the
/// same UID.
std::string hashed_uid(const std::string& text);

/// An identity that names nobody: the case's name stands for the patient's, the UIDs follow from
/// the seed, dates are empty.
/// @param case_name  as the user gave it, or a hash; cut to the 64 characters that DICOM allows
/// @param seed       the same for all objects of a study
StudyIdentity anonymous_identity(const std::string& case_name, const std::string& seed);

}  // namespace angio::dicom
