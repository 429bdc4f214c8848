#include <dcmtk/dcmdata/dcrlerp.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "formats/nrrd.hpp"
#include "segmentation/read_run.hpp"
#include "tests/segmentation/dicom_encoders.hpp"
#include "tests/segmentation/dicom_objects.hpp"
#include "tests/segmentation/tiff_stack.hpp"

// Files of rotational runs: which are taken, and why others are not.
namespace angio::segmentation {
namespace {
using testing::Contains;
using testing::HasSubstr;

constexpr int kFrames = 5, kRows = 6;

std::vector<double> times(double step, int count = kFrames) {
  std::vector<double> values;
  for (int f = 0; f < count; ++f) values.push_back(step * f);
  return values;
}

/// A run of five frames over 200 degrees, with what `change` changes.
Slice run_object(const std::function<void(DcmDataset&)>& change = [](DcmDataset&) {}) {
  Slice slice;
  slice.sop_class = UID_XRayAngiographicImageStorage;
  slice.has_geometry = false;
  slice.rows = kFrames * kRows;
  slice.more = [change](DcmDataset& d) {
    put(d, DCM_NumberOfFrames, std::to_string(kFrames));
    d.putAndInsertUint16(DCM_Rows, kRows);
    put(d, DCM_PositionerMotion, "DYNAMIC");
    put(d, DCM_PositionerPrimaryAngle, "-100");
    put(d, DCM_PositionerSecondaryAngle, "0");
    put(d, DCM_PositionerPrimaryAngleIncrement, decimals(times(50.0)));
    put(d, DCM_DistanceSourceToDetector, "1200");
    put(d, DCM_DistanceSourceToPatient, "800");
    put(d, DCM_ImagerPixelSpacing, "0.3\\0.3");
    put(d, DCM_PixelIntensityRelationship, "LIN");
    change(d);
  };
  return slice;
}

class RotationalFiles : public DicomFolder {
 protected:
  /// Why the run that is changed like that is refused.
  std::string refusal_of(const std::function<void(DcmDataset&)>& change) {
    write_slice(file("run"), run_object(change));
    try {
      return read_run(folder(), {}) ? "it was taken" : "it is no run";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
  }
};

TEST_F(RotationalFiles, AreTakenWithTheirAnglesAndDistances) {
  write_slice(file("run"), run_object());
  const auto loaded = read_run(folder(), {});
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->frame_count, kFrames);
  EXPECT_EQ(loaded->run.primary_angles_degrees, (std::vector<double>{-100, -50, 0, 50, 100}));
  EXPECT_EQ(loaded->run.source_to_detector_mm, 1200.0);
  EXPECT_EQ(loaded->pictures->read(1, 2).size(), 2u * kRows * 5u);
}

TEST_F(RotationalFiles, WithASignOfMinusOneAreInvertedHoweverTheyAreShown) {
  const auto pixels = [&](const char* name, const std::function<void(DcmDataset&)>& change) {
    write_slice(file(name), run_object(change));
    const auto loaded = read_run(file(name), {});
    return loaded ? loaded->pictures->read(0, 1) : std::vector<float>();
  };
  const auto sign = [](int value) {
    return [=](DcmDataset& d) {
      d.putAndInsertSint16(DCM_PixelIntensityRelationshipSign, Sint16(value));
    };
  };
  const std::vector<float> as_stored = pixels("plain", [](DcmDataset&) {});
  EXPECT_EQ(pixels("plus", sign(1)), as_stored);
  EXPECT_EQ(
      pixels("shown", [](DcmDataset& d) { put(d, DCM_PhotometricInterpretation, "MONOCHROME1"); }),
      as_stored);
  const std::vector<float> inverted = pixels("minus", sign(-1));
  ASSERT_EQ(inverted.size(), as_stored.size());
  for (std::size_t p = 0; p < inverted.size(); ++p)
    EXPECT_EQ(inverted[p] + as_stored[p], inverted[0] + as_stored[0]);
  EXPECT_NE(inverted, as_stored);
}

TEST_F(RotationalFiles, ThatCannotGiveAVolumeAreRefusedWithTheReason) {
  EXPECT_THAT(refusal_of([](DcmDataset& d) { put(d, DCM_PositionerMotion, "STATIC"); }),
              HasSubstr("its header contradicts itself"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) { put(d, DCM_DistanceSourceToDetector, "700"); }),
              HasSubstr("nearer to the source than its isocentre (700 and 800 mm"));
  EXPECT_THAT(
      refusal_of([](DcmDataset& d) { d.findAndDeleteElement(DCM_DistanceSourceToPatient); }),
      HasSubstr("does not state its distances"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) { d.findAndDeleteElement(DCM_ImagerPixelSpacing); }),
              HasSubstr("pixel spacing"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) {
                put(d, DCM_TableLongitudinalIncrement, decimals(times(10.0)));
              }),
              HasSubstr("the table moves by 40 mm"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) {
                put(d, DCM_PositionerPrimaryAngleIncrement, decimals(times(50.0, 4)));
              }),
              HasSubstr("4 angles for 5 frames"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) {
                put(d, DCM_PositionerPrimaryAngleIncrement, decimals(times(7.0)));
              }),
              HasSubstr("turns by 28 degrees"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) {
                put(d, DCM_PositionerPrimaryAngleIncrement, "0\\30\\30\\30\\30");
              }),
              HasSubstr("add up to 120 degrees: where they are steps"));
  EXPECT_THAT(refusal_of([](DcmDataset& d) { put(d, DCM_FieldOfViewRotation, "45"); }),
              HasSubstr("field of view is turned by 45 degrees"));
}

/// A stack of frames whose header has its first pixel somewhere.
LoadedRun stack_with_origin(const std::filesystem::path& file, const Vec3& origin) {
  Volume<float> stack;
  stack.geometry.size = {8, 6, 4};
  stack.geometry.spacing = {0.5, 0.4, 1.0};
  stack.geometry.origin = origin;
  stack.values.assign(8 * 6 * 4, 1.0F);
  formats::write_nrrd(file, stack);
  return *read_run(file, {}, RunGeometry::given);
}

TEST_F(RotationalFiles, StacksLieOnTheDetectorWhereTheirHeaderSays) {
  const auto file = folder() / "stack.nrrd";
  // In the middle, and where nothing is said.
  EXPECT_FALSE(stack_with_origin(file, {-1.75, -1.0, 0.0}).first_pixel_mm);
  EXPECT_FALSE(stack_with_origin(file, {0.0, 0.0, 0.0}).first_pixel_mm);
  const LoadedRun off = stack_with_origin(file, {3.0, -2.0, 0.0});
  ASSERT_TRUE(off.first_pixel_mm);
  EXPECT_NEAR((*off.first_pixel_mm)[0], 3.0, 1e-9);
  EXPECT_NEAR((*off.first_pixel_mm)[1], -2.0, 1e-9);
}

TEST_F(RotationalFiles, TiffStacksNeedNoSpacingButDoNotMakeOneUp) {
  const auto file = folder() / "stack.tif";
  std::ofstream(file, std::ios::binary) << tests::tiff_stack(6, 5, 4);
  const LoadedRun bare = *read_run(file, {}, RunGeometry::given);
  EXPECT_EQ(bare.frame_count, 4);
  EXPECT_EQ(bare.run.detector_spacing_mm[0], 0.0);
  EXPECT_EQ(bare.pictures->read(2, 1)[7], 2011.0F);
  ReadOptions options;
  options.spacing_mm = {0.3, 0.3, 1.0};
  EXPECT_EQ(read_run(file, options, RunGeometry::given)->run.detector_spacing_mm[0], 0.3);
}

TEST_F(RotationalFiles, OfTwoFramesAreRefused) {
  EXPECT_THAT(refusal_of([](DcmDataset& d) {
                put(d, DCM_NumberOfFrames, "2");
                put(d, DCM_PositionerPrimaryAngleIncrement, "0\\100");
              }),
              HasSubstr("the run has 2 frames"));
}

/// Without angles, or with frames from one side, a run is a film.
TEST_F(RotationalFiles, ThatDoNotTurnAreNoRotationalRuns) {
  const auto without_angles = [](DcmDataset& d) {
    d.findAndDeleteElement(DCM_PositionerPrimaryAngle);
    d.findAndDeleteElement(DCM_PositionerPrimaryAngleIncrement);
  };
  EXPECT_EQ(refusal_of(without_angles), "it is no run");
  EXPECT_THAT(refusal(), HasSubstr("does not say that it turns"));
  EXPECT_EQ(refusal_of([](DcmDataset& d) {
              put(d, DCM_PositionerPrimaryAngleIncrement, decimals(times(0.0)));
            }),
            "it is no run");
}

TEST_F(RotationalFiles, CutInTheirPixelsAreSaidToBe) {
  write_slice(file("run"), run_object());
  fs::resize_file(file("run"), fs::file_size(file("run")) - 100);
  EXPECT_FALSE(read_run(folder(), {}));
  EXPECT_THAT(refusal(), HasSubstr("it ends within its pixels"));
}

/// Two planes of one series are two runs; neither is the other's mask.
TEST_F(RotationalFiles, OfTwoPlanesAreTakenPlaneByPlane) {
  Slice other = run_object([](DcmDataset& d) { put(d, DCM_PositionerPrimaryAngle, "-10"); });
  other.number = 2;
  write_slice(file("a"), run_object([](DcmDataset& d) { put(d, DCM_ContrastBolusAgent, "any"); }));
  write_slice(file("b"), other);
  for (const auto& [series, first_angle] : {std::pair{"1", -100.0}, std::pair{"2", -10.0}}) {
    ReadOptions options;
    options.series = series;
    const auto loaded = read_run(folder(), options);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(loaded->run.primary_angles_degrees.front(), first_angle);
    EXPECT_FALSE(loaded->masks);
  }
}

/// Two runs over the same path, each with a vessel in its column; -1: none.
void write_alike(const std::function<void(const char*, const Slice&)>& write, int in_first,
                 int in_second, const char* medium) {
  for (const auto& [name, number, column] :
       {std::tuple{"a", 1, in_first}, std::tuple{"b", 2, in_second}}) {
    Slice slice = run_object([medium](DcmDataset& d) {
      if (*medium != '\0') put(d, DCM_ContrastBolusAgent, medium);
    });
    slice.series += std::to_string(number);
    slice.number = number;
    slice.pixel = [column = column, number = number](int i, int j) {
      return (i == column ? 50 : 100) + (i + 2 * j + number) % 3;
    };
    write(name, slice);
  }
}

/// Anonymisers take the medium's name away, and some exports give it to both.
TEST_F(RotationalFiles, OfARunAndItsMaskTheFilledOneIsToldByItsPixels) {
  const auto write = [&](const char* name, const Slice& slice) { write_slice(file(name), slice); };
  for (const char* medium : {"", "Iodine"})
    for (const auto& [first, second] : {std::pair{2, -1}, std::pair{-1, 2}}) {
      write_alike(write, first, second, medium);
      const auto loaded = read_run(folder(), {});
      ASSERT_TRUE(loaded);
      ASSERT_TRUE(loaded->masks) << first;
      EXPECT_LT(loaded->pictures->read(0, 1)[2], 60.0F) << first;
      EXPECT_GT(loaded->masks->read(0, 1)[2], 90.0F) << first;
      EXPECT_THAT(loaded->warnings, Contains(HasSubstr("taken for the run's mask, by its pixels")));
    }
}

TEST_F(RotationalFiles, OfTwoVesselsNeitherIsTheOthersMask) {
  write_alike([&](const char* name, const Slice& slice) { write_slice(file(name), slice); }, 1, 3,
              "Iodine");
  const auto loaded = read_run(folder(), {});
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->masks);
}

/// Every pixel of a frame differs from those of the others.
std::vector<float> frame(const RunPictures& pictures, int index) { return pictures.read(index, 1); }

void expect_frames(const RunPictures& pictures, const std::vector<std::vector<float>>& expected,
                   int first, int count) {
  const std::vector<float> all = pictures.read(first, count);
  const std::size_t size = expected.front().size();
  ASSERT_EQ(all.size(), size * std::size_t(count));
  for (int n = 0; n < count; ++n)
    EXPECT_TRUE(std::equal(all.begin() + n * std::ptrdiff_t(size),
                           all.begin() + (n + 1) * std::ptrdiff_t(size),
                           expected[std::size_t(first + n)].begin()))
        << "frame " << first + n;
}

/// Alone, one after the other, some at a time, from anywhere, from the beginning again.
TEST_F(RotationalFiles, GiveTheSameFramesInAnyOrder) {
  for (const int bits : {8, 12})
    for (const bool is_compressed : {false, true}) {
      Slice slice = run_object();
      slice.bits_allocated = bits == 8 ? 8 : 16;
      slice.bits_stored = bits;
      slice.columns = 4;
      slice.pixel = [](int i, int j) { return 8 * j + i; };
      write_slice(file("run"), slice);
      if (is_compressed) {
        const Encoders encoders;
        const DcmRLERepresentationParameter rle;
        recode(file("run"), EXS_RLELossless, &rle);
      }
      const auto loaded = read_run(folder(), {});
      ASSERT_TRUE(loaded);
      const RunPictures& pictures = *loaded->pictures;
      std::vector<std::vector<float>> expected;
      for (int f = 0; f < kFrames; ++f) {
        std::vector<float> pixels;
        for (int j = f * kRows; j < (f + 1) * kRows; ++j)
          for (int i = 0; i < 4; ++i) pixels.push_back(float(slice.pixel(i, j)));
        expected.push_back(pixels);
      }
      for (const int f : {3, 0, 4, 0, 1}) EXPECT_EQ(frame(pictures, f), expected[std::size_t(f)]);
      for (int f = 0; f + 2 <= kFrames; f += 2) expect_frames(pictures, expected, f, 2);
      EXPECT_EQ(frame(pictures, 4), expected[4]);  // follows
      expect_frames(pictures, expected, 1, 3);
      expect_frames(pictures, expected, 0, kFrames);
      expect_frames(pictures, expected, 2, 2);  // is left half read
    }
}

}  // namespace
}  // namespace angio::segmentation
