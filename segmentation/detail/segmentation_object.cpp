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
#include <openssl/evp.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "core/error.hpp"
#include "segmentation/detail/dicom_parse.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr Uint32 kReadLimitBytes = 4096;
constexpr const char* kNoDate =
    "19000101";  ///< the standard wants one; the true one tells of the patient
constexpr const char* kNoTime = "000000";
constexpr std::size_t kMaxDecimalLength = 16;

void check(const OFCondition& condition, const char* what) {
  if (condition.bad())
    throw IoError(std::string("cannot make a DICOM segmentation (") + what + ": " +
                  condition.text() + "). Take lumen_mask.nrrd instead");
}

/// As precise as 16 characters can say it, as DICOM's decimal strings may have no more.
OFString decimal(double value) {
  std::array<char, 40> text{};
  for (int digits = 15; digits > 0; --digits) {
    const int length = std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    if (std::size_t(length) <= kMaxDecimalLength) break;
  }
  return {text.data()};
}

/// A UID made of a hash: 2.25 and a number of 128 bits (DICOM PS3.5 B.2).
OFString uid_from(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_Digest(text.data(), text.size(), digest.data(), &length, EVP_sha256(), nullptr);
  std::string digits;
  std::array<unsigned char, 16> number{};
  std::copy_n(digest.begin(), number.size(), number.begin());
  bool rest = true;
  while (rest) {  // division by ten, digit by digit of base 256
    unsigned int remainder = 0;
    rest = false;
    for (unsigned char& byte : number) {
      const unsigned int value = remainder * 256u + byte;
      byte = static_cast<unsigned char>(value / 10u);
      remainder = value % 10u;
      rest = rest || byte != 0;
    }
    digits.insert(digits.begin(), char('0' + remainder));
  }
  return ("2.25." + digits).c_str();
}

/// Names the object's UIDs: the source and the lumen in it.
std::string seed_of(const DicomSeries& series, const SegmentationFrames& frames) {
  std::string seed = series.headers.front().series_uid;
  for (std::size_t f = 0; f < frames.slices.size(); ++f) {
    const auto [h, frame] = frames.slices[f];
    seed += "|" + series.headers[std::size_t(h)].instance_uid + "|" + std::to_string(frame) + "|";
    seed.append(frames.masks[f].begin(), frames.masks[f].end());
  }
  return seed;
}

/// A UID of the source, or one made up where anonymisation took it away.
OFString uid_or(DcmDataset& source, const DcmTagKey& tag, const std::string& seed) {
  OFString uid;
  return source.findAndGetOFString(tag, uid).good() && !uid.empty() ? uid : uid_from(seed);
}

std::unique_ptr<DcmSegmentation> create(const DicomHeader& header) {
  DcmSegmentation* created = nullptr;
  check(DcmSegmentation::createBinarySegmentation(
            created, Uint16(header.pixels.rows), Uint16(header.pixels.columns),
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

void set_identity(DcmSegmentation& object, DcmDataset& source, const std::string& seed,
                  const DicomSegmentationOptions& options) {
  if (options.keep_patient)
    check(object.importHierarchy(source, OFTrue, OFTrue, OFFalse, OFFalse), "patient and study");
  check(object.getStudy().setStudyInstanceUID(uid_or(source, DCM_StudyInstanceUID, seed + "study")),
        "study");
  check(object.getFrameOfReference().setFrameOfReferenceUID(
            uid_or(source, DCM_FrameOfReferenceUID, seed + "frame of reference")),
        "frame of reference");
  check(object.getSeries().setSeriesInstanceUID(uid_from(seed + "series")), "series");
  check(object.getSeries().setSeriesNumber("1"), "series");
  check(object.getSeries().setSeriesDescription("Vessel lumen"), "series");
  check(object.getSOPCommon().setSOPInstanceUID(uid_from(seed + "object")), "object");
}

void add_references(DcmSegmentation& object, const DicomSeries& series,
                    const SegmentationFrames& frames, const OFString& study_uid) {
  IODReferences references;
  int last = -1;
  for (const auto& [h, frame] : frames.slices) {
    if (h == last) continue;  // frames of an object follow each other, or are the same anyway
    last = h;
    const DicomHeader& header = series.headers[std::size_t(h)];
    references.add(new IODImageReference("", study_uid, header.series_uid.c_str(),
                                         header.instance_uid.c_str(),
                                         header.sop_class_uid.c_str()));
  }
  object.getCommonInstanceReference().addReferences(references, study_uid);
}

void add_shared_groups(DcmSegmentation& object, const DicomSeries& series) {
  const DicomFrame& frame = series.frame(series.slices.front());
  const OFString thickness = decimal(series.stack.geometry.spacing.z);
  FGPixelMeasures measures;
  check(measures.setPixelSpacing(decimal(frame.spacing_j) + "\\" + decimal(frame.spacing_i)),
        "spacing");
  check(measures.setSliceThickness(thickness), "thickness");
  check(measures.setSpacingBetweenSlices(thickness), "thickness");
  check(object.addForAllFrames(measures), "spacing");
  const std::unique_ptr<FGPlaneOrientationPatient> orientation(
      FGPlaneOrientationPatient::createMinimal(decimal(frame.axis_i.x), decimal(frame.axis_i.y),
                                               decimal(frame.axis_i.z), decimal(frame.axis_j.x),
                                               decimal(frame.axis_j.y), decimal(frame.axis_j.z)));
  if (!orientation) throw IoError("cannot make a DICOM segmentation (orientation)");
  check(object.addForAllFrames(*orientation), "orientation");
}

/// Which image of the source a frame was drawn on.
std::unique_ptr<FGDerivationImage> derivation_from(const DicomHeader& header, int frame) {
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
  check(reference.setReferencedSOPClassUID(header.sop_class_uid.c_str()), "source image");
  check(reference.setReferencedSOPInstanceUID(header.instance_uid.c_str()), "source image");
  if (header.multi_frame_object)
    check(reference.addReferencedFrameNumber(Uint16(frame + 1)), "source frame");
  item->getSourceImageItems().push_back(source.release());
  return derivation;
}

void add_frame(DcmSegmentation& object, const DicomHeader& header, const SliceReference& slice,
               const std::vector<std::uint8_t>& mask, std::size_t number) {
  const Vec3& position = header.frames[std::size_t(slice.frame)].position;
  const std::unique_ptr<FGPlanePosPatient> place(FGPlanePosPatient::createMinimal(
      decimal(position.x), decimal(position.y), decimal(position.z)));
  if (!place) throw IoError("cannot make a DICOM segmentation (position)");
  FGFrameContent content;
  check(content.setDimensionIndexValues(1, 0), "dimension");  // of the segment
  check(content.setDimensionIndexValues(Uint32(number + 1), 1), "dimension");
  const auto derivation = derivation_from(header, slice.frame);
  OFVector<FGBase*> groups;
  groups.push_back(place.get());
  groups.push_back(&content);
  groups.push_back(derivation.get());
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

void write_segmentation_object(const std::filesystem::path& path, const DicomSeries& series,
                               const SegmentationFrames& frames,
                               const DicomSegmentationOptions& options) {
  const DicomHeader& first = series.headers.front();
  DicomLoader loader;
  DcmFileFormat source;
  check(loader.load(first.source, kReadLimitBytes, source), "the source cannot be read again");
  const std::string seed = seed_of(series, frames);

  const std::unique_ptr<DcmSegmentation> object = create(first);
  add_segment(*object);
  set_identity(*object, *source.getDataset(), seed, options);
  OFString study_uid;
  object->getStudy().getStudyInstanceUID(study_uid);
  add_references(*object, series, frames, study_uid);
  add_shared_groups(*object, series);
  add_dimensions(*object, uid_from(seed + "dimensions"));
  for (std::size_t f = 0; f < frames.slices.size(); ++f)
    add_frame(*object, series.headers[std::size_t(frames.slices[f].header)], frames.slices[f],
              frames.masks[f], f);

  DcmFileFormat file;
  check(object->writeDataset(*file.getDataset()), "object");
  set_dates(*file.getDataset());
  check(file.saveFile(path.c_str(), EXS_LittleEndianExplicit), "file");
}

}  // namespace angio::segmentation::detail
