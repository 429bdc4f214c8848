#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/units.hpp"
#include "tests/segmentation/dicom_objects.hpp"

/// Objects that common readers take for something else without a word. Each is read right here, or
/// refused with what to do.
namespace angio::segmentation {
namespace {
using testing::Contains;
using testing::HasSubstr;
using testing::SizeIs;

constexpr double kFieldSlope = 0.01;

/// A field that every interpolation in use gives back exactly.
double field(const Vec3& p) { return 200.0 + 3.0 * p.x - 2.0 * p.y + 5.0 * p.z; }

Vec3 lps_of_pixel(const Slice& slice, int i, int j) {
  return slice.position + (i * slice.spacing_i) * slice.axis_i +
         (j * slice.spacing_j) * slice.axis_j;
}

/// A slice whose pixels hold the field, to 0.005.
Slice field_slice(Slice slice) {
  slice.bits_stored = 16;
  slice.slope = kFieldSlope;
  const Slice at = slice;
  slice.pixel = [at](int i, int j) {
    return int(std::lround(field(lps_of_pixel(at, i, j)) / kFieldSlope));
  };
  return slice;
}

/// Compares a volume with the field, `border` voxels away from its ends in the plane.
void expect_field(const Volume<float>& volume, int border, double tolerance) {
  const auto& size = volume.geometry.size;
  for (int k = 0; k < size[2]; ++k)
    for (int j = border; j < size[1] - border; ++j)
      for (int i = border; i < size[0] - border; ++i)
        ASSERT_NEAR(double(volume.at(i, j, k)),
                    field(volume.geometry.lps_from_index({double(i), double(j), double(k)})),
                    tolerance)
            << i << ' ' << j << ' ' << k;
}

EnhancedObject xray_3d(int count, double step) {
  EnhancedObject object;
  for (int k = 0; k < count; ++k) {
    Slice slice;
    slice.sop_class = UID_XRay3DAngiographicImageStorage;
    slice.position.z = step * k;
    slice.pixel = [k](int i, int j) { return 100 * k + 5 * j + i; };
    object.frames.push_back(slice);
  }
  return object;
}

using DicomTraps = DicomFolder;

TEST_F(DicomTraps, AFrameThatIsTwoMicrometresOffIsRead) {
  for (const char* sop_class : {UID_XRay3DAngiographicImageStorage, UID_EnhancedCTImageStorage,
                                UID_EnhancedMRImageStorage}) {
    EnhancedObject object = xray_3d(6, 0.3);
    for (auto& frame : object.frames) frame.sop_class = sop_class;
    object.frames[2].position.z += 0.002;
    write_enhanced(file("a"), object);
    const auto volume = read_volume(file("a"), {}).volume;
    EXPECT_NEAR(volume.geometry.spacing.z, 0.3, 1e-9);
    EXPECT_NEAR(volume.geometry.spacing.x, 0.4, 1e-12);
    EXPECT_NEAR(volume.geometry.spacing.y, 0.6, 1e-12);
    EXPECT_EQ(volume.at(3, 2, 5), 513.0f);
  }
}

TEST_F(DicomTraps, ReversedAndShuffledFramesLieWhereTheyBelong) {
  for (const bool shared : {true, false}) {
    EnhancedObject object = xray_3d(7, 0.3);
    object.shared_orientation = shared;
    std::reverse(object.frames.begin(), object.frames.end());
    std::swap(object.frames[1], object.frames[5]);
    write_enhanced(file("a"), object);
    const auto volume = read_volume(file("a"), {}).volume;
    EXPECT_NEAR(determinant(volume.geometry.direction), 1.0, 1e-12);
    EXPECT_NEAR(volume.geometry.origin.z, 0.0, 1e-12);
    for (int k = 0; k < 7; ++k) EXPECT_EQ(volume.at(1, 1, k), float(100 * k + 6));
  }
}

TEST_F(DicomTraps, AMultiFrameObjectWithoutAFrameIsRefused) {
  EnhancedObject object = xray_3d(8, 0.3);
  object.frames.erase(object.frames.begin() + 3);
  write_enhanced(file("a"), object);
  EXPECT_THAT(refusal(), HasSubstr("--resample"));
}

TEST_F(DicomTraps, MissingSlicesAreRefusedAndInterpolatedOnRequest) {
  for (const int missing : {1, 5, 6}) {
    fs::remove_all(folder());
    fs::create_directories(folder());
    for (int k = 0; k < 12; ++k) {
      if (k == missing || k == missing + 1) continue;
      Slice slice;
      slice.position.z = 0.5 * k;
      write_slice(file(std::to_string(k)), field_slice(slice));
    }
    EXPECT_THAT(refusal(), HasSubstr("a slice is missing between"));
    EXPECT_FALSE(inspect(folder())[0].usable);
    const auto loaded = read_volume(folder(), {.resample = true});
    EXPECT_EQ(loaded.volume.geometry.size[2], 12);
    EXPECT_NEAR(loaded.volume.geometry.spacing.z, 0.5, 1e-9);
    EXPECT_THAT(loaded.warnings, Contains(HasSubstr("gaps of up to 1.5 mm")));
    expect_field(loaded.volume, 0, 0.02);
  }
}

TEST_F(DicomTraps, UnevenSlicesAreRefusedAndInterpolatedOnRequest) {
  double z = 0.0;
  for (int k = 0; k < 10; ++k, z += k % 2 == 0 ? 0.5 : 0.7) {
    Slice slice;
    slice.position.z = z;
    write_slice(file(std::to_string(k)), field_slice(slice));
  }
  EXPECT_THAT(refusal(), HasSubstr("unevenly spaced"));
  expect_field(read_volume(folder(), {.resample = true}).volume, 0, 0.02);
}

TEST_F(DicomTraps, CopiesOfASliceAreDroppedAndTold) {
  write_series(5);
  fs::copy_file(file("a98"), file("copy"));
  Slice other_uid;
  other_uid.position.z = 0.5;
  other_uid.number = 77;
  write_slice(file("other-uid"), other_uid);
  const auto loaded = read_volume(folder(), {});
  EXPECT_EQ(loaded.volume.geometry.size[2], 5);
  EXPECT_NEAR(loaded.volume.geometry.spacing.z, 0.5, 1e-12);
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("2 slices are copies")));
}

TEST_F(DicomTraps, SlicesThatDifferAtTheSamePlaceAreRefused) {
  write_series(5);
  Slice other;
  other.position.z = 0.5;
  other.number = 77;
  other.pixel = [](int, int) { return 1; };
  write_slice(file("b"), other);
  EXPECT_THAT(refusal(), HasSubstr("repeats a position"));
  other.pixel = [](int i, int j) { return 100 + 5 * j + i; };
  other.slope = 2.0;  // the same stored pixels mean other values
  write_slice(file("b"), other);
  EXPECT_THAT(refusal(), HasSubstr("repeats a position"));
}

TEST_F(DicomTraps, PhasesOfASeriesBecomeSeriesOfTheirOwn) {
  for (const DcmTagKey& tag : {DCM_TemporalPositionIdentifier, DCM_AcquisitionNumber,
                               DCM_EchoNumbers, DCM_AcquisitionTime}) {
    for (int phase = 1; phase <= 3; ++phase) {
      Slice slice;
      slice.pixel = [phase](int, int) { return phase; };
      slice.more = [&](DcmDataset& d) { put(d, tag, "10000" + std::to_string(phase)); };
      write_series(4, slice, EXS_LittleEndianExplicit, "p" + std::to_string(phase));
    }
    const auto all = inspect(folder());
    ASSERT_THAT(all, SizeIs(3));
    for (int phase = 1; phase <= 3; ++phase) {
      EXPECT_TRUE(all[std::size_t(phase - 1)].usable);
      const auto volume = read_volume(folder(), {.series = std::to_string(phase)}).volume;
      EXPECT_NEAR(volume.geometry.spacing.z, 0.5, 1e-12);
      for (float value : volume.values) ASSERT_EQ(value, float(phase));
    }
  }
}

TEST_F(DicomTraps, PhasesWithinOneObjectBecomeSeriesOfTheirOwn) {
  EnhancedObject object = xray_3d(4, 0.3);
  const EnhancedObject second = xray_3d(4, 0.3);
  object.frames.insert(object.frames.end(), second.frames.begin(), second.frames.end());
  object.more_groups = [](DcmItem& groups, int frame) {
    group(groups, DCM_FrameContentSequence)
        .putAndInsertUint32(DCM_TemporalPositionIndex, frame < 4 ? 1 : 2);
  };
  write_enhanced(file("a"), object);
  EXPECT_THAT(inspect(folder()), SizeIs(2));
  EXPECT_EQ(read_volume(folder(), {}).volume.at(1, 1, 3), 306.0f);
}

TEST_F(DicomTraps, GantryTiltIsResampledOntoAnUprightGrid) {
  const Vec3 i = normalized(Vec3{0.9, 0.3, 0.1});
  const Vec3 j = normalized(cross(Vec3{0.1, 0.2, 0.9}, i));
  const Vec3 n = cross(i, j);
  for (const double degrees : {-24.0, 7.5}) {
    const double slope = std::tan(degrees * units::kPi / 180.0);
    for (int k = 0; k < 8; ++k) {
      Slice slice;
      slice.rows = slice.columns = 48;
      slice.axis_i = i;
      slice.axis_j = j;
      slice.position = Vec3{5, 6, 7} + (0.8 * k) * (n + slope * j + 0.05 * i);
      write_slice(file(std::to_string(k)), field_slice(slice));
    }
    const auto loaded = read_volume(folder(), {});
    const auto& g = loaded.volume.geometry;
    EXPECT_NEAR(g.spacing.z, 0.8, 1e-6);
    EXPECT_NEAR(determinant(g.direction), 1.0, 1e-12);
    EXPECT_NEAR(dot(Vec3{g.direction(0, 2), g.direction(1, 2), g.direction(2, 2)}, n), 1.0, 1e-9);
    EXPECT_GT(g.size[1], 48);
    EXPECT_THAT(loaded.warnings, Contains(HasSubstr("gantry tilt")));
    const auto listed = inspect(folder());
    EXPECT_TRUE(listed[0].usable && listed[0].resampled);
    EXPECT_NEAR(std::tan(listed[0].tilt_degrees * units::kPi / 180.0), std::hypot(slope, 0.05),
                1e-4);
    // Beyond the ends of a slice the spline is only mirrored: its error falls fourfold per pixel.
    expect_field(loaded.volume, 17, 0.02);
  }
}

TEST_F(DicomTraps, AHeaderThatTiltsBeyondAnyGantryIsRefused) {
  for (int k = 0; k < 8; ++k) {
    Slice slice;
    slice.position = {-1, 3.0 * k, 0.8 * k};
    write_slice(file(std::to_string(k)), slice);
  }
  EXPECT_THAT(refusal(), HasSubstr("no gantry tilts so far"));
}

TEST_F(DicomTraps, RescaleIsFoundWhereverItIsKept) {
  for (const RescaleIn place :
       {RescaleIn::shared_groups, RescaleIn::frame_groups, RescaleIn::reconstruction}) {
    EnhancedObject object = xray_3d(3, 0.3);
    object.rescale = place;
    for (auto& frame : object.frames) {
      frame.slope = 2.0;
      frame.intercept = -500.0;
    }
    if (place == RescaleIn::frame_groups) object.frames[2].slope = 4.0;
    write_enhanced(file("a"), object);
    const auto volume = read_volume(file("a"), {}).volume;
    EXPECT_EQ(volume.at(1, 1, 1), 2.0f * 106.0f - 500.0f);
    EXPECT_EQ(volume.at(1, 1, 2),
              (place == RescaleIn::frame_groups ? 4.0f : 2.0f) * 206.0f - 500.0f);
  }
}

TEST_F(DicomTraps, BurnedInTextIsTold) {
  Slice slice;
  slice.more = [](DcmDataset& d) { put(d, DCM_BurnedInAnnotation, "YES"); };
  write_series(3, slice);
  EXPECT_THAT(read_volume(folder(), {}).warnings, Contains(HasSubstr("text is burned")));
}

TEST_F(DicomTraps, ALocaliserInTheSeriesIsASeriesOfItsOwn) {
  write_series(4);
  Slice localiser;
  localiser.axis_j = {0, 0, -1};
  localiser.rows = localiser.columns = 20;
  write_slice(file("z"), localiser);
  const auto loaded = read_volume(folder(), {});
  EXPECT_EQ(loaded.volume.geometry.size, (std::array<int, 3>{5, 6, 4}));
  const auto all = inspect(folder());
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_THAT(loaded.warnings, SizeIs(1));
}

TEST_F(DicomTraps, WithoutGeometryTheUserMayStateTheVoxelSize) {
  Slice slice;
  slice.has_geometry = false;
  for (int k = 0; k < 4; ++k) {
    slice.number = k + 3;
    slice.pixel = [k](int, int) { return 10 * k; };
    write_slice(file(std::string(1, char('z' - k))), slice);
  }
  EXPECT_THAT(refusal(), HasSubstr("--spacing"));
  const auto loaded = read_volume(folder(), {.spacing_mm = {0.3, 0.4, 0.7}});
  EXPECT_NEAR(distance(loaded.volume.geometry.spacing, {0.3, 0.4, 0.7}), 0.0, 1e-12);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(loaded.volume.at(0, 0, k), float(10 * k));
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("every length rests on that")));

  slice.number = 9;  // 7 and 8 are missing
  write_slice(file("gap"), slice);
  EXPECT_THAT(refusal({.spacing_mm = {0.3, 0.4, 0.7}}),
              HasSubstr("not numbered one after another"));
}

TEST_F(DicomTraps, AStatedVoxelSizeNeverOverrulesTheFile) {
  write_series(4);
  EXPECT_THAT(refusal({.spacing_mm = {0.4, 0.6, 0.7}}), HasSubstr("Leave --spacing out"));
  EXPECT_NO_THROW(read_volume(folder(), {.spacing_mm = {0.4, 0.6, 0.5}}));
}

TEST_F(DicomTraps, AMultiFrameSecondaryCaptureHasNoThirdAxis) {
  Slice slice;
  slice.sop_class = UID_MultiframeGrayscaleWordSecondaryCaptureImageStorage;
  slice.rows = 18;  // three frames of six rows
  slice.more = [](DcmDataset& d) {
    put(d, DCM_NumberOfFrames, "3");
    d.putAndInsertUint16(DCM_Rows, 6);
  };
  slice.has_geometry = false;
  write_slice(file("a"), slice);
  EXPECT_THAT(refusal(), HasSubstr("secondary capture without geometry"));
  slice.has_geometry = true;  // one position for all frames is none for the third axis
  write_slice(file("a"), slice);
  EXPECT_FALSE(refusal().empty());
}

TEST_F(DicomTraps, FramesOfDifferentOrientationsAreDifferentStacks) {
  EnhancedObject object = xray_3d(4, 0.3);
  object.shared_orientation = false;
  for (int k = 0; k < 3; ++k) {
    Slice turned = object.frames[0];
    turned.axis_j = {0, 0, 1};
    turned.position.y = -0.3 * k;
    object.frames.push_back(turned);
  }
  write_enhanced(file("a"), object);
  const auto all = inspect(folder());
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_TRUE(all[0].usable && all[1].usable);
  EXPECT_EQ(all[0].geometry.size[2], 4);
  EXPECT_EQ(read_volume(folder(), {}).volume.at(1, 1, 3), 306.0f);
}

TEST_F(DicomTraps, EnhancedObjectsOfOneFrameEachFormAStack) {
  for (int k = 0; k < 5; ++k) {
    EnhancedObject object = xray_3d(1, 0.3);
    object.frames[0].position.z = 0.3 * k;
    write_enhanced(file(std::to_string(9 - k)), object);
  }
  const auto volume = read_volume(folder(), {}).volume;
  EXPECT_EQ(volume.geometry.size[2], 5);
  EXPECT_NEAR(volume.geometry.spacing.z, 0.3, 1e-9);
}

TEST_F(DicomTraps, PaletteColoursAreNoIntensities) {
  Slice slice;
  slice.photometric = "PALETTE COLOR";
  write_series(3, slice);
  EXPECT_THAT(refusal(), HasSubstr("in colour"));
}

TEST_F(DicomTraps, AnOverlayInTheUnusedBitsIsNoIntensity) {
  Slice slice;
  slice.more = [&](DcmDataset& d) {
    std::vector<Uint16> pixels = pixels_of(slice);
    for (std::size_t p = 0; p < pixels.size(); p += 2) pixels[p] = Uint16(pixels[p] | 0xf000);
    d.putAndInsertUint16Array(DCM_PixelData, pixels.data(), pixels.size());
  };
  write_series(3, slice);
  EXPECT_EQ(read_volume(folder(), {}).volume.at(0, 0, 0), 100.0f);
}

TEST_F(DicomTraps, APaddedRimTakesTheLowestValue) {
  Slice slice;
  slice.pixel = [](int i, int j) { return i == 0 ? 4000 + j % 3 : 50 + i; };
  slice.more = [](DcmDataset& d) {
    d.putAndInsertUint16(DCM_PixelPaddingValue, 4000);
    d.putAndInsertUint16(DCM_PixelPaddingRangeLimit, 4002);
  };
  write_series(3, slice);
  const auto volume = read_volume(folder(), {}).volume;
  EXPECT_EQ(volume.at(0, 0, 0), 51.0f);
  EXPECT_EQ(volume.at(0, 2, 1), 51.0f);
  EXPECT_EQ(volume.at(2, 2, 1), 52.0f);
}

TEST_F(DicomTraps, EightBitAndSignedPixelsAreRead) {
  Slice slice;
  slice.bits_allocated = slice.bits_stored = 8;
  write_series(3, slice);
  EXPECT_EQ(read_volume(folder(), {}).volume.at(2, 1, 0), 107.0f);
  slice.is_signed = true;
  slice.pixel = [](int i, int) { return i - 2; };
  write_series(3, slice);
  EXPECT_EQ(read_volume(folder(), {}).volume.at(0, 0, 0), -2.0f);
}

TEST_F(DicomTraps, ClassicMrIsReadLikeCt) {
  Slice slice;
  slice.sop_class = UID_MRImageStorage;
  write_series(4, slice);
  EXPECT_EQ(read_volume(folder(), {}).source_description, "MR Image Storage, 4 slices");
}

TEST_F(DicomTraps, OnlyAScanWhoseBodyPartIsTheHeartIsSaidToBeOfIt) {
  for (const std::string part : {"HEART", "CORONARYARTERY", "HEAD"}) {
    Slice slice;
    slice.more = [&](DcmDataset& dataset) { put(dataset, DCM_BodyPartExamined, part); };
    write_series(4, slice);
    const std::string told = read_volume(folder(), {}).source_description;
    EXPECT_EQ(told.ends_with(" slices, of the heart"), part != "HEAD") << told;
  }
}

}  // namespace
}  // namespace angio::segmentation
