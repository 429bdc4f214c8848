#include "datasets/detail/write_dicom.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <vector>

// DCMTK's configuration must come before its other headers.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"

namespace angio::datasets::detail {
namespace {

constexpr double kRescaleIntercept = -1024.0;
constexpr const char* kDate = "20000101";
constexpr const char* kTime = "120000";

std::uint64_t hash(std::string_view text, std::uint64_t basis) {  // FNV-1a, then SplitMix64's mixer
  std::uint64_t h = basis;
  for (char c : text) h = (h ^ std::uint64_t(static_cast<unsigned char>(c))) * 0x100000001b3ULL;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
  return h ^ (h >> 31);
}

/// A decimal string (VR DS) holds at most 16 characters.
std::string decimal(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value == 0.0 ? 0.0 : value);
  return text.data();
}

std::string decimals(const Vec3& v) {
  return decimal(v.x) + "\\" + decimal(v.y) + "\\" + decimal(v.z);
}

/// Puts attributes into a dataset or a sequence item.
void put(DcmItem& item, const DcmTagKey& tag, const std::string& value) {
  if (item.putAndInsertString(tag, value.c_str()).bad())
    throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
}
void put(DcmItem& item, const DcmTagKey& tag, int value) {
  if (item.putAndInsertUint16(tag, Uint16(value)).bad())
    throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
}
void put(DcmItem& item, const DcmTagKey& tag, const std::vector<Uint32>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (item.putAndInsertUint32(tag, values[i], static_cast<unsigned long>(i)).bad())
      throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
}

/// A new item at the end of a sequence.
DcmItem& add_item(DcmItem& parent, const DcmTagKey& sequence) {
  DcmItem* item = nullptr;
  if (parent.findOrCreateSequenceItem(sequence, item, -2).bad() || !item)
    throw InternalError("DCMTK refuses an item of " + std::string(sequence.toString().c_str()));
  return *item;
}

void put_code(DcmItem& parent, const DcmTagKey& sequence, const char* value, const char* scheme,
              const char* meaning) {
  DcmItem& code = add_item(parent, sequence);
  put(code, DCM_CodeValue, value);
  put(code, DCM_CodingSchemeDesignator, scheme);
  put(code, DCM_CodeMeaning, meaning);
}

/// What the objects of a phantom have in common, whatever their class.
class PhantomDicom {
 public:
  PhantomDicom(const Volume<float>& volume, std::string_view name, std::string_view fingerprint)
      : volume_(volume), fingerprint_(fingerprint) {
    for (char c : name) name_ += char(std::toupper(static_cast<unsigned char>(c)));
  }

 protected:
  [[nodiscard]] const VolumeGeometry& geometry() const { return volume_.geometry; }
  [[nodiscard]] std::string uid(std::string_view what) const {
    return uid_from(fingerprint_ + "/" + std::string(what));
  }
  static void save(DcmFileFormat& file, const std::filesystem::path& path) {
    write_atomically(path, [&](const std::filesystem::path& temporary) {
      const OFCondition condition = file.saveFile(temporary.c_str(), EXS_LittleEndianExplicit,
                                                  EET_ExplicitLength, EGL_recalcGL, EPD_noChange);
      if (condition.bad())
        throw IoError("cannot write " + path.string() + " (" + condition.text() +
                      "). Is the disk full?");
    });
  }

  void put_patient_and_study(DcmItem& dataset) const {
    put(dataset, DCM_PatientName, "PHANTOM^" + name_);
    put(dataset, DCM_PatientID, "PHANTOM-" + name_);
    put(dataset, DCM_PatientBirthDate, "");
    put(dataset, DCM_PatientSex, "");
    put(dataset, DCM_StudyInstanceUID, uid("study"));
    put(dataset, DCM_StudyDate, kDate);
    put(dataset, DCM_StudyTime, kTime);
    put(dataset, DCM_ReferringPhysicianName, "");
    put(dataset, DCM_StudyID, "1");
    put(dataset, DCM_AccessionNumber, "");
    put(dataset, DCM_StudyDescription, "angio phantom");
  }

  void put_series_and_equipment(DcmItem& dataset, const char* modality) const {
    put(dataset, DCM_Modality, modality);
    put(dataset, DCM_SeriesInstanceUID, uid("series"));
    put(dataset, DCM_SeriesNumber, "1");
    put(dataset, DCM_BodyPartExamined, "HEART");
    put(dataset, DCM_SeriesDate, kDate);
    put(dataset, DCM_SeriesTime, kTime);
    put(dataset, DCM_SeriesDescription, "angio phantom " + name_);
    put(dataset, DCM_PatientPosition, "HFS");
    put(dataset, DCM_FrameOfReferenceUID, uid("frame of reference"));
    put(dataset, DCM_PositionReferenceIndicator, "");
    put(dataset, DCM_Manufacturer, "angio");
    put(dataset, DCM_ManufacturerModelName, "phantom");
  }

  [[nodiscard]] std::string pixel_spacing() const {
    return decimal(geometry().spacing.y) + "\\" + decimal(geometry().spacing.x);
  }
  [[nodiscard]] std::string orientation() const {
    const Mat3& m = geometry().direction;
    return decimals({m(0, 0), m(1, 0), m(2, 0)}) + "\\" + decimals({m(0, 1), m(1, 1), m(2, 1)});
  }
  [[nodiscard]] std::string position(int k) const {
    return decimals(geometry().lps_from_index({0.0, 0.0, double(k)}));
  }
  static void put_rescale(DcmItem& item) {
    put(item, DCM_RescaleIntercept, decimal(kRescaleIntercept));
    put(item, DCM_RescaleSlope, "1");
    put(item, DCM_RescaleType, "HU");
  }
  static void put_window(DcmItem& item) {
    put(item, DCM_WindowCenter, "220");
    put(item, DCM_WindowWidth, "600");
  }

  /// Slices [first, last) as 16 bit numbers, rounded to whole Hounsfield units.
  ///
  /// @param is_signed  otherwise numbers below the intercept become it
  void put_pixels(DcmItem& dataset, int first, int last, bool is_signed) const {
    const VolumeGeometry& g = geometry();
    put(dataset, DCM_SamplesPerPixel, 1);
    put(dataset, DCM_PhotometricInterpretation, "MONOCHROME2");
    put(dataset, DCM_Rows, g.size[1]);
    put(dataset, DCM_Columns, g.size[0]);
    put(dataset, DCM_BitsAllocated, 16);
    put(dataset, DCM_BitsStored, 16);
    put(dataset, DCM_HighBit, 15);
    put(dataset, DCM_PixelRepresentation, is_signed ? 1 : 0);
    const std::size_t count =
        std::size_t(g.size[0]) * std::size_t(g.size[1]) * std::size_t(last - first);
    const float* values = volume_.values.data() + g.offset(0, 0, first);
    std::vector<Uint16> pixels(count);
    const double least = is_signed ? double(std::numeric_limits<std::int16_t>::min()) : 0.0;
    const double most = is_signed ? double(std::numeric_limits<std::int16_t>::max())
                                  : double(std::numeric_limits<std::uint16_t>::max());
    for (std::size_t i = 0; i < count; ++i) {
      const double stored =
          std::clamp(std::round(double(values[i]) - kRescaleIntercept), least, most);
      pixels[i] = Uint16(std::int32_t(stored));
    }
    if (dataset
            .putAndInsertUint16Array(DCM_PixelData, pixels.data(),
                                     static_cast<unsigned long>(count))
            .bad())
      throw InternalError("DCMTK refuses the pixels of a phantom");
  }

 private:
  const Volume<float>& volume_;
  std::string name_;
  std::string fingerprint_;
};

/// CT Image Storage, a slice an object.
class CtSeries : PhantomDicom {
 public:
  using PhantomDicom::PhantomDicom;

  void write_slice(int k, const std::filesystem::path& path) const {
    DcmFileFormat file;
    DcmDataset& dataset = *file.getDataset();
    put_patient_and_study(dataset);
    put_series_and_equipment(dataset, "CT");
    put(dataset, DCM_SOPClassUID, UID_CTImageStorage);
    put(dataset, DCM_SOPInstanceUID, uid("instance " + std::to_string(k + 1)));
    put(dataset, DCM_ImageType, "DERIVED\\SECONDARY\\AXIAL");
    put(dataset, DCM_InstanceNumber, std::to_string(k + 1));
    put(dataset, DCM_ContentDate, kDate);
    put(dataset, DCM_ContentTime, kTime);
    put(dataset, DCM_AcquisitionNumber, "1");
    put(dataset, DCM_KVP, "");
    put(dataset, DCM_PixelSpacing, pixel_spacing());
    put(dataset, DCM_SliceThickness, decimal(geometry().spacing.z));
    put(dataset, DCM_ImageOrientationPatient, orientation());
    put(dataset, DCM_ImagePositionPatient, position(k));
    put_rescale(dataset);
    put_window(dataset);
    put_pixels(dataset, k, k + 1, true);
    save(file, path);
  }
};

/// X-Ray 3D Angiographic Image Storage, the whole volume in one object (PS3.3, A.53).
class XRay3DImage : PhantomDicom {
 public:
  using PhantomDicom::PhantomDicom;

  void write(const std::filesystem::path& path) const {
    DcmFileFormat file;
    DcmDataset& dataset = *file.getDataset();
    put_patient_and_study(dataset);
    put_series_and_equipment(dataset, "XA");
    put(dataset, DCM_DeviceSerialNumber, "1");
    put(dataset, DCM_SoftwareVersions, "1");
    put_image(dataset);
    put_acquisition(dataset);
    put_dimensions(dataset);
    put_shared_groups(add_item(dataset, DCM_SharedFunctionalGroupsSequence));
    for (int k = 0; k < geometry().size[2]; ++k)
      put_frame_groups(add_item(dataset, DCM_PerFrameFunctionalGroupsSequence), k);
    put(dataset, DCM_NumberOfFrames, std::to_string(geometry().size[2]));
    put_pixels(dataset, 0, geometry().size[2], false);
    save(file, path);
  }

 private:
  static constexpr const char* kImageType = "ORIGINAL\\PRIMARY\\VOLUME\\NONE";
  static constexpr const char* kDateTime = "20000101120000";

  void put_image(DcmItem& dataset) const {
    put(dataset, DCM_SOPClassUID, UID_XRay3DAngiographicImageStorage);
    put(dataset, DCM_SOPInstanceUID, uid("instance 1"));
    put(dataset, DCM_ImageType, kImageType);
    put(dataset, DCM_InstanceNumber, "1");
    put(dataset, DCM_ContentDate, kDate);
    put(dataset, DCM_ContentTime, kTime);
    put(dataset, DCM_ContentQualification, "RESEARCH");
    put(dataset, DCM_BurnedInAnnotation, "NO");
    put(dataset, DCM_LossyImageCompression, "00");
    put(dataset, DCM_PresentationLUTShape, "IDENTITY");
    put(dataset, DCM_PixelPresentation, "MONOCHROME");
    put(dataset, DCM_VolumetricProperties, "VOLUME");
    put(dataset, DCM_VolumeBasedCalculationTechnique, "NONE");
    if (dataset.insertEmptyElement(DCM_AcquisitionContextSequence).bad())
      throw InternalError("DCMTK refuses an empty sequence");
  }

  static void put_acquisition(DcmItem& dataset) {
    DcmItem& acquisition = add_item(dataset, DCM_XRay3DAcquisitionSequence);
    put(acquisition, DCM_FieldOfViewShape, "RECTANGLE");
    put(acquisition, DCM_DetectorType, "");
    DcmItem& reconstruction = add_item(dataset, DCM_XRay3DReconstructionSequence);
    put(reconstruction, DCM_ReconstructionDescription, "exact partial volume, blurred");
    put(reconstruction, DCM_ApplicationName, "angio");
    put(reconstruction, DCM_ApplicationVersion, "1");
    put(reconstruction, DCM_ApplicationManufacturer, "angio");
    put(reconstruction, DCM_AlgorithmType, "OTHER");
    put(reconstruction, DCM_AcquisitionIndex, 1);
  }

  void put_dimensions(DcmItem& dataset) const {
    put(add_item(dataset, DCM_DimensionOrganizationSequence), DCM_DimensionOrganizationUID,
        uid("dimension"));
    DcmItem& index = add_item(dataset, DCM_DimensionIndexSequence);
    put(index, DCM_DimensionOrganizationUID, uid("dimension"));
    if (index.putAndInsertTagKey(DCM_DimensionIndexPointer, DCM_InStackPositionNumber).bad() ||
        index.putAndInsertTagKey(DCM_FunctionalGroupPointer, DCM_FrameContentSequence).bad())
      throw InternalError("DCMTK refuses a dimension index");
  }

  void put_shared_groups(DcmItem& groups) const {
    DcmItem& measures = add_item(groups, DCM_PixelMeasuresSequence);
    put(measures, DCM_PixelSpacing, pixel_spacing());
    put(measures, DCM_SliceThickness, decimal(geometry().spacing.z));
    put(add_item(groups, DCM_PlaneOrientationSequence), DCM_ImageOrientationPatient, orientation());
    DcmItem& anatomy = add_item(groups, DCM_FrameAnatomySequence);
    put(anatomy, DCM_FrameLaterality, "U");
    put_code(anatomy, DCM_AnatomicRegionSequence, "80891009", "SCT", "Heart");
    DcmItem& type = add_item(groups, DCM_XRay3DFrameTypeSequence);
    put(type, DCM_FrameType, kImageType);
    put(type, DCM_PixelPresentation, "MONOCHROME");
    put(type, DCM_VolumetricProperties, "VOLUME");
    put(type, DCM_VolumeBasedCalculationTechnique, "NONE");
    put(type, DCM_ReconstructionIndex, 1);
    put_rescale(add_item(groups, DCM_PixelValueTransformationSequence));
    put_window(add_item(groups, DCM_FrameVOILUTSequence));
  }

  void put_frame_groups(DcmItem& groups, int k) const {
    DcmItem& content = add_item(groups, DCM_FrameContentSequence);
    put(content, DCM_FrameReferenceDateTime, kDateTime);
    put(content, DCM_FrameAcquisitionDateTime, kDateTime);
    if (content.putAndInsertFloat64(DCM_FrameAcquisitionDuration, 0.0).bad())
      throw InternalError("DCMTK refuses a duration");
    put(content, DCM_StackID, "1");
    put(content, DCM_InStackPositionNumber, std::vector<Uint32>{Uint32(k + 1)});
    put(content, DCM_DimensionIndexValues, std::vector<Uint32>{Uint32(k + 1)});
    put(add_item(groups, DCM_PlanePositionSequence), DCM_ImagePositionPatient, position(k));
  }
};

/// X-Ray Angiographic Image Storage, a run of the C-arm in one object (PS3.3, A.14).
class XaRun : PhantomDicom {
 public:
  XaRun(const RotationalRunOfPhantom& run, std::string_view name, std::string_view fingerprint,
        int number)
      : PhantomDicom(run.phantom.volume, name, fingerprint), run_(run), number_(number) {}

  void write(const std::vector<std::uint16_t>& pixels, bool has_contrast_medium,
             const std::filesystem::path& path) const {
    DcmFileFormat file;
    DcmDataset& dataset = *file.getDataset();
    put_patient_and_study(dataset);
    put_series_and_equipment(dataset, "XA");
    put(dataset, DCM_SeriesInstanceUID, uid("series " + std::to_string(number_)));
    put(dataset, DCM_SeriesNumber, std::to_string(number_));
    put_image(dataset, has_contrast_medium);
    put_positioner(dataset);
    put_frames(dataset, pixels);
    save(file, path);
  }

 private:
  void put_image(DcmItem& dataset, bool has_contrast_medium) const {
    put(dataset, DCM_SOPClassUID, UID_XRayAngiographicImageStorage);
    put(dataset, DCM_SOPInstanceUID, uid("instance " + std::to_string(number_)));
    put(dataset, DCM_ImageType, "ORIGINAL\\PRIMARY\\SINGLE PLANE");
    put(dataset, DCM_InstanceNumber, "1");
    put(dataset, DCM_AcquisitionNumber, std::to_string(number_));
    put(dataset, DCM_ContentDate, kDate);
    put(dataset, DCM_ContentTime, kTime);
    put(dataset, DCM_PixelIntensityRelationship, "LIN");
    put(dataset, DCM_RadiationSetting, "GR");
    put(dataset, DCM_LossyImageCompression, "00");
    put(dataset, DCM_BurnedInAnnotation, "NO");
    put(dataset, DCM_KVP, "");
    if (has_contrast_medium) put(dataset, DCM_ContrastBolusAgent, "Iodine");
  }

  void put_positioner(DcmItem& dataset) const {
    const angiogram::CArmMount& mount = run_.mount;
    put(dataset, DCM_DistanceSourceToDetector, decimal(mount.source_to_detector_mm));
    put(dataset, DCM_DistanceSourceToPatient, decimal(mount.source_to_isocentre_mm));
    put(dataset, DCM_EstimatedRadiographicMagnificationFactor,
        decimal(mount.source_to_detector_mm / mount.source_to_isocentre_mm));
    put(dataset, DCM_ImagerPixelSpacing,
        decimal(mount.row_spacing_mm) + "\\" + decimal(mount.column_spacing_mm));
    put(dataset, DCM_PositionerMotion, "DYNAMIC");
    put(dataset, DCM_TableMotion, "STATIC");
    const double base = run_.primary_angles_degrees.front();
    put(dataset, DCM_PositionerPrimaryAngle, decimal(base));
    put(dataset, DCM_PositionerSecondaryAngle, "0");
    std::string primary, secondary;
    for (const double angle : run_.primary_angles_degrees) {
      primary += (primary.empty() ? "" : "\\") + decimal(angle - base);
      secondary += secondary.empty() ? "0" : "\\0";
    }
    put(dataset, DCM_PositionerPrimaryAngleIncrement, primary);
    put(dataset, DCM_PositionerSecondaryAngleIncrement, secondary);
  }

  /// The frames of the R waves, numbered from 1 (PS3.3, C.8.7.1, X-Ray Image Module).
  void put_heart(DcmItem& dataset) const {
    const std::vector<int>& frames = run_.motion.r_wave_frames;
    if (frames.empty() || !run_.options.tells_r_waves) return;
    std::vector<Uint16> numbers;
    for (const int frame : frames) numbers.push_back(Uint16(frame + 1));
    if (dataset
            .putAndInsertUint16Array(DCM_RWavePointer, numbers.data(),
                                     static_cast<unsigned long>(numbers.size()))
            .bad())
      throw InternalError("DCMTK refuses the R waves of a run");
    put(dataset, DCM_HeartRate, std::to_string(int(std::lround(run_.options.heart_rate_per_min))));
  }

  void put_frames(DcmItem& dataset, const std::vector<std::uint16_t>& pixels) const {
    put(dataset, DCM_NumberOfFrames, std::to_string(run_.frames.size()));
    if (dataset.putAndInsertTagKey(DCM_FrameIncrementPointer, DCM_FrameTime).bad())
      throw InternalError("DCMTK refuses a frame pointer");
    put(dataset, DCM_FrameTime, decimal(run_.options.frame_time_ms));
    put_heart(dataset);
    put(dataset, DCM_SamplesPerPixel, 1);
    put(dataset, DCM_PhotometricInterpretation, "MONOCHROME2");
    put(dataset, DCM_Rows, run_.mount.rows);
    put(dataset, DCM_Columns, run_.mount.columns);
    put(dataset, DCM_BitsAllocated, 16);
    put(dataset, DCM_BitsStored, 16);
    put(dataset, DCM_HighBit, 15);
    put(dataset, DCM_PixelRepresentation, 0);
    if (dataset
            .putAndInsertUint16Array(DCM_PixelData, pixels.data(),
                                     static_cast<unsigned long>(pixels.size()))
            .bad())
      throw InternalError("DCMTK refuses the pixels of a run");
  }

  const RotationalRunOfPhantom& run_;
  int number_;
};

}  // namespace

std::string uid_from(std::string_view text) {
  // 128 bits, marked as an RFC 4122 UUID made from a name (version 5, variant 10).
  std::uint64_t high = hash(text, 0xcbf29ce484222325ULL);
  std::uint64_t low = hash(text, 0x84222325cbf29ce4ULL);
  high = (high & ~0xf000ULL) | 0x5000ULL;
  low = (low & ~(3ULL << 62)) | (2ULL << 62);
  std::array<std::uint64_t, 4> limbs{high >> 32, high & 0xffffffffULL, low >> 32,
                                     low & 0xffffffffULL};
  std::string digits;
  while (std::any_of(limbs.begin(), limbs.end(), [](std::uint64_t l) { return l != 0; })) {
    std::uint64_t rest = 0;
    for (std::uint64_t& limb : limbs) {
      const std::uint64_t value = (rest << 32) | limb;
      limb = value / 10;
      rest = value % 10;
    }
    digits += char('0' + char(rest));
  }
  return "2.25." + std::string(digits.rbegin(), digits.rend());
}

void write_dicom_series(const Volume<float>& volume, std::string_view name,
                        std::string_view fingerprint, const std::filesystem::path& folder) {
  const CtSeries series(volume, name, fingerprint);
  for (int k = 0; k < volume.geometry.size[2]; ++k) {
    std::array<char, 32> file{};
    std::snprintf(file.data(), file.size(), "IM%04d.dcm", k + 1);
    series.write_slice(k, folder / file.data());
  }
}

void write_dicom_xray_3d(const Volume<float>& volume, std::string_view name,
                         std::string_view fingerprint, const std::filesystem::path& folder) {
  XRay3DImage(volume, name, std::string(fingerprint) + " X-Ray 3D").write(folder / "IM0001.dcm");
}

void write_xa_run(const RotationalRunOfPhantom& run, const std::vector<std::uint16_t>& pixels,
                  std::string_view name, std::string_view fingerprint, int number,
                  bool has_contrast_medium, const std::filesystem::path& path) {
  XaRun(run, name, std::string(fingerprint) + " XA", number)
      .write(pixels, has_contrast_medium, path);
}

}  // namespace angio::datasets::detail
