#include <dcmtk/dcmfg/fgderimg.h>
#include <dcmtk/dcmfg/fgplanpo.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdio>
#include <memory>

#include "core/atomic_file.hpp"
#include "formats/nrrd.hpp"
#include "segmentation/dicom_segmentation.hpp"
#include "tests/segmentation/dicom_objects.hpp"

namespace angio::segmentation {
namespace {
using testing::HasSubstr;

const Vec3 kCentre{6.0, 5.0, 4.1};
constexpr double kRadius = 2.6;

/// The signed distance to a ball, on a grid of its own, finer than any source and turned.
Volume<float> ball() {
  VolumeGeometry grid;
  grid.size = {64, 60, 56};
  grid.spacing = {0.13, 0.14, 0.15};
  const Vec3 i = normalized(Vec3{0.9, 0.2, 0.1});
  const Vec3 j = normalized(cross(Vec3{0, 0.1, 1}, i));
  const Vec3 k = cross(i, j);
  grid.direction = {{{i.x, j.x, k.x}, {i.y, j.y, k.y}, {i.z, j.z, k.z}}};
  const Vec3 middle = grid.lps_from_index({31.5, 29.5, 27.5});
  grid.origin = kCentre - middle;
  Volume<float> level_set(grid);
  for (int c = 0; c < grid.size[2]; ++c)
    for (int b = 0; b < grid.size[1]; ++b)
      for (int a = 0; a < grid.size[0]; ++a)
        level_set.at(a, b, c) = float(
            distance(grid.lps_from_index({double(a), double(b), double(c)}), kCentre) - kRadius);
  return level_set;
}

Slice source_slice(int k) {
  Slice slice;
  slice.rows = 22;
  slice.columns = 30;
  slice.position = {0.0, 0.0, 0.5 * k};
  slice.number = k + 1;
  slice.more = [](DcmDataset& d) {
    put(d, DCM_Modality, "CT");
    put(d, DCM_StudyDate, "20200102");
  };
  return slice;
}

class DicomSegmentation : public DicomFolder {
 protected:
  void write_ct() const {
    fs::create_directories(file("ct"));
    for (int k = 0; k < 16; ++k) write_slice(file("ct/" + std::to_string(99 - k)), source_slice(k));
  }
  void write_xray_3d() const {
    EnhancedObject object;
    for (int k = 15; k >= 0; --k) {
      object.frames.push_back(source_slice(k));
      object.frames.back().sop_class = UID_XRay3DAngiographicImageStorage;
    }
    write_enhanced(file("x3"), object);
  }
  [[nodiscard]] std::unique_ptr<DcmSegmentation> read_back() const {
    DcmSegmentation* object = nullptr;
    EXPECT_TRUE(DcmSegmentation::loadFile(file("seg.dcm").c_str(), object).good());
    return std::unique_ptr<DcmSegmentation>(object);
  }
};

/// Every pixel of every frame is what the ball is at that pixel's place in the patient.
void expect_ball(DcmSegmentation& object, double spacing_i, double spacing_j) {
  const std::size_t pixel_count = 22 * 30;
  std::size_t inside = 0;
  for (std::size_t f = 0; f < object.getNumberOfFrames(); ++f) {
    OFBool per_frame = OFFalse;
    auto* place = dynamic_cast<FGPlanePosPatient*>(
        object.getFunctionalGroups().get(Uint32(f), DcmFGTypes::EFG_PLANEPOSPATIENT, per_frame));
    ASSERT_TRUE(place);
    Vec3 p;
    ASSERT_TRUE(place->getImagePositionPatient(p.x, p.y, p.z).good());
    const DcmIODTypes::Frame* packed = object.getFrame(f);
    for (std::size_t n = 0; n < pixel_count; ++n) {
      const bool lumen = (packed->pixData[n / 8] >> (n % 8)) & 1;
      const std::size_t row = n / 30;
      const Vec3 at = p + Vec3{spacing_i * double(n % 30), spacing_j * double(row), 0.0};
      const double off = distance(at, kCentre) - kRadius;
      inside += lumen ? 1 : 0;
      if (std::abs(off) > 0.01) {  // what the finer grid's interpolation may be off
        ASSERT_EQ(lumen, off < 0.0);
      }
    }
  }
  const double volume = double(inside) * spacing_i * spacing_j * 0.5;
  EXPECT_NEAR(volume, 4.0 / 3.0 * 3.14159265 * kRadius * kRadius * kRadius, 0.03 * volume);
}

TEST_F(DicomSegmentation, LiesOnTheSlicesOfACtSeries) {
  write_ct();
  write_dicom_segmentation(file("seg.dcm"), ball(), file("ct"), {});
  const auto object = read_back();
  ASSERT_TRUE(object);
  EXPECT_EQ(object->getNumberOfSegments(), 1u);
  EXPECT_EQ(object->getNumberOfFrames(), 10u) << "slices within the radius of the centre";
  expect_ball(*object, 0.4, 0.6);
}

TEST_F(DicomSegmentation, RefersToTheFramesOfAMultiFrameSource) {
  write_xray_3d();
  write_dicom_segmentation(file("seg.dcm"), ball(), file("x3"), {});
  const auto object = read_back();
  ASSERT_TRUE(object);
  expect_ball(*object, 0.4, 0.6);
  OFBool per_frame = OFFalse;
  auto* derivation = dynamic_cast<FGDerivationImage*>(
      object->getFunctionalGroups().get(0, DcmFGTypes::EFG_DERIVATIONIMAGE, per_frame));
  ASSERT_TRUE(derivation);
  OFVector<Uint16> frames;
  derivation->getDerivationImageItems()[0]
      ->getSourceImageItems()[0]
      ->getImageSOPInstanceReference()
      .getReferencedFrameNumber(frames);
  // The lowest slice with lumen is k = 4; the frames were written from k = 15 down.
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0], 16 - 4);
}

TEST_F(DicomSegmentation, LiesOnTheSlicesOfATiltedSeriesAsTheyAre) {
  fs::create_directories(file("tilted"));
  for (int k = 0; k < 16; ++k) {
    Slice slice = source_slice(k);
    slice.position.y = 0.2 * k - 1.0;
    write_slice(file("tilted/" + std::to_string(k)), slice);
  }
  ASSERT_TRUE(inspect(file("tilted"))[0].resampled);
  write_dicom_segmentation(file("seg.dcm"), ball(), file("tilted"), {});
  const auto object = read_back();
  ASSERT_TRUE(object);
  expect_ball(*object, 0.4, 0.6);
}

TEST_F(DicomSegmentation, RefusesASourceWhosePlaceInThePatientIsNotKnown) {
  fs::create_directories(file("ct"));
  for (int k = 0; k < 16; ++k) {
    Slice slice = source_slice(k);
    slice.has_geometry = false;
    write_slice(file("ct/" + std::to_string(k)), slice);
  }
  EXPECT_THROW(write_dicom_segmentation(file("seg.dcm"), ball(), file("ct"),
                                        {.spacing_mm = {0.4, 0.6, 0.5}}),
               InputError);
}

TEST_F(DicomSegmentation, HoldsTheSourcesUidsAndNoPatient) {
  write_ct();
  write_dicom_segmentation(file("seg.dcm"), ball(), file("ct"), {});
  DcmFileFormat written;
  ASSERT_TRUE(written.loadFile(file("seg.dcm").c_str()).good());
  DcmDataset& d = *written.getDataset();
  const auto text = [&](const DcmTagKey& tag) {
    OFString value;
    d.findAndGetOFString(tag, value);
    return std::string(value.c_str());
  };
  EXPECT_EQ(text(DCM_StudyInstanceUID), "1.2.826.0.1.3680043.2.10");
  EXPECT_EQ(text(DCM_FrameOfReferenceUID), "1.2.826.0.1.3680043.2.20");
  EXPECT_NE(text(DCM_SeriesInstanceUID), "1.2.826.0.1.3680043.2.100");
  EXPECT_EQ(text(DCM_SeriesInstanceUID).substr(0, 5), "2.25.");
  EXPECT_EQ(text(DCM_PatientName), "");
  EXPECT_EQ(read_text(file("seg.dcm")).find("SECRET"), std::string::npos);
  DcmItem* series = nullptr;
  ASSERT_TRUE(d.findAndGetSequenceItem(DCM_ReferencedSeriesSequence, series, 0).good());
  OFString series_uid;
  series->findAndGetOFString(DCM_SeriesInstanceUID, series_uid);
  EXPECT_EQ(std::string(series_uid.c_str()), "1.2.826.0.1.3680043.2.100");
  DcmSequenceOfItems* instances = nullptr;
  ASSERT_TRUE(series->findAndGetSequence(DCM_ReferencedInstanceSequence, instances).good());
  EXPECT_EQ(instances->card(), 10u);
  struct stat status {};
  ASSERT_EQ(stat(file("seg.dcm").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(DicomSegmentation, KeepsThePatientOnRequest) {
  write_ct();
  write_dicom_segmentation(file("seg.dcm"), ball(), file("ct"), {}, {.keep_patient = true});
  EXPECT_THAT(read_text(file("seg.dcm")), HasSubstr("SECRET^NAME"));
}

TEST_F(DicomSegmentation, IsTheSameBytesEachTime) {
  write_ct();
  write_dicom_segmentation(file("seg.dcm"), ball(), file("ct"), {});
  const std::string once = read_text(file("seg.dcm"));
  write_dicom_segmentation(file("seg.dcm"), ball(), file("ct"), {});
  EXPECT_EQ(read_text(file("seg.dcm")), once);
}

TEST_F(DicomSegmentation, NeedsADicomSourceThatHoldsTheLumen) {
  write_ct();
  formats::write_nrrd(file("a.nrrd"), ball());
  EXPECT_THROW(write_dicom_segmentation(file("seg.dcm"), ball(), file("a.nrrd"), {}), InputError);
  Volume<float> elsewhere = ball();
  elsewhere.geometry.origin.x += 500.0;
  EXPECT_THROW(write_dicom_segmentation(file("seg.dcm"), elsewhere, file("ct"), {}), InputError);
  EXPECT_FALSE(fs::exists(file("seg.dcm")));
}

TEST_F(DicomSegmentation, PassesDciodvfy) {
  if (std::system("command -v dciodvfy > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "dciodvfy (package dicom3tools) is not installed";
  write_ct();
  write_xray_3d();
  for (const char* source : {"ct", "x3"})
    for (const bool keep_patient : {false, true}) {
      write_dicom_segmentation(file("seg.dcm"), ball(), file(source), {},
                               {.keep_patient = keep_patient});
      const std::string command =
          "dciodvfy " + file("seg.dcm").string() + " > " + file("verdict").string() + " 2>&1";
      EXPECT_GE(std::system(command.c_str()), 0);
      EXPECT_EQ(read_text(file("verdict")).find("Error"), std::string::npos)
          << read_text(file("verdict"));
    }
}

}  // namespace
}  // namespace angio::segmentation
