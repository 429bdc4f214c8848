#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

// DCMTK's configuration must come before its other headers.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/volume.hpp"
#include "datasets/detail/write_dicom.hpp"

namespace angio::datasets::detail {

inline constexpr double kRescaleIntercept = -1024.0;
inline constexpr const char* kDate = "20000101";
inline constexpr const char* kTime = "120000";

/// A decimal string (VR DS) holds at most 16 characters.
inline std::string decimal(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value == 0.0 ? 0.0 : value);
  return text.data();
}

inline std::string decimals(const Vec3& v) {
  return decimal(v.x) + "\\" + decimal(v.y) + "\\" + decimal(v.z);
}

/// Puts attributes into a dataset or a sequence item.
inline void put(DcmItem& item, const DcmTagKey& tag, const std::string& value) {
  if (item.putAndInsertString(tag, value.c_str()).bad())
    throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
}
inline void put(DcmItem& item, const DcmTagKey& tag, int value) {
  if (item.putAndInsertUint16(tag, Uint16(value)).bad())
    throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
}
inline void put(DcmItem& item, const DcmTagKey& tag, const std::vector<Uint32>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (item.putAndInsertUint32(tag, values[i], static_cast<unsigned long>(i)).bad())
      throw InternalError("DCMTK refuses a value for " + std::string(tag.toString().c_str()));
}

/// A new item at the end of a sequence.
inline DcmItem& add_item(DcmItem& parent, const DcmTagKey& sequence) {
  DcmItem* item = nullptr;
  if (parent.findOrCreateSequenceItem(sequence, item, -2).bad() || !item)
    throw InternalError("DCMTK refuses an item of " + std::string(sequence.toString().c_str()));
  return *item;
}

inline void put_code(DcmItem& parent, const DcmTagKey& sequence, const char* value,
                     const char* scheme, const char* meaning) {
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

}  // namespace angio::datasets::detail
