#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/temporary_folder.hpp"

/// Small made-up DICOM objects for tests.
namespace angio::segmentation {
namespace fs = std::filesystem;

inline std::string decimals(const std::vector<double>& values) {
  std::ostringstream text;
  text.precision(10);
  for (std::size_t v = 0; v < values.size(); ++v) text << (v > 0 ? "\\" : "") << values[v];
  return text.str();
}

inline void put(DcmItem& item, const DcmTagKey& tag, const std::string& value) {
  ASSERT_TRUE(item.putAndInsertString(tag, value.c_str()).good()) << value;
}

/// What differs between the made-up slices.
struct Slice {
  Vec3 position{-1, -2, 0};
  Vec3 axis_i{1, 0, 0};
  Vec3 axis_j{0, 1, 0};
  double spacing_i = 0.4;
  double spacing_j = 0.6;
  std::string series = "1.2.826.0.1.3680043.2.100";
  std::string photometric = "MONOCHROME2";
  std::string lossy = "00";
  int rows = 6;
  int columns = 5;
  int bits_allocated = 16;
  int bits_stored = 12;
  bool is_signed = false;
  double slope = 1.0;
  double intercept = 0.0;
  int number = 1;
  const char* sop_class = UID_CTImageStorage;
  bool has_geometry = true;
  /// The stored value of pixel (i, j).
  std::function<int(int i, int j)> pixel = [](int i, int j) { return 100 + 5 * j + i; };
  /// Anything else in the object.
  std::function<void(DcmDataset&)> more = [](DcmDataset&) {};
};

inline std::vector<Uint16> pixels_of(const Slice& slice) {
  std::vector<Uint16> pixels;
  const int mask = (1 << slice.bits_stored) - 1;
  for (int j = 0; j < slice.rows; ++j)
    for (int i = 0; i < slice.columns; ++i) pixels.push_back(Uint16(slice.pixel(i, j) & mask));
  return pixels;
}

inline void put_pixels(DcmDataset& d, const Slice& slice, std::vector<Uint16> pixels) {
  d.putAndInsertUint16(DCM_SamplesPerPixel, 1);
  put(d, DCM_PhotometricInterpretation, slice.photometric);
  d.putAndInsertUint16(DCM_Rows, Uint16(slice.rows));
  d.putAndInsertUint16(DCM_Columns, Uint16(slice.columns));
  d.putAndInsertUint16(DCM_BitsAllocated, Uint16(slice.bits_allocated));
  d.putAndInsertUint16(DCM_BitsStored, Uint16(slice.bits_stored));
  d.putAndInsertUint16(DCM_HighBit, Uint16(slice.bits_stored - 1));
  d.putAndInsertUint16(DCM_PixelRepresentation, slice.is_signed ? 1 : 0);
  if (slice.bits_allocated == 8) {
    const std::vector<Uint8> bytes(pixels.begin(), pixels.end());
    d.putAndInsertUint8Array(DCM_PixelData, bytes.data(), bytes.size());
  } else {
    d.putAndInsertUint16Array(DCM_PixelData, pixels.data(), pixels.size());
  }
}

inline std::string instance_uid(const Slice& slice) {
  const auto part = [](double value) { return "." + std::to_string(long(10000 + 100 * value)); };
  return slice.series + part(slice.position.x) + part(slice.position.y) + part(slice.position.z) +
         "." + std::to_string(slice.number);
}

inline void put_identity(DcmDataset& d, const Slice& slice) {
  put(d, DCM_SOPClassUID, slice.sop_class);
  put(d, DCM_SOPInstanceUID, instance_uid(slice));
  put(d, DCM_StudyInstanceUID, "1.2.826.0.1.3680043.2.10");
  put(d, DCM_SeriesInstanceUID, slice.series);
  put(d, DCM_FrameOfReferenceUID, "1.2.826.0.1.3680043.2.20");
  put(d, DCM_InstanceNumber, std::to_string(slice.number));
  put(d, DCM_PatientName, "SECRET^NAME");
  put(d, DCM_PatientID, "SECRET");
  put(d, DCM_LossyImageCompression, slice.lossy);
}

/// A single-frame object.
inline void write_slice(const fs::path& path, const Slice& slice,
                        E_TransferSyntax syntax = EXS_LittleEndianExplicit) {
  DcmFileFormat file;
  DcmDataset& d = *file.getDataset();
  put_identity(d, slice);
  put(d, DCM_RescaleSlope, decimals({slice.slope}));
  put(d, DCM_RescaleIntercept, decimals({slice.intercept}));
  if (slice.has_geometry) {
    put(d, DCM_PixelSpacing, decimals({slice.spacing_j, slice.spacing_i}));
    const Vec3 &i = slice.axis_i, &j = slice.axis_j, &p = slice.position;
    put(d, DCM_ImageOrientationPatient, decimals({i.x, i.y, i.z, j.x, j.y, j.z}));
    put(d, DCM_ImagePositionPatient, decimals({p.x, p.y, p.z}));
  }
  put_pixels(d, slice, pixels_of(slice));
  slice.more(d);
  ASSERT_TRUE(file.saveFile(path.c_str(), syntax).good());
}

/// An item of a functional group's sequence, made if it is missing.
inline DcmItem& group(DcmItem& item, const DcmTagKey& sequence) {
  DcmItem* found = nullptr;
  EXPECT_TRUE(item.findOrCreateSequenceItem(sequence, found, 0).good());
  return *found;
}

enum class RescaleIn { nothing, shared_groups, frame_groups, reconstruction };

/// A multi-frame object with functional groups; its frames are slices.
struct EnhancedObject {
  std::vector<Slice> frames;
  bool shared_orientation = true;
  RescaleIn rescale = RescaleIn::frame_groups;
  std::function<void(DcmItem& groups, int frame)> more_groups = [](DcmItem&, int) {};
  std::function<void(DcmDataset&)> more = [](DcmDataset&) {};
};

inline void put_rescale(DcmItem& item, const Slice& slice) {
  put(item, DCM_RescaleSlope, decimals({slice.slope}));
  put(item, DCM_RescaleIntercept, decimals({slice.intercept}));
}

inline void put_orientation(DcmItem& groups, const Slice& slice) {
  const Vec3 &i = slice.axis_i, &j = slice.axis_j;
  put(group(groups, DCM_PlaneOrientationSequence), DCM_ImageOrientationPatient,
      decimals({i.x, i.y, i.z, j.x, j.y, j.z}));
  put(group(groups, DCM_PixelMeasuresSequence), DCM_PixelSpacing,
      decimals({slice.spacing_j, slice.spacing_i}));
}

inline void write_enhanced(const fs::path& path, const EnhancedObject& object,
                           E_TransferSyntax syntax = EXS_LittleEndianExplicit) {
  DcmFileFormat file;
  DcmDataset& d = *file.getDataset();
  const Slice& first = object.frames.front();
  put_identity(d, first);
  put(d, DCM_NumberOfFrames, std::to_string(object.frames.size()));
  DcmItem& shared = group(d, DCM_SharedFunctionalGroupsSequence);
  if (object.shared_orientation) put_orientation(shared, first);
  if (object.rescale == RescaleIn::shared_groups)
    put_rescale(group(shared, DCM_PixelValueTransformationSequence), first);
  if (object.rescale == RescaleIn::reconstruction)
    put_rescale(group(d, DCM_XRay3DReconstructionSequence), first);
  std::vector<Uint16> pixels;
  for (std::size_t f = 0; f < object.frames.size(); ++f) {
    const Slice& slice = object.frames[f];
    DcmItem* groups = nullptr;
    ASSERT_TRUE(
        d.findOrCreateSequenceItem(DCM_PerFrameFunctionalGroupsSequence, groups, -2).good());
    put(group(*groups, DCM_PlanePositionSequence), DCM_ImagePositionPatient,
        decimals({slice.position.x, slice.position.y, slice.position.z}));
    if (!object.shared_orientation) put_orientation(*groups, slice);
    if (object.rescale == RescaleIn::frame_groups)
      put_rescale(group(*groups, DCM_PixelValueTransformationSequence), slice);
    object.more_groups(*groups, int(f));
    const auto frame_pixels = pixels_of(slice);
    pixels.insert(pixels.end(), frame_pixels.begin(), frame_pixels.end());
  }
  put_pixels(d, first, std::move(pixels));
  object.more(d);
  ASSERT_TRUE(file.saveFile(path.c_str(), syntax).good());
}

/// A folder of a test's own, removed at its end.
class DicomFolder : public testing::Test {
 protected:
  [[nodiscard]] const fs::path& folder() const { return folder_; }
  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

  /// Slices 0.5 mm apart, named in falling z, so that the order of files is not that of slices.
  void write_series(int count, Slice slice = {}, E_TransferSyntax syntax = EXS_LittleEndianExplicit,
                    const std::string& prefix = "a") const {
    const Vec3 normal = cross(slice.axis_i, slice.axis_j);
    const Vec3 first = slice.position;
    for (int k = 0; k < count; ++k) {
      slice.position = first + (0.5 * k) * normal;
      slice.number = k + 1;
      write_slice(file(prefix + std::to_string(100 - k)), slice, syntax);
    }
  }
  [[nodiscard]] std::string refusal(const ReadOptions& options = {}) const {
    return refusal_of(folder_, options);
  }
  static std::string refusal_of(const fs::path& path, const ReadOptions& options = {}) {
    try {
      read_volume(path, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }

 private:
  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

}  // namespace angio::segmentation
