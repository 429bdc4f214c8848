#include <dcmtk/dcmdata/dcpixel.h>
#include <dcmtk/dcmdata/dcpixseq.h>
#include <dcmtk/dcmdata/dcpxitem.h>
#include <dcmtk/dcmdata/dcuid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "segmentation/detail/dicom_parse.hpp"

namespace angio::segmentation::detail {
namespace {

/// Elements longer than this stay on disk while headers are read.
constexpr Uint32 kReadLimitBytes = 4096;
constexpr int kMaxFrameCount = 1 << 16;

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

/// A stored pixel value, which writers give as US or SS whatever the sign of the pixels.
std::optional<int> stored_number(DcmDataset& dataset, const DcmTagKey& tag, bool is_signed) {
  Uint16 as_unsigned = 0;
  Sint16 as_signed = 0;
  if (is_signed && dataset.findAndGetSint16(tag, as_signed).good()) return int(as_signed);
  if (dataset.findAndGetUint16(tag, as_unsigned).good())
    return is_signed ? int(std::int16_t(as_unsigned)) : int(as_unsigned);
  if (dataset.findAndGetSint16(tag, as_signed).good())
    return is_signed ? int(as_signed) : int(std::uint16_t(as_signed));
  return {};
}

void read_pixel_format(DcmDataset& dataset, DicomHeader& header) {
  header.pixels.rows = integer(dataset, DCM_Rows);
  header.pixels.columns = integer(dataset, DCM_Columns);
  header.pixels.bits_allocated = integer(dataset, DCM_BitsAllocated);
  header.pixels.bits_stored = integer(dataset, DCM_BitsStored);
  header.pixels.high_bit = integer(dataset, DCM_HighBit);
  header.pixels.is_signed = integer(dataset, DCM_PixelRepresentation) == 1;
  header.pixels.is_monochrome1 = text(dataset, DCM_PhotometricInterpretation) == "MONOCHROME1";
  header.pixels.has_modality_lut = dataset.tagExists(DCM_ModalityLUTSequence);
  header.burned_in = text(dataset, DCM_BurnedInAnnotation) == "YES";
  const auto padding = stored_number(dataset, DCM_PixelPaddingValue, header.pixels.is_signed);
  if (!padding) return;
  const auto limit = stored_number(dataset, DCM_PixelPaddingRangeLimit, header.pixels.is_signed);
  header.pixels.has_padding = true;
  header.pixels.padding_first = std::min(*padding, limit.value_or(*padding));
  header.pixels.padding_last = std::max(*padding, limit.value_or(*padding));
}

/// Whether the first JPEG 2000 stream uses the irreversible transform, whatever the header says of
/// loss. Source: ISO/IEC 15444-1, A.6.1 (COD marker segment) and Table A.20.
bool is_irreversible_jpeg_2000(DcmDataset& dataset) {
  constexpr std::array<unsigned char, 2> kCodMarker = {0xff, 0x52};
  constexpr std::ptrdiff_t kTransformOffset = 13;  // from the marker
  DcmElement* element = nullptr;
  dataset.findAndGetElement(DCM_PixelData, element);
  auto* pixels = dynamic_cast<DcmPixelData*>(element);
  E_TransferSyntax syntax = EXS_Unknown;
  const DcmRepresentationParameter* parameter = nullptr;
  DcmPixelSequence* sequence = nullptr;
  DcmPixelItem* fragment = nullptr;
  if (pixels) pixels->getOriginalRepresentationKey(syntax, parameter);
  if (!pixels || pixels->getEncapsulatedRepresentation(syntax, parameter, sequence).bad() ||
      !sequence || sequence->getItem(fragment, 1).bad() || !fragment)
    return false;
  std::vector<unsigned char> head(std::min<Uint32>(fragment->getLength(), 2048));
  if (head.empty() || fragment->getPartialValue(head.data(), 0, Uint32(head.size())).bad())
    return false;
  const auto marker = std::search(head.begin(), head.end(), kCodMarker.begin(), kCodMarker.end());
  return head.end() - marker > kTransformOffset && marker[kTransformOffset] == 0;
}

/// Why the pixels cannot be read, or nothing.
std::string pixel_problem(DcmDataset& dataset, const DicomHeader& header, int frame_count) {
  if (dataset.tagExists(DCM_FloatPixelData) || dataset.tagExists(DCM_DoubleFloatPixelData))
    return "its pixels are floating-point numbers (which this program does not read from DICOM). "
           "Convert it to NRRD or NIfTI";
  DcmElement* pixels = nullptr;
  if (dataset.findAndGetElement(DCM_PixelData, pixels).bad() || !pixels)
    return "the object has no pixel data (truncated, or not an image). Export the series again";
  const std::string photometric = text(dataset, DCM_PhotometricInterpretation);
  if (integer(dataset, DCM_SamplesPerPixel) != 1 ||
      (!photometric.empty() && !photometric.starts_with("MONOCHROME")))
    return "the pixels are in colour (a rendered view, not measured intensities). Export the "
           "original series";
  if (header.pixels.rows < 1 || header.pixels.columns < 1)
    return "rows or columns are missing. Export the series again";
  const bool known_format =
      (header.pixels.bits_allocated == 8 || header.pixels.bits_allocated == 16) &&
      header.pixels.bits_stored >= 1 && header.pixels.bits_stored <= header.pixels.bits_allocated &&
      header.pixels.high_bit >= header.pixels.bits_stored - 1 &&
      header.pixels.high_bit < header.pixels.bits_allocated;
  if (!known_format)
    return "the pixel format is not supported (" + std::to_string(header.pixels.bits_allocated) +
           " bits allocated, " + std::to_string(header.pixels.bits_stored) +
           " stored). Export the series with 8 or 16 bits";
  const std::uint64_t expected = std::uint64_t(header.pixels.rows) *
                                 std::uint64_t(header.pixels.columns) * std::uint64_t(frame_count) *
                                 std::uint64_t(header.pixels.bits_allocated / 8);
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

void read_identifiers(DcmFileFormat& file, DicomHeader& header) {
  DcmDataset& dataset = *file.getDataset();
  header.sop_class_uid = text(dataset, DCM_SOPClassUID);
  if (header.sop_class_uid.empty() && file.getMetaInfo())
    header.sop_class_uid = text(*file.getMetaInfo(), DCM_MediaStorageSOPClassUID);
  header.series_uid = text(dataset, DCM_SeriesInstanceUID);
  header.instance_uid = text(dataset, DCM_SOPInstanceUID);
  header.concatenation_uid = text(dataset, DCM_ConcatenationUID);
  // Defined terms of PS3.16, annex L: "HEART", "CORONARYARTERY".
  const std::string part = text(dataset, DCM_BodyPartExamined);
  header.is_of_the_heart = part.starts_with("HEART") || part.starts_with("CORONARY");
  constexpr double kMostInstances = 1e9;  // in magnitude; a larger one is none
  const double instance = number(dataset, DCM_InstanceNumber).value_or(0.0);
  header.instance_number = std::abs(instance) <= kMostInstances ? int(instance) : 0;
  header.kind = kind_of(header.sop_class_uid);
  const char* name = dcmFindNameOfUID(header.sop_class_uid.c_str());
  header.sop_class_name = name ? in_words(name) : "an unknown kind of object";
}

bool has_known_class(const DicomHeader& header) { return header.sop_class_uid.starts_with("1."); }

/// DCMTK guesses where it does not know the syntax, and would take compressed pixels for plain
/// ones.
bool has_unknown_syntax(DcmFileFormat& file) {
  const std::string syntax =
      file.getMetaInfo() ? text(*file.getMetaInfo(), DCM_TransferSyntaxUID) : std::string();
  return !syntax.empty() && DcmXfer(syntax.c_str()).getXfer() == EXS_Unknown;
}

void read_object(DcmDataset& dataset, DicomHeader& header) {
  read_transfer_syntax(dataset, header);
  read_pixel_format(dataset, header);
  Sint32 frame_count = 1;
  if (dataset.findAndGetSint32(DCM_NumberOfFrames, frame_count).bad()) frame_count = 1;
  if (frame_count < 1 || frame_count > kMaxFrameCount) {
    header.problem = "the number of frames is impossible (the header is damaged). Export it again";
    return;
  }
  header.problem = pixel_problem(dataset, header, frame_count);
  header.lossy = header.lossy || (header.jpeg_2000 && is_irreversible_jpeg_2000(dataset));
  parse_frames(dataset, frame_count, header);
  header.multi_frame_object = frame_count > 1;
  if (header.kind == DicomKind::projection)
    header.projection = parse_projection_run(dataset, frame_count);
}

}  // namespace

std::optional<DicomHeader> parse_header(DicomLoader& loader, const DicomSource& source) {
  if (!loader.may_be_dicom(source)) return {};
  DcmFileFormat file;
  const OFCondition status = loader.load(source, kReadLimitBytes, file);
  DicomHeader header;
  header.source = source;
  read_identifiers(file, header);
  if (header.sop_class_uid == UID_MediaStorageDirectoryStorage) return {};
  if (has_unknown_syntax(file))
    header.problem =
        "its transfer syntax is not known here (a newer or a private compression). Export the "
        "series uncompressed (Explicit VR Little Endian)";
  else if (status.bad() && file.getDataset()->tagExists(DCM_Rows))
    header.problem =
        "the file is truncated or damaged (it ends within its pixels, as a copy that was broken "
        "off). Copy or export it again";
  else if (status.bad() || !has_known_class(header))
    header.problem =
        "the file is truncated or damaged (its header cannot be read to the end). Copy or export "
        "it again";
  else
    read_object(*file.getDataset(), header);
  return header;
}

}  // namespace angio::segmentation::detail
