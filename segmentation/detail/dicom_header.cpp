#include "segmentation/detail/dicom_header.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmdata/dcuid.h>
#include <dcmtk/oflog/oflog.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>

namespace angio::segmentation::detail {
namespace {

/// Elements longer than this stay on disk while headers are read.
constexpr Uint32 kReadLimitBytes = 4096;
constexpr int kMaxFrameCount = 1 << 16;

void silence_dcmtk() {
  // Its log could print attribute values, hence identity.
  static std::once_flag once;
  std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
}

/// Cheap test before the parser sees a file: a preamble, or a first group of 0002 or 0008.
bool may_be_dicom(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 132> head{};
  file.read(head.data(), head.size());
  const auto count = file.gcount();
  if (count == 132 && std::memcmp(head.data() + 128, "DICM", 4) == 0) return true;
  if (count < 8) return false;
  const auto byte = [&](int i) { return static_cast<unsigned char>(head[std::size_t(i)]); };
  const bool little = (byte(0) == 0x02 || byte(0) == 0x08) && byte(1) == 0;
  const bool big = byte(0) == 0 && (byte(1) == 0x02 || byte(1) == 0x08);
  return (little && byte(3) == 0) || (big && byte(2) == 0);
}

std::string text(DcmItem& item, const DcmTagKey& tag) {
  OFString value;
  return item.findAndGetOFString(tag, value).good() ? std::string(value.c_str()) : std::string();
}

std::optional<double> number(DcmItem& item, const DcmTagKey& tag, unsigned long position = 0) {
  Float64 value = 0.0;
  if (item.findAndGetFloat64(tag, value, position).bad() || !std::isfinite(value)) return {};
  return value;
}

int integer(DcmItem& item, const DcmTagKey& tag) {
  Uint16 value = 0;
  return item.findAndGetUint16(tag, value).good() ? int(value) : 0;
}

std::optional<Vec3> vector(DcmItem& item, const DcmTagKey& tag, unsigned long first = 0) {
  Vec3 v;
  for (unsigned long axis = 0; axis < 3; ++axis) {
    const auto value = number(item, tag, first + axis);
    if (!value) return {};
    v[int(axis)] = *value;
  }
  return v;
}

void read_position(DcmItem& item, DicomFrame& frame) {
  if (const auto position = vector(item, DCM_ImagePositionPatient)) {
    frame.position = *position;
    frame.has_position = true;
  }
}

void read_orientation(DcmItem& item, DicomFrame& frame) {
  const auto i = vector(item, DCM_ImageOrientationPatient, 0);
  const auto j = vector(item, DCM_ImageOrientationPatient, 3);
  if (!i || !j) return;
  frame.axis_i = *i;
  frame.axis_j = *j;
  frame.has_orientation = true;
}

void read_spacing(DcmItem& item, DicomFrame& frame) {
  // DICOM gives the distance between rows first.
  const auto j = number(item, DCM_PixelSpacing, 0);
  const auto i = number(item, DCM_PixelSpacing, 1);
  if (!i || !j) return;
  frame.spacing_i = *i;
  frame.spacing_j = *j;
  frame.has_spacing = true;
}

void read_rescale(DcmItem& item, DicomFrame& frame) {
  const auto slope = number(item, DCM_RescaleSlope);
  const auto intercept = number(item, DCM_RescaleIntercept);
  if (!slope || !intercept || *slope == 0.0) return;
  frame.slope = *slope;
  frame.intercept = *intercept;
}

/// Calls read(item, frame) on the item of a functional group's one-item sequence, if it is there.
template <class Read>
void read_group(DcmItem& groups, const DcmTagKey& sequence, DicomFrame& frame, const Read& read) {
  DcmItem* item = nullptr;
  if (groups.findAndGetSequenceItem(sequence, item, 0).good() && item) read(*item, frame);
}

void read_functional_groups(DcmItem& groups, DicomFrame& frame) {
  read_group(groups, DCM_PlanePositionSequence, frame, read_position);
  read_group(groups, DCM_PlaneOrientationSequence, frame, read_orientation);
  read_group(groups, DCM_PixelMeasuresSequence, frame, read_spacing);
  read_group(groups, DCM_PixelValueTransformationSequence, frame, read_rescale);
}

void read_frames(DcmDataset& dataset, int frame_count, DicomHeader& header) {
  DicomFrame common;
  // Some 3D angiography systems keep the rescale with the reconstruction only.
  read_group(dataset, DCM_XRay3DReconstructionSequence, common, read_rescale);
  read_position(dataset, common);
  read_orientation(dataset, common);
  read_spacing(dataset, common);
  read_rescale(dataset, common);

  DcmItem* shared = nullptr;
  if (dataset.findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, shared, 0).good() &&
      shared)
    read_functional_groups(*shared, common);
  header.frames.assign(std::size_t(frame_count), common);

  DcmSequenceOfItems* per_frame = nullptr;
  if (dataset.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, per_frame).bad() ||
      !per_frame)
    return;
  header.multi_frame_object = true;
  if (per_frame->card() != unsigned(frame_count)) {
    header.problem = "the object lists " + std::to_string(per_frame->card()) +
                     " frame descriptions for " + std::to_string(frame_count) +
                     " frames (it is damaged). Export the series again";
    return;
  }
  DcmObject* item = nullptr;
  for (auto& frame : header.frames) {
    item = per_frame->nextInContainer(item);
    if (auto* groups = dynamic_cast<DcmItem*>(item)) read_functional_groups(*groups, frame);
  }
}

DicomKind kind_of(const std::string& sop_class) {
  for (const char* uid :
       {UID_CTImageStorage, UID_EnhancedCTImageStorage, UID_LegacyConvertedEnhancedCTImageStorage,
        UID_MRImageStorage, UID_EnhancedMRImageStorage, UID_LegacyConvertedEnhancedMRImageStorage,
        UID_XRay3DAngiographicImageStorage, UID_XRay3DCraniofacialImageStorage})
    if (sop_class == uid) return DicomKind::volume;
  for (const char* uid :
       {UID_SecondaryCaptureImageStorage, UID_MultiframeGrayscaleByteSecondaryCaptureImageStorage,
        UID_MultiframeGrayscaleWordSecondaryCaptureImageStorage,
        UID_MultiframeSingleBitSecondaryCaptureImageStorage,
        UID_MultiframeTrueColorSecondaryCaptureImageStorage})
    if (sop_class == uid) return DicomKind::capture;
  for (const char* uid :
       {UID_XRayAngiographicImageStorage, UID_EnhancedXAImageStorage,
        UID_XRayRadiofluoroscopicImageStorage, UID_EnhancedXRFImageStorage,
        UID_RETIRED_XRayAngiographicBiPlaneImageStorage, UID_ComputedRadiographyImageStorage,
        UID_DigitalXRayImageStorageForPresentation, UID_DigitalXRayImageStorageForProcessing})
    if (sop_class == uid) return DicomKind::projection;
  return DicomKind::unsupported;
}

void read_transfer_syntax(DcmDataset& dataset, DicomHeader& header) {
  const DcmXfer syntax(dataset.getOriginalXfer());
  header.transfer_syntax_uid = syntax.getXferID() ? syntax.getXferID() : "";
  header.transfer_syntax_name = syntax.getXferName() ? syntax.getXferName() : "unknown";
  header.compressed = syntax.isEncapsulated();
  const E_TransferSyntax xfer = syntax.getXfer();
  header.jpeg_2000 = xfer == EXS_JPEG2000 || xfer == EXS_JPEG2000LosslessOnly;
  const std::string lossy_flag = text(dataset, DCM_LossyImageCompression);
  const bool lossless_syntax = xfer == EXS_JPEGProcess14 || xfer == EXS_JPEGProcess14SV1 ||
                               xfer == EXS_JPEGLSLossless || xfer == EXS_JPEG2000LosslessOnly ||
                               xfer == EXS_RLELossless;
  // A syntax that allows loss is taken as lossy unless the object denies it.
  header.lossy = lossy_flag == "01" || (header.compressed && !lossless_syntax &&
                                        !(header.jpeg_2000 && lossy_flag == "00"));
}

void read_pixel_format(DcmDataset& dataset, DicomHeader& header) {
  header.rows = integer(dataset, DCM_Rows);
  header.columns = integer(dataset, DCM_Columns);
  header.bits_allocated = integer(dataset, DCM_BitsAllocated);
  header.bits_stored = integer(dataset, DCM_BitsStored);
  header.high_bit = integer(dataset, DCM_HighBit);
  header.is_signed = integer(dataset, DCM_PixelRepresentation) == 1;
  header.is_monochrome1 = text(dataset, DCM_PhotometricInterpretation) == "MONOCHROME1";
  header.has_modality_lut = dataset.tagExists(DCM_ModalityLUTSequence);
  Uint16 padding_unsigned = 0;
  Sint16 padding_signed = 0;
  if (header.is_signed && dataset.findAndGetSint16(DCM_PixelPaddingValue, padding_signed).good())
    header.padding_value = padding_signed;
  else if (dataset.findAndGetUint16(DCM_PixelPaddingValue, padding_unsigned).good())
    header.padding_value =
        header.is_signed ? int(std::int16_t(padding_unsigned)) : int(padding_unsigned);
}

/// Why the pixels cannot be read, or nothing.
std::string pixel_problem(DcmDataset& dataset, const DicomHeader& header, int frame_count) {
  DcmElement* pixels = nullptr;
  if (dataset.findAndGetElement(DCM_PixelData, pixels).bad() || !pixels)
    return "the object has no pixel data (truncated, or not an image). Export the series again";
  if (integer(dataset, DCM_SamplesPerPixel) != 1)
    return "the pixels are in colour (a rendered view, not measured intensities). Export the "
           "original series";
  if (header.rows < 1 || header.columns < 1)
    return "rows or columns are missing. Export the series again";
  const bool known_format =
      (header.bits_allocated == 8 || header.bits_allocated == 16) && header.bits_stored >= 1 &&
      header.bits_stored <= header.bits_allocated && header.high_bit >= header.bits_stored - 1 &&
      header.high_bit < header.bits_allocated;
  if (!known_format)
    return "the pixel format is not supported (" + std::to_string(header.bits_allocated) +
           " bits allocated, " + std::to_string(header.bits_stored) +
           " stored). Export the series with 8 or 16 bits";
  const std::uint64_t expected = std::uint64_t(header.rows) * std::uint64_t(header.columns) *
                                 std::uint64_t(frame_count) *
                                 std::uint64_t(header.bits_allocated / 8);
  if (!header.compressed && pixels->getLength() < expected)
    return "the pixel data are truncated (" + std::to_string(pixels->getLength()) + " of " +
           std::to_string(expected) + " bytes). Copy or export the series again";
  return {};
}

/// DCMTK writes names without blanks: XRayAngiographicImageStorage.
std::string in_words(const std::string& name) {
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  std::string words;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool starts_word = i > 0 && is_upper(name[i]) &&
                             (!is_upper(name[i - 1]) ||
                              (i + 1 < name.size() && name[i + 1] >= 'a' && name[i + 1] <= 'z'));
    if (starts_word && words.back() != ' ') words += ' ';
    words += name[i];
  }
  for (const auto& [written, meant] :
       {std::pair<std::string, std::string>{"X Ray3 D", "X-Ray 3D"}, {"X Ray", "X-Ray"}}) {
    const auto place = words.find(written);
    if (place != std::string::npos) words.replace(place, written.size(), meant);
  }
  return words;
}

void read_identifiers(DcmDataset& dataset, DicomHeader& header) {
  header.sop_class_uid = text(dataset, DCM_SOPClassUID);
  header.series_uid = text(dataset, DCM_SeriesInstanceUID);
  header.instance_uid = text(dataset, DCM_SOPInstanceUID);
  header.kind = kind_of(header.sop_class_uid);
  const char* name = dcmFindNameOfUID(header.sop_class_uid.c_str());
  header.sop_class_name = name ? in_words(name) : "an unknown kind of object";
}

}  // namespace

std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path) {
  silence_dcmtk();
  if (!may_be_dicom(path)) return {};
  DcmFileFormat file;
  const OFCondition status =
      file.loadFile(path.c_str(), EXS_Unknown, EGL_noChange, kReadLimitBytes, ERM_autoDetect);
  DcmDataset& dataset = *file.getDataset();
  DicomHeader header;
  header.path = path;
  read_identifiers(dataset, header);
  const bool has_class = header.sop_class_uid.starts_with("1.");
  if (header.sop_class_uid == UID_MediaStorageDirectoryStorage ||
      (file.getMetaInfo() &&
       text(*file.getMetaInfo(), DCM_MediaStorageSOPClassUID) == UID_MediaStorageDirectoryStorage))
    return {};
  if (status.bad() || !has_class) {
    header.problem =
        "the file is truncated or damaged (its header cannot be read to the end). "
        "Copy or export it again";
    return header;
  }
  read_transfer_syntax(dataset, header);
  read_pixel_format(dataset, header);
  Sint32 frame_count = 1;
  if (dataset.findAndGetSint32(DCM_NumberOfFrames, frame_count).bad()) frame_count = 1;
  if (frame_count < 1 || frame_count > kMaxFrameCount) {
    header.problem = "the number of frames is impossible (the header is damaged). Export it again";
    return header;
  }
  header.problem = pixel_problem(dataset, header, frame_count);
  read_frames(dataset, frame_count, header);
  header.multi_frame_object = header.multi_frame_object || frame_count > 1;
  return header;
}

}  // namespace angio::segmentation::detail
