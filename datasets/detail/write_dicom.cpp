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

class Series {
 public:
  Series(const Volume<float>& volume, std::string_view name, std::string_view fingerprint)
      : volume_(volume), fingerprint_(fingerprint) {
    for (char c : name) name_ += char(std::toupper(static_cast<unsigned char>(c)));
  }

  void write_slice(int k, const std::filesystem::path& path) const {
    DcmFileFormat file;
    DcmDataset& dataset = *file.getDataset();
    put_patient_and_study(dataset);
    put_series_and_equipment(dataset);
    put_image(dataset, k);
    put_pixels(dataset, k);
    write_atomically(path, [&](const std::filesystem::path& temporary) {
      check(file.saveFile(temporary.c_str(), EXS_LittleEndianExplicit, EET_ExplicitLength,
                          EGL_recalcGL, EPD_noChange),
            path);
    });
  }

 private:
  [[nodiscard]] std::string uid(std::string_view what) const {
    return uid_from(fingerprint_ + "/" + std::string(what));
  }
  static void check(const OFCondition& condition, const std::filesystem::path& path) {
    if (condition.bad())
      throw IoError("cannot write " + path.string() + " (" + condition.text() +
                    "). Is the disk full?");
  }
  static void put(DcmDataset& dataset, const DcmTagKey& tag, const std::string& value) {
    if (dataset.putAndInsertString(tag, value.c_str()).bad())
      throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
  }
  static void put(DcmDataset& dataset, const DcmTagKey& tag, int value) {
    if (dataset.putAndInsertUint16(tag, Uint16(value)).bad())
      throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
  }

  void put_patient_and_study(DcmDataset& dataset) const {
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

  void put_series_and_equipment(DcmDataset& dataset) const {
    put(dataset, DCM_Modality, "CT");
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

  void put_image(DcmDataset& dataset, int k) const {
    const VolumeGeometry& g = volume_.geometry;
    const Vec3 row{g.direction(0, 0), g.direction(1, 0), g.direction(2, 0)};
    const Vec3 column{g.direction(0, 1), g.direction(1, 1), g.direction(2, 1)};
    put(dataset, DCM_SOPClassUID, UID_CTImageStorage);
    put(dataset, DCM_SOPInstanceUID, uid("instance " + std::to_string(k + 1)));
    put(dataset, DCM_ImageType, "DERIVED\\SECONDARY\\AXIAL");
    put(dataset, DCM_InstanceNumber, std::to_string(k + 1));
    put(dataset, DCM_ContentDate, kDate);
    put(dataset, DCM_ContentTime, kTime);
    put(dataset, DCM_AcquisitionNumber, "1");
    put(dataset, DCM_KVP, "");
    put(dataset, DCM_PixelSpacing, decimal(g.spacing.y) + "\\" + decimal(g.spacing.x));
    put(dataset, DCM_SliceThickness, decimal(g.spacing.z));
    put(dataset, DCM_ImageOrientationPatient, decimals(row) + "\\" + decimals(column));
    put(dataset, DCM_ImagePositionPatient, decimals(g.lps_from_index({0.0, 0.0, double(k)})));
    put(dataset, DCM_RescaleIntercept, decimal(kRescaleIntercept));
    put(dataset, DCM_RescaleSlope, "1");
    put(dataset, DCM_RescaleType, "HU");
    put(dataset, DCM_WindowCenter, "220");
    put(dataset, DCM_WindowWidth, "600");
  }

  void put_pixels(DcmDataset& dataset, int k) const {
    const VolumeGeometry& g = volume_.geometry;
    put(dataset, DCM_SamplesPerPixel, 1);
    put(dataset, DCM_PhotometricInterpretation, "MONOCHROME2");
    put(dataset, DCM_Rows, g.size[1]);
    put(dataset, DCM_Columns, g.size[0]);
    put(dataset, DCM_BitsAllocated, 16);
    put(dataset, DCM_BitsStored, 16);
    put(dataset, DCM_HighBit, 15);
    put(dataset, DCM_PixelRepresentation, 1);
    const std::size_t count = std::size_t(g.size[0]) * std::size_t(g.size[1]);
    const float* values = volume_.values.data() + g.offset(0, 0, k);
    std::vector<Uint16> pixels(count);
    constexpr double kLeast = std::numeric_limits<std::int16_t>::min();
    constexpr double kMost = std::numeric_limits<std::int16_t>::max();
    for (std::size_t i = 0; i < count; ++i) {
      const double stored =
          std::clamp(std::round(double(values[i]) - kRescaleIntercept), kLeast, kMost);
      pixels[i] = Uint16(std::int16_t(stored));
    }
    if (dataset
            .putAndInsertUint16Array(DCM_PixelData, pixels.data(),
                                     static_cast<unsigned long>(count))
            .bad())
      throw InternalError("DCMTK refuses the pixels of a phantom's slice");
  }

  const Volume<float>& volume_;
  std::string name_;
  std::string fingerprint_;
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
  const Series series(volume, name, fingerprint);
  for (int k = 0; k < volume.geometry.size[2]; ++k) {
    std::array<char, 32> file{};
    std::snprintf(file.data(), file.size(), "IM%04d.dcm", k + 1);
    series.write_slice(k, folder / file.data());
  }
}

}  // namespace angio::datasets::detail
