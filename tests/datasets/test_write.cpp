#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

// DCMTK's configuration must come before its other headers.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "datasets/detail/write_dicom.hpp"
#include "datasets/phantom.hpp"
#include "testing/temporary_folder.hpp"

namespace angio::datasets {
namespace {

namespace fs = std::filesystem;

class WritePhantom : public testing::Test {
 protected:
  static PhantomOptions small_options() {
    return parse_phantom("unilateral,radius=1,length=12,spacing=0.5");
  }
  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

Vec3 triple(DcmDataset& dataset, const DcmTagKey& tag, unsigned long first = 0) {
  std::array<Float64, 3> v{};
  for (unsigned long i = 0; i < 3; ++i)
    EXPECT_TRUE(dataset.findAndGetFloat64(tag, v[i], first + i).good());
  return {v[0], v[1], v[2]};
}

std::string text(DcmDataset& dataset, const DcmTagKey& tag) {
  OFString value;
  EXPECT_TRUE(dataset.findAndGetOFStringArray(tag, value).good()) << tag.toString();
  return value.c_str();
}

TEST_F(WritePhantom, AsXRay3DHoldsTheFramesOfTheCtSeries) {
  PhantomOptions options = small_options();
  options.oblique_degrees = 25.0;
  const Phantom phantom = make_phantom_scan(options);
  const VolumeGeometry& grid = phantom.volume.geometry;
  const fs::path slices = write_phantom(phantom, options, PhantomFormat::dicom, folder_ / "ct");
  const fs::path volume = write_phantom(phantom, options, PhantomFormat::xray_3d, folder_ / "x3");
  DcmFileFormat whole;
  ASSERT_TRUE(whole.loadFile((volume / "IM0001.dcm").c_str()).good());
  EXPECT_EQ(text(*whole.getDataset(), DCM_SOPClassUID), UID_XRay3DAngiographicImageStorage);
  EXPECT_EQ(text(*whole.getDataset(), DCM_NumberOfFrames), std::to_string(grid.size[2]));
  const Uint16* pixels = nullptr;
  ASSERT_TRUE(whole.getDataset()->findAndGetUint16Array(DCM_PixelData, pixels).good());
  const std::size_t count = std::size_t(grid.size[0]) * std::size_t(grid.size[1]);
  for (int k : {0, grid.size[2] / 2, grid.size[2] - 1}) {
    char name[32];
    std::snprintf(name, sizeof name, "IM%04d.dcm", k + 1);
    DcmFileFormat slice;
    ASSERT_TRUE(slice.loadFile((slices / name).c_str()).good());
    const Uint16* stored = nullptr;
    ASSERT_TRUE(slice.getDataset()->findAndGetUint16Array(DCM_PixelData, stored).good());
    for (std::size_t i = 0; i < count; ++i)
      ASSERT_EQ(pixels[std::size_t(k) * count + i], std::max<int>(0, std::int16_t(stored[i])));
    DcmItem* frame = nullptr;
    DcmItem* position = nullptr;
    ASSERT_TRUE(whole.getDataset()
                    ->findAndGetSequenceItem(DCM_PerFrameFunctionalGroupsSequence, frame, k)
                    .good());
    ASSERT_TRUE(frame->findAndGetSequenceItem(DCM_PlanePositionSequence, position).good());
    for (unsigned long axis = 0; axis < 3; ++axis) {
      Float64 coordinate = 0.0;
      ASSERT_TRUE(position->findAndGetFloat64(DCM_ImagePositionPatient, coordinate, axis).good());
      EXPECT_NEAR(coordinate, triple(*slice.getDataset(), DCM_ImagePositionPatient)[int(axis)],
                  1e-9);
    }
  }
}

TEST_F(WritePhantom, AsDicomReadsBackWithTheSameGeometryAndPixels) {
  Phantom phantom = make_phantom(small_options());
  // An oblique grid, as a scanner's reformat has.
  const double c = std::cos(0.3), s = std::sin(0.3);
  phantom.volume.geometry.direction = Mat3{{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}};
  const VolumeGeometry& grid = phantom.volume.geometry;
  const fs::path series = write_phantom(phantom, small_options(), PhantomFormat::dicom, folder_);
  EXPECT_EQ(series, folder_ / "dicom");
  EXPECT_EQ(std::distance(fs::directory_iterator(series), fs::directory_iterator()), grid.size[2]);

  for (int k : {0, grid.size[2] / 2, grid.size[2] - 1}) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "IM%04d.dcm", k + 1);
    DcmFileFormat file;
    ASSERT_TRUE(file.loadFile((series / name.data()).c_str()).good());
    DcmDataset& dataset = *file.getDataset();
    EXPECT_EQ(text(dataset, DCM_SOPClassUID), UID_CTImageStorage);
    EXPECT_EQ(text(dataset, DCM_PatientName), "PHANTOM^UNILATERAL");
    const Vec3 index{0.0, 0.0, double(k)};
    EXPECT_NEAR(distance(triple(dataset, DCM_ImagePositionPatient), grid.lps_from_index(index)),
                0.0, 1e-6);
    EXPECT_NEAR(distance(triple(dataset, DCM_ImageOrientationPatient), {c, 0, -s}), 0.0, 1e-9);
    EXPECT_NEAR(distance(triple(dataset, DCM_ImageOrientationPatient, 3), {0, 1, 0}), 0.0, 1e-9);
    EXPECT_EQ(text(dataset, DCM_PixelSpacing), "0.5\\0.5");
    Uint16 rows = 0, columns = 0;
    dataset.findAndGetUint16(DCM_Rows, rows);
    dataset.findAndGetUint16(DCM_Columns, columns);
    ASSERT_EQ(rows, grid.size[1]);
    ASSERT_EQ(columns, grid.size[0]);
    const Uint16* pixels = nullptr;
    ASSERT_TRUE(dataset.findAndGetUint16Array(DCM_PixelData, pixels).good());
    const double intercept = std::stod(text(dataset, DCM_RescaleIntercept));
    const double slope = std::stod(text(dataset, DCM_RescaleSlope));
    for (int i = 0; i < rows * columns; ++i) {
      const double value = slope * double(std::int16_t(pixels[i])) + intercept;
      ASSERT_NEAR(value, double(phantom.volume.values[grid.offset(0, 0, k) + std::size_t(i)]),
                  0.5001);
    }
  }
}

TEST_F(WritePhantom, TwiceGivesTheSameBytes) {
  const Phantom phantom = make_phantom(small_options());
  for (PhantomFormat format : {PhantomFormat::dicom, PhantomFormat::nrrd, PhantomFormat::surface}) {
    const fs::path a = write_phantom(phantom, small_options(), format, folder_ / "a");
    const fs::path b =
        write_phantom(make_phantom(small_options()), small_options(), format, folder_ / "b");
    if (format == PhantomFormat::dicom) {
      for (const fs::directory_entry& file : fs::directory_iterator(a))
        EXPECT_EQ(read_text(file.path()), read_text(b / file.path().filename()));
    } else {
      EXPECT_EQ(read_text(a), read_text(b));
    }
    EXPECT_EQ(read_text(folder_ / "a/truth.json"), read_text(folder_ / "b/truth.json"));
  }
}

TEST_F(WritePhantom, ReplacesAnOlderSeriesWhole) {
  const PhantomOptions options = small_options();
  PhantomOptions shorter = options;
  shorter.length_mm = 10.0;
  write_phantom(make_phantom(options), options, PhantomFormat::dicom, folder_);
  const Phantom phantom = make_phantom(shorter);
  const fs::path series = write_phantom(phantom, shorter, PhantomFormat::dicom, folder_);
  EXPECT_EQ(std::distance(fs::directory_iterator(series), fs::directory_iterator()),
            phantom.volume.geometry.size[2]);
}

TEST_F(WritePhantom, RefusesToReplaceAFolderOfOtherFiles) {
  const Phantom phantom = make_phantom(small_options());
  fs::create_directories(folder_ / "dicom");
  write_text_atomically(folder_ / "dicom/notes.txt", "mine");
  try {
    write_phantom(phantom, small_options(), PhantomFormat::dicom, folder_);
    FAIL();
  } catch (const IoError& error) {
    EXPECT_EQ(error.exit_code(), ExitCode::cannot_create);
  }
  EXPECT_EQ(read_text(folder_ / "dicom/notes.txt"), "mine");
}

TEST_F(WritePhantom, AsNrrdHoldsTheVoxelsBehindItsHeader) {
  const Phantom phantom = make_phantom(small_options());
  const std::string bytes =
      read_text(write_phantom(phantom, small_options(), PhantomFormat::nrrd, folder_));
  EXPECT_EQ(bytes.substr(0, 9), "NRRD0005\n");
  EXPECT_NE(bytes.find("space: left-posterior-superior\n"), std::string::npos);
  const std::size_t data = bytes.find("\n\n") + 2;
  ASSERT_EQ(bytes.size() - data, phantom.volume.values.size() * sizeof(float));
  EXPECT_EQ(std::memcmp(bytes.data() + data, phantom.volume.values.data(), bytes.size() - data), 0);
}

TEST_F(WritePhantom, AsSurfaceIsABinaryStl) {
  const Phantom phantom = make_phantom_surface(small_options());
  const std::string bytes =
      read_text(write_phantom(phantom, small_options(), PhantomFormat::surface, folder_));
  EXPECT_EQ(bytes.substr(0, 9), "SPACE=LPS");
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  EXPECT_EQ(count, phantom.surface.triangles.size());
  EXPECT_EQ(bytes.size(), 84u + 50u * count);
}

TEST_F(WritePhantom, TruthSaysWhatIsKnown) {
  const Phantom phantom = make_phantom_surface(small_options());
  write_phantom(phantom, small_options(), PhantomFormat::surface, folder_);
  const auto truth = nlohmann::json::parse(read_text(folder_ / "truth.json"));
  EXPECT_EQ(truth["phantom"], "unilateral");
  EXPECT_EQ(truth["space"], "LPS");
  EXPECT_EQ(truth["mld_mm"], phantom.truth.mld_mm);
  EXPECT_EQ(truth["reference_diameter_mm"], 2.0);
  EXPECT_EQ(truth["options"]["length_mm"], 12.0);
  EXPECT_EQ(truth["paths"].size(), 1u);
  EXPECT_EQ(truth["paths"][0]["points_mm"].size(), phantom.truth.tree.paths[0].points.size());
}

TEST_F(WritePhantom, RefusesAnImageOfACloth) {
  const PhantomOptions options = parse_phantom("cloth");
  const Phantom cloth = make_phantom_surface(options);
  EXPECT_THROW(write_phantom(cloth, options, PhantomFormat::dicom, folder_), InputError);
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_EQ(write_phantom(cloth, options, PhantomFormat::surface, folder_), folder_ / "lumen.stl");
}

TEST(PhantomUid, IsAValidUuidNumberThatDependsOnItsTextAlone) {
  const std::string uid = datasets::detail::uid_from("one");
  EXPECT_EQ(uid, datasets::detail::uid_from("one"));
  EXPECT_NE(uid, datasets::detail::uid_from("two"));
  EXPECT_EQ(uid.substr(0, 5), "2.25.");
  EXPECT_NE(uid[5], '0');
  EXPECT_LE(uid.size(), 44u);  // 2^128 has 39 digits
  EXPECT_EQ(uid.find_first_not_of("0123456789."), std::string::npos);
}

}  // namespace
}  // namespace angio::datasets
