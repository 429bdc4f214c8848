#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "segmentation/detail/dicom_pictures.hpp"
#include "segmentation/detail/dicom_series.hpp"
#include "segmentation/detail/open_shapes.hpp"
#include "segmentation/detail/projection_angles.hpp"
#include "tests/segmentation/dicom_objects.hpp"

namespace angio::segmentation {
namespace {
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using ProjectionRuns = DicomFolder;

/// A cine of four frames with what `more` adds.
Slice run_of_four(const std::function<void(DcmDataset&)>& more) {
  Slice slice;
  slice.sop_class = UID_XRayAngiographicImageStorage;
  slice.has_geometry = false;
  slice.rows = 24;
  slice.more = [more](DcmDataset& d) {
    put(d, DCM_NumberOfFrames, "4");
    d.putAndInsertUint16(DCM_Rows, 6);
    put(d, DCM_FrameTime, "40");
    more(d);
  };
  return slice;
}

ProjectionRun inspect_run(const fs::path& folder, const ReadOptions& options = {}) {
  const auto all = inspect(folder, options);
  EXPECT_EQ(all.size(), 1u);
  EXPECT_FALSE(all[0].usable);
  EXPECT_TRUE(all[0].projection);
  return all[0].projection.value_or(ProjectionRun{});
}

TEST_F(ProjectionRuns, AreNamedForWhatTheyAre) {
  write_slice(file("a"), run_of_four([](DcmDataset&) {}));
  EXPECT_THAT(refusal(), HasSubstr("it is a projection run (X-Ray Angiographic Image Storage), not "
                                   "a volume: its third axis is time"));
  const auto all = inspect(folder());
  EXPECT_EQ(all[0].frame_count, 4);
  EXPECT_EQ(all[0].projection->frame_time_ms, 40.0);
  EXPECT_EQ(all[0].projection->spacing_plane, SpacingPlane::unknown);
}

TEST_F(ProjectionRuns, TellThePlaneInWhichTheirSpacingHolds) {
  const auto spacing = [&](const std::function<void(DcmDataset&)>& more) {
    write_slice(file("a"), run_of_four(more));
    return inspect_run(folder());
  };
  const auto detector_only = [](DcmDataset& d) { put(d, DCM_ImagerPixelSpacing, "0.4\\0.3"); };
  auto run = spacing(detector_only);
  EXPECT_EQ(run.spacing_plane, SpacingPlane::detector);
  EXPECT_THAT(run.spacing_mm, ElementsAre(0.3, 0.4));

  const auto with_distances = [&](DcmDataset& d) {
    detector_only(d);
    put(d, DCM_DistanceSourceToDetector, "1000");
    put(d, DCM_DistanceSourceToPatient, "750");
  };
  run = spacing(with_distances);
  EXPECT_EQ(run.spacing_plane, SpacingPlane::isocentre);
  EXPECT_NEAR(run.spacing_mm[0], 0.3 * 750 / 1000, 1e-12);
  EXPECT_NEAR(run.magnification.value_or(0), 1000.0 / 750.0, 1e-12);

  run = spacing([&](DcmDataset& d) {  // a finer spacing was calibrated
    with_distances(d);
    put(d, DCM_PixelSpacing, "0.25\\0.2");
  });
  EXPECT_EQ(run.spacing_plane, SpacingPlane::calibrated);
  EXPECT_THAT(run.spacing_mm, ElementsAre(0.2, 0.25));

  run = spacing([&](DcmDataset& d) {  // the same one was copied
    with_distances(d);
    put(d, DCM_PixelSpacing, "0.4\\0.3");
  });
  EXPECT_EQ(run.spacing_plane, SpacingPlane::isocentre);

  run = spacing([](DcmDataset& d) { put(d, DCM_PixelSpacing, "0.4\\0.3"); });
  EXPECT_EQ(run.spacing_plane, SpacingPlane::unknown);
}

TEST_F(ProjectionRuns, OfSiemensTakeTheirOwnIsocentreDistance) {
  const auto distance = [&](const char* creator, const char* value) {
    write_slice(file("a"), run_of_four([&](DcmDataset& d) {
                  put(d, DCM_DistanceSourceToPatient, "800");
                  d.putAndInsertString(DcmTag(0x0021, 0x0010, EVR_LO), creator);
                  d.putAndInsertString(DcmTag(0x0021, 0x1017, EVR_DS), value);
                }));
    return inspect_run(folder()).source_to_isocentre_mm;
  };
  EXPECT_EQ(distance("SIEMENS MED SMS-AX  ORIGINAL IMAGE INFO 1.0", "750"), 750.0);
  EXPECT_EQ(distance("SIEMENS MED SMS-AX  ORIGINAL IMAGE INFO 1.0", "7"), 800.0);
  EXPECT_EQ(distance("ANOTHER MAKER", "750"), 800.0);
}

TEST_F(ProjectionRuns, AMagnificationThatContradictsTheDistancesIsTold) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                put(d, DCM_DistanceSourceToDetector, "1000");
                put(d, DCM_DistanceSourceToPatient, "750");
                put(d, DCM_EstimatedRadiographicMagnificationFactor, "1.2");
              }));
  const auto run = inspect_run(folder());
  EXPECT_NEAR(run.magnification.value_or(0), 4.0 / 3.0, 1e-12);
  EXPECT_THAT(run.notes, Contains(HasSubstr("is not that of the distances")));
}

TEST_F(ProjectionRuns, ThatTurnAreRefusedForTheirPixelsWhereThoseCannotBeRead) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                put(d, DCM_PositionerPrimaryAngle, "-90");
                put(d, DCM_PositionerPrimaryAngleIncrement, "0\\60\\120\\180");
                d.putAndInsertUint16(DCM_BitsStored, 30);
              }));
  EXPECT_THAT(refusal(), HasSubstr("the pixel format is not supported (16 bits allocated, 30"));
  EXPECT_FALSE(inspect(folder())[0].is_rotational);
}

TEST_F(ProjectionRuns, AnglesAreBasePlusIncrementAndNoRunningSum) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                put(d, DCM_PositionerPrimaryAngle, "-30");
                put(d, DCM_PositionerSecondaryAngle, "5");
                put(d, DCM_PositionerPrimaryAngleIncrement, "0\\10\\20\\30");
              }));
  const auto run = inspect_run(folder());
  EXPECT_THAT(run.primary_angles_degrees, ElementsAre(-30, -20, -10, 0));
  EXPECT_THAT(run.secondary_angles_degrees, ElementsAre(5));
}

TEST_F(ProjectionRuns, IncrementsThatAreAllAlikeAskForTheOtherMeaning) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                put(d, DCM_PositionerPrimaryAngle, "-30");
                put(d, DCM_PositionerPrimaryAngleIncrement, "2\\2\\2\\2");
              }));
  EXPECT_THAT(inspect_run(folder()).notes, Contains(HasSubstr("--angles cumulative")));
  const auto run = inspect_run(folder(), {.angles = AngleIncrements::cumulative});
  EXPECT_THAT(run.primary_angles_degrees, ElementsAre(-28, -26, -24, -22));
}

TEST_F(ProjectionRuns, ImplausibleAnglesAreTold) {
  const auto notes = [](std::vector<double> angles, int frames) {
    ProjectionRun run;
    run.primary_angles_degrees = std::move(angles);
    run.secondary_angles_degrees = {0.0};
    detail::settle_angles(run, frames, AngleIncrements::from_base);
    return run.notes;
  };
  EXPECT_THAT(notes({-30, -20, -10, 0}, 4), IsEmpty());
  EXPECT_THAT(notes({-30, -20, -10}, 4), Contains(HasSubstr("3 for 4 frames")));
  EXPECT_THAT(notes({0, 200, 400}, 3), Contains(HasSubstr("more than a turn")));
  EXPECT_THAT(notes({0, 20, 10, 30}, 4), Contains(HasSubstr("back and forth")));
  EXPECT_THAT(notes({0, 10, 20, 70, 80}, 5), Contains(HasSubstr("uneven")));
}

TEST_F(ProjectionRuns, MaskFramesAndTheOpenFieldAreShown) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                DcmItem& mask = group(d, DCM_MaskSubtractionSequence);
                put(mask, DCM_MaskOperation, "AVG_SUB");
                const Uint16 frames[] = {1, 2};
                mask.putAndInsertUint16Array(DCM_MaskFrameNumbers, frames, 2);
                put(d, DCM_ShutterLeftVerticalEdge, "2");
                put(d, DCM_ShutterRightVerticalEdge, "5");
                put(d, DCM_CollimatorUpperHorizontalEdge, "3");
                put(d, DCM_CollimatorLowerHorizontalEdge, "9");
              }));
  const auto run = inspect_run(folder());
  EXPECT_EQ(run.mask_operation, "AVG_SUB");
  EXPECT_THAT(run.mask_frames, ElementsAre(1, 2));
  ASSERT_TRUE(run.open_field);
  EXPECT_THAT(*run.open_field, ElementsAre(2, 5, 3, 6));
}

TEST_F(ProjectionRuns, OfRoundAndPolygonalShuttersTellTheRectangleAroundWhatIsOpen) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                put(d, DCM_CenterOfCircularShutter, "3\\4");  // row, column
                put(d, DCM_RadiusOfCircularShutter, "2");
              }));
  auto run = inspect_run(folder());
  ASSERT_TRUE(run.open_field);
  EXPECT_THAT(*run.open_field, ElementsAre(2, 5, 1, 5));  // of five columns
  EXPECT_EQ(run.open_shapes.size(), 1U);
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                put(d, DCM_VerticesOfThePolygonalCollimator, "2\\1\\5\\3\\2\\5");
              }));
  run = inspect_run(folder());
  ASSERT_TRUE(run.open_field);
  EXPECT_THAT(*run.open_field, ElementsAre(1, 5, 2, 5));
  EXPECT_THAT(run.open_shapes, ElementsAre(ElementsAre(1, 2, 3, 5, 5, 2)));
}

TEST_F(ProjectionRuns, ShapesThatCannotBeMeantLeaveTheRectangle) {
  std::string many = "1";
  for (int n = 1; n < 2100; ++n) many += "\\" + std::to_string(1 + n % 5);
  for (const auto& [tag, value] : {std::pair{DCM_CenterOfCircularShutter, std::string("90\\90")},
                                   std::pair{DCM_VerticesOfThePolygonalShutter, many}}) {
    write_slice(file("a"), run_of_four([&](DcmDataset& d) {
                  put(d, DCM_ShutterLeftVerticalEdge, "2");
                  put(d, DCM_RadiusOfCircularShutter, "2");
                  put(d, tag, value.c_str());
                }));
    const auto run = inspect_run(folder());
    ASSERT_TRUE(run.open_field) << value.substr(0, 9);
    EXPECT_THAT(*run.open_field, ElementsAre(2, 5, 1, 6)) << value.substr(0, 9);
  }
}

TEST_F(ProjectionRuns, BehindARoundShutterShowTheNearestOpenPixel) {
  const auto first_frame = [&](const char* radius) {
    write_slice(file("a"), run_of_four([&](DcmDataset& d) {
                  put(d, DCM_CenterOfCircularShutter, "3\\3");
                  put(d, DCM_RadiusOfCircularShutter, radius);
                }));
    const detail::FoundSeries found = detail::find_series(folder(), {});
    const detail::DicomPictures pictures(found.all.at(0).headers.at(0));
    EXPECT_EQ(pictures.read(0, 2), pictures.read_some({0, 1}));
    const std::vector<char> covered = pictures.covered();
    EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), std::string(radius) == "2" ? 17 : 0);
    return pictures.read(0, 1);
  };
  const std::vector<float> all = first_frame("20"), shown = first_frame("2");
  const std::vector<int> from = detail::open_pixels({detail::circle_corners(3, 3, 2)}, 5, 6);
  ASSERT_EQ(all.size(), from.size());
  ASSERT_NE(all, shown);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(shown[i], all[std::size_t(from[i])]);
}

TEST(OpenPixels, AreTheirOwnAndGiveTheCoveredTheNearestOnesValue) {
  constexpr int kColumns = 60, kRows = 50;
  const double column = 28.0, row = 27.0, radius = 20.0;
  const std::vector<int> from =
      detail::open_pixels({detail::circle_corners(column, row, radius)}, kColumns, kRows);
  ASSERT_EQ(from.size(), std::size_t(kColumns * kRows));
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) {
      const int source = from[std::size_t(r * kColumns + c)];
      const double away = std::hypot(c + 1 - column, r + 1 - row);
      if (away <= radius) {
        EXPECT_EQ(source, r * kColumns + c);
      }
      if (away <= radius + 0.1) continue;
      EXPECT_LE(std::hypot(source % kColumns + 1 - column, source / kColumns + 1 - row),
                radius + 0.1);
      EXPECT_LT(std::hypot(source % kColumns - c, source / kColumns - r), away - radius + 1.0);
    }
}

/// Whether a pixel, counted from 1, lies in a polygon of whole corners, or on its border: exactly.
bool holds(const std::vector<double>& corners, long long column, long long row) {
  bool inside = false;
  const std::size_t count = corners.size() / 2;
  for (std::size_t a = 0, b = count - 1; a < count; b = a++) {
    const auto ax = (long long)corners[2 * a], ay = (long long)corners[2 * a + 1],
               bx = (long long)corners[2 * b], by = (long long)corners[2 * b + 1];
    const long long side = (bx - ax) * (row - ay) - (by - ay) * (column - ax);
    if (side == 0 && std::min(ax, bx) <= column && column <= std::max(ax, bx) &&
        std::min(ay, by) <= row && row <= std::max(ay, by))
      return true;
    if ((ay > row) != (by > row) && (side > 0) == (by > ay)) inside = !inside;
  }
  return inside;
}

TEST(OpenPixels, AreThoseWithinAllPolygonsAndOnTheirBorders) {
  constexpr int kColumns = 40, kRows = 30;
  const std::vector<double> star{20, 2, 30, 28, 3, 11, 38, 11, 9, 28},  // crosses itself
      steps{2, 3, 18, 3, 18, 9, 36, 9, 36, 25, 25, 25, 25, 18, 2, 18}, spike{5, 5, 35, 6, 5, 28};
  for (const auto& shapes : std::vector<std::vector<std::vector<double>>>{
           {star}, {steps}, {spike}, {star, steps}, {steps, spike}}) {
    const std::vector<int> from = detail::open_pixels(shapes, kColumns, kRows);
    ASSERT_EQ(from.size(), std::size_t(kColumns * kRows));
    for (int row = 0; row < kRows; ++row)
      for (int c = 0; c < kColumns; ++c) {
        const bool is_open = std::all_of(shapes.begin(), shapes.end(), [&](const auto& corners) {
          return holds(corners, c + 1, row + 1);
        });
        const int here = row * kColumns + c;
        EXPECT_EQ(from[std::size_t(here)] == here, is_open) << c + 1 << ", " << row + 1;
      }
  }
}

TEST(OpenPixels, AreAllWhereNoShutterCoversAnyOrAllOfThePicture) {
  EXPECT_TRUE(detail::open_pixels({}, 8, 8).empty());
  EXPECT_TRUE(detail::open_pixels({detail::circle_corners(4, 4, 20)}, 8, 8).empty());
  EXPECT_TRUE(detail::open_pixels({detail::circle_corners(40, 40, 2)}, 8, 8).empty());
}

void put_r_waves(DcmDataset& d, const std::vector<Uint16>& frames) {
  d.putAndInsertUint16Array(DCM_RWavePointer, frames.data(),
                            static_cast<unsigned long>(frames.size()));
}

TEST_F(ProjectionRuns, TellTheirFramesTimesAndTheHeartsRWaves) {
  write_slice(file("a"), run_of_four([](DcmDataset& d) { put_r_waves(d, {1, 4}); }));
  auto run = inspect_run(folder());
  EXPECT_THAT(run.frame_times_ms, ElementsAre(0, 40, 80, 120));
  EXPECT_THAT(run.r_wave_times_ms, ElementsAre(0, 120));
  write_slice(file("a"), run_of_four([](DcmDataset& d) {
                delete d.remove(DCM_FrameTime);
                put(d, DCM_FrameTimeVector, "0\\30\\50\\30");
                put_r_waves(d, {3});
              }));
  run = inspect_run(folder());
  EXPECT_THAT(run.frame_times_ms, ElementsAre(0, 30, 80, 110));
  EXPECT_THAT(run.r_wave_times_ms, ElementsAre(80));
}

TEST_F(ProjectionRuns, LeaveRWavesOutThatAreNotInTheRun) {
  for (const std::vector<Uint16>& frames : {std::vector<Uint16>{2, 9}, {3, 2}, {0, 1}}) {
    write_slice(file("a"), run_of_four([&](DcmDataset& d) { put_r_waves(d, frames); }));
    const auto run = inspect_run(folder());
    EXPECT_THAT(run.r_wave_times_ms, IsEmpty());
    EXPECT_THAT(run.notes, Contains(HasSubstr("R waves")));
  }
}

TEST_F(ProjectionRuns, AnEnhancedRunTellsTheHeartsPhaseFrameByFrame) {
  EnhancedObject object;
  object.frames.assign(6, Slice{});
  for (Slice& slice : object.frames) slice.sop_class = UID_EnhancedXAImageStorage;
  object.more_groups = [](DcmItem& groups, int frame) {
    const int ms = 59900 + 50 * frame;  // over the minute, and R waves at 59850 and 60040
    char time[32];
    std::snprintf(time, sizeof time, "202001012359%02d.%03d000", ms / 1000 % 60, ms % 1000);
    if (ms >= 60000) std::snprintf(time, sizeof time, "202001020000%02d.%03d000", 0, ms - 60000);
    put(group(groups, DCM_FrameContentSequence), DCM_FrameReferenceDateTime, time);
    group(groups, DCM_CardiacSynchronizationSequence)
        .putAndInsertFloat64(DCM_ActualCardiacTriggerDelayTime,
                             ms < 60040 ? ms - 59850 : ms - 60040);
  };
  write_enhanced(file("a"), object);
  const auto run = inspect_run(folder());
  EXPECT_THAT(run.frame_times_ms, ElementsAre(0, 50, 100, 150, 200, 250));
  EXPECT_THAT(run.r_wave_times_ms, ElementsAre(-50, 140));
}

TEST_F(ProjectionRuns, AnEnhancedRunStatesItsGeometryInFunctionalGroups) {
  EnhancedObject object;
  for (int f = 0; f < 3; ++f) {
    Slice slice;
    slice.sop_class = UID_EnhancedXAImageStorage;
    object.frames.push_back(slice);
  }
  object.more_groups = [](DcmItem& groups, int frame) {
    DcmItem& positioner = group(groups, DCM_PositionerPositionSequence);
    put(positioner, DCM_PositionerPrimaryAngle, decimals({10.0 + frame}));
    put(positioner, DCM_PositionerSecondaryAngle, "-5");
    DcmItem& geometry = group(groups, DCM_XRayGeometrySequence);
    put(geometry, DCM_DistanceSourceToDetector, "1200");
    put(geometry, DCM_DistanceSourceToIsocenter, "800");
  };
  object.more = [](DcmDataset& d) { put(d, DCM_ImagerPixelSpacing, "0.3\\0.3"); };
  write_enhanced(file("a"), object);
  EXPECT_THAT(refusal(), HasSubstr("projection run"));
  const auto run = inspect_run(folder());
  EXPECT_THAT(run.primary_angles_degrees, ElementsAre(10, 11, 12));
  EXPECT_THAT(run.secondary_angles_degrees, ElementsAre(-5));
  EXPECT_NEAR(run.magnification.value_or(0), 1.5, 1e-9);
}

TEST_F(ProjectionRuns, OfARealSystemAreUnderstood) {
  const char* data = std::getenv("ANGIO_DATA");
  if (!data) GTEST_SKIP() << "ANGIO_DATA is not set";
  const auto all = inspect(fs::path(data) / "xa-coronary-phantom");
  ASSERT_FALSE(all.empty());
  for (const auto& series : all) {
    if (!series.projection) continue;
    const ProjectionRun& run = *series.projection;
    ASSERT_EQ(run.primary_angles_degrees.size(), 1u);
    ASSERT_EQ(run.secondary_angles_degrees.size(), 1u);
    // 200 mm of field on 512 pixels, seen from 720 mm: the patient's pixel follows from that.
    if (run.spacing_plane == SpacingPlane::isocentre)
      EXPECT_NEAR(run.spacing_mm[0], 200.0 / 512.0 * 720.0 / run.source_to_detector_mm.value_or(0),
                  1e-6);
    else
      EXPECT_EQ(run.spacing_plane, SpacingPlane::unknown);
    EXPECT_TRUE(run.open_field);
  }
}

}  // namespace
}  // namespace angio::segmentation
