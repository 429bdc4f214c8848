#include "segmentation/detail/segmentation_object.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmfg/fgderimg.h>
#include <dcmtk/dcmfg/fgfracon.h>
#include <dcmtk/dcmfg/fgpixmsr.h>
#include <dcmtk/dcmfg/fgplanor.h>
#include <dcmtk/dcmfg/fgplanpo.h>
#include <dcmtk/dcmiod/iodreferences.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "core/error.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr const char* kNoDate =
    "19000101";  ///< the standard wants one; the true one tells of the patient
constexpr const char* kNoTime = "000000";
constexpr std::size_t kMaxDecimalLength = 16;

void check(const OFCondition& condition, const char* what) {
  if (condition.bad())
    throw IoError(std::string("cannot make a DICOM segmentation (") + what + ": " +
                  condition.text() + "). Take lumen_mask.nrrd instead");
}

OFString uid_from(const std::string& text) { return dicom::hashed_uid(text).c_str(); }

/// As precise as 16 characters can say it, as DICOM's decimal strings may have no more.
OFString decimal(double value) {
  std::array<char, 40> text{};
  for (int digits = 15; digits > 0; --digits) {
    const int length = std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    if (std::size_t(length) <= kMaxDecimalLength) break;
  }
  return {text.data()};
}

std::unique_ptr<DcmSegmentation> create(const SegmentationFrames& frames) {
  DcmSegmentation* created = nullptr;
  check(DcmSegmentation::createBinarySegmentation(
            created, Uint16(frames.rows), Uint16(frames.columns),
            IODGeneralEquipmentModule::EquipmentInfo("angio", "angio", "none", "1"),
            ContentIdentificationMacro("1", "LUMEN", "Lumen of the contrast-filled vessels", "")),
        "image");
  return std::unique_ptr<DcmSegmentation>(created);
}

void add_segment(DcmSegmentation& object) {
  DcmSegment* segment = nullptr;
  check(DcmSegment::create(segment, "Lumen",
                           CodeSequenceMacro("123037004", "SCT", "Anatomical Structure"),
                           CodeSequenceMacro("91747007", "SCT", "Lumen of blood vessel"),
                           DcmSegTypes::SAT_AUTOMATIC, "angio"),
        "segment");
  segment->setRecommendedDisplayCIELabValue(34885, 53485, 50171);  // red
  Uint16 number = 0;
  check(object.addSegment(segment, number), "segment");
}

void set_identity(DcmSegmentation& object, const dicom::StudyIdentity& identity,
                  const std::string& seed) {
  IODPatientModule& patient = object.getPatient();
  check(patient.setPatientName(identity.patient_name.c_str(), OFFalse), "patient");
  check(patient.setPatientID(identity.patient_id.c_str(), OFFalse), "patient");
  check(patient.setPatientBirthDate(identity.birth_date.c_str(), OFFalse), "patient");
  check(patient.setPatientSex(identity.sex.c_str(), OFFalse), "patient");
  IODGeneralStudyModule& study = object.getStudy();
  check(study.setStudyInstanceUID(identity.study_uid.c_str()), "study");
  check(study.setStudyID(identity.study_id.c_str(), OFFalse), "study");
  check(study.setStudyDate(identity.study_date.c_str(), OFFalse), "study");
  check(study.setStudyTime(identity.study_time.c_str(), OFFalse), "study");
  check(study.setAccessionNumber(identity.accession_number.c_str(), OFFalse), "study");
  check(study.setReferringPhysicianName(identity.referring_physician.c_str(), OFFalse), "study");
  if (!identity.study_description.empty())
    check(study.setStudyDescription(identity.study_description.c_str(), OFFalse), "study");
  check(
      object.getFrameOfReference().setFrameOfReferenceUID(identity.frame_of_reference_uid.c_str()),
      "frame of reference");
  check(object.getSeries().setSeriesInstanceUID(uid_from(seed + "series")), "series");
  check(object.getSeries().setSeriesNumber("1"), "series");
  check(object.getSeries().setSeriesDescription("Vessel lumen"), "series");
  check(object.getSOPCommon().setSOPInstanceUID(uid_from(seed + "object")), "object");
}

void add_references(DcmSegmentation& object, const SegmentationFrames& frames,
                    const OFString& study_uid) {
  IODReferences references;
  std::string last;
  for (const SegmentationPlane& plane : frames.planes) {
    // Frames of an object follow each other, or are the same anyway.
    if (plane.source.instance_uid.empty() || plane.source.instance_uid == last) continue;
    last = plane.source.instance_uid;
    references.add(new IODImageReference("", study_uid, frames.source_series_uid.c_str(),
                                         plane.source.instance_uid.c_str(),
                                         plane.source.sop_class_uid.c_str()));
  }
  if (!last.empty()) object.getCommonInstanceReference().addReferences(references, study_uid);
}

void add_shared_groups(DcmSegmentation& object, const SegmentationFrames& frames) {
  const OFString thickness = decimal(frames.thickness);
  FGPixelMeasures measures;
  check(measures.setPixelSpacing(decimal(frames.spacing_j) + "\\" + decimal(frames.spacing_i)),
        "spacing");
  check(measures.setSliceThickness(thickness), "thickness");
  check(measures.setSpacingBetweenSlices(thickness), "thickness");
  check(object.addForAllFrames(measures), "spacing");
  const std::unique_ptr<FGPlaneOrientationPatient> orientation(
      FGPlaneOrientationPatient::createMinimal(decimal(frames.axis_i.x), decimal(frames.axis_i.y),
                                               decimal(frames.axis_i.z), decimal(frames.axis_j.x),
                                               decimal(frames.axis_j.y), decimal(frames.axis_j.z)));
  if (!orientation) throw IoError("cannot make a DICOM segmentation (orientation)");
  check(object.addForAllFrames(*orientation), "orientation");
}

/// Which image of the source a frame was drawn on.
std::unique_ptr<FGDerivationImage> derivation_from(const SegmentationPlane& plane) {
  auto derivation = std::make_unique<FGDerivationImage>();
  DerivationImageItem* item = nullptr;
  check(derivation->addDerivationImageItem(CodeSequenceMacro("113076", "DCM", "Segmentation"),
                                           "Lumen segmentation", item),
        "derivation");
  auto source = std::make_unique<SourceImageItem>();
  check(source->getPurposeOfReferenceCode().set("121322", "DCM",
                                                "Source image for image processing operation"),
        "derivation");
  ImageSOPInstanceReferenceMacro& reference = source->getImageSOPInstanceReference();
  check(reference.setReferencedSOPClassUID(plane.source.sop_class_uid.c_str()), "source image");
  check(reference.setReferencedSOPInstanceUID(plane.source.instance_uid.c_str()), "source image");
  if (plane.source_frame >= 0)
    check(reference.addReferencedFrameNumber(Uint16(plane.source_frame + 1)), "source frame");
  item->getSourceImageItems().push_back(source.release());
  return derivation;
}

void add_frame(DcmSegmentation& object, const SegmentationPlane& plane,
               const std::vector<std::uint8_t>& mask, std::size_t number) {
  const Vec3& position = plane.position;
  const std::unique_ptr<FGPlanePosPatient> place(FGPlanePosPatient::createMinimal(
      decimal(position.x), decimal(position.y), decimal(position.z)));
  if (!place) throw IoError("cannot make a DICOM segmentation (position)");
  FGFrameContent content;
  check(content.setDimensionIndexValues(1, 0), "dimension");  // of the segment
  check(content.setDimensionIndexValues(Uint32(number + 1), 1), "dimension");
  std::unique_ptr<FGDerivationImage> derivation;
  OFVector<FGBase*> groups;
  groups.push_back(place.get());
  groups.push_back(&content);
  if (!plane.source.instance_uid.empty()) {
    derivation = derivation_from(plane);
    groups.push_back(derivation.get());
  }
  std::vector<Uint8> pixels(mask.begin(), mask.end());
  check(object.addFrame(pixels.data(), 1, groups), "frame");
}

void add_dimensions(DcmSegmentation& object, const OFString& uid) {
  IODMultiframeDimensionModule& dimensions = object.getDimensions();
  check(dimensions.addDimensionIndex(DCM_ReferencedSegmentNumber, uid,
                                     DCM_SegmentIdentificationSequence, "Segment"),
        "dimension");
  check(dimensions.addDimensionIndex(DCM_ImagePositionPatient, uid, DCM_PlanePositionSequence,
                                     "Position"),
        "dimension");
}

/// DCMTK writes today's date, but the same input has to give the same bytes.
void set_dates(DcmDataset& dataset) {
  for (const DcmTagKey& date : {DCM_ContentDate, DCM_SeriesDate, DCM_InstanceCreationDate})
    if (dataset.tagExists(date) || date == DCM_ContentDate)
      dataset.putAndInsertString(date, kNoDate);
  for (const DcmTagKey& time : {DCM_ContentTime, DCM_SeriesTime, DCM_InstanceCreationTime})
    if (dataset.tagExists(time) || time == DCM_ContentTime)
      dataset.putAndInsertString(time, kNoTime);
}

}  // namespace

std::string seed_of(const SegmentationFrames& frames) {
  std::string seed = frames.source_series_uid;
  for (std::size_t f = 0; f < frames.planes.size(); ++f) {
    const SegmentationPlane& plane = frames.planes[f];
    seed += "|" + plane.source.instance_uid + "|" + std::to_string(plane.source_frame) + "|";
    seed.append(frames.masks[f].begin(), frames.masks[f].end());
  }
  return seed;
}

void write_segmentation_object(const std::filesystem::path& path, const SegmentationFrames& frames,
                               const dicom::StudyIdentity& identity, const std::string& seed) {
  const std::unique_ptr<DcmSegmentation> object = create(frames);
  add_segment(*object);
  set_identity(*object, identity, seed);
  add_references(*object, frames, identity.study_uid.c_str());
  add_shared_groups(*object, frames);
  add_dimensions(*object, uid_from(seed + "dimensions"));
  for (std::size_t f = 0; f < frames.planes.size(); ++f)
    add_frame(*object, frames.planes[f], frames.masks[f], f);

  DcmFileFormat file;
  check(object->writeDataset(*file.getDataset()), "object");
  set_dates(*file.getDataset());
  check(file.getDataset()->putAndInsertString(DCM_SpecificCharacterSet, "ISO_IR 192"), "texts");
  check(file.saveFile(path.c_str(), EXS_LittleEndianExplicit), "file");
}

}  // namespace angio::segmentation::detail
