#include "datasets/detail/write_dicom.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "datasets/detail/phantom_dicom.hpp"

namespace angio::datasets::detail {
namespace {

std::uint64_t hash(std::string_view text, std::uint64_t basis) {  // FNV-1a, then SplitMix64's mixer
  std::uint64_t h = basis;
  for (char c : text) h = (h ^ std::uint64_t(static_cast<unsigned char>(c))) * 0x100000001b3ULL;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
  return h ^ (h >> 31);
}

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

}  // namespace angio::datasets::detail
