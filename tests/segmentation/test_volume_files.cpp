#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

class VolumeFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() / ("angio-volume-files-" + std::to_string(getpid()) + "-" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

  /// The error that reading a path ends in.
  static InputError error_of(const fs::path& path) {
    try {
      read_volume(path, {});
    } catch (const InputError& error) {
      return error;
    }
    ADD_FAILURE() << path << " was read";
    return InputError("none");
  }

 private:
  fs::path folder_;
};

Volume<float> oblique_volume() {
  VolumeGeometry geometry;
  geometry.size = {5, 4, 3};
  geometry.spacing = {0.3, 0.41, 0.7};
  geometry.origin = {-12.3, 45.6, 7.89};
  const Vec3 i = normalized(Vec3{0.9, 0.2, -0.1});
  const Vec3 k = normalized(cross(i, Vec3{0.1, 0.9, 0.3}));
  const Vec3 j = cross(k, i);
  for (int row = 0; row < 3; ++row) {
    geometry.direction(row, 0) = i[row];
    geometry.direction(row, 1) = j[row];
    geometry.direction(row, 2) = k[row];
  }
  Volume<float> volume(geometry);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-100.0f, 900.0f);
  for (float& v : volume.values) v = uniform(random);
  return volume;
}

void expect_same_geometry(const VolumeGeometry& a, const VolumeGeometry& b) {
  EXPECT_EQ(a.size, b.size);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(a.spacing[axis], b.spacing[axis], 1e-12);
    EXPECT_NEAR(a.origin[axis], b.origin[axis], 1e-12);
    for (int row = 0; row < 3; ++row)
      EXPECT_NEAR(a.direction(row, axis), b.direction(row, axis), 1e-12);
  }
}

TEST_F(VolumeFiles, NrrdComesBackAsWritten) {
  const auto volume = oblique_volume();
  write_volume(file("a.nrrd"), volume);
  const auto back = read_volume_file(file("a.nrrd"));
  expect_same_geometry(back.geometry, volume.geometry);
  EXPECT_EQ(back.values, volume.values);
}

TEST_F(VolumeFiles, NrrdIsLpsGzipAndTheSameBytesEachTime) {
  Volume<std::uint8_t> mask(oblique_volume().geometry, 1);
  write_volume(file("a.nrrd"), mask);
  write_volume(file("b.nrrd"), mask);
  const std::string text = read_text(file("a.nrrd"));
  EXPECT_EQ(text, read_text(file("b.nrrd")));
  EXPECT_THAT(text, HasSubstr("\nspace: left-posterior-superior\n"));
  EXPECT_THAT(text, HasSubstr("\nencoding: gzip\n"));
  EXPECT_EQ(std::distance(fs::directory_iterator(file("a.nrrd").parent_path()), {}), 2)
      << "a temporary file was left behind";
}

TEST_F(VolumeFiles, RasNrrdLiesAtTheSamePlaceAsLps) {
  // One voxel, named in RAS: x and y change their signs.
  std::ofstream(file("ras.nrrd"), std::ios::binary)
      << "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 2 2 2\n"
         "space directions: (0.5,0,0) (0,0.5,0) (0,0,2)\nkinds: domain domain domain\n"
         "endian: little\nencoding: raw\nspace origin: (10,20,30)\n\n01234567";
  const auto loaded = read_volume(file("ras.nrrd"), {});
  const auto& g = loaded.volume.geometry;
  EXPECT_NEAR(distance(g.lps_from_index({0, 0, 0}), {-10, -20, 30}), 0.0, 1e-12);
  EXPECT_NEAR(distance(g.lps_from_index({1, 0, 1}), {-10.5, -20, 32}), 0.0, 1e-12);
  EXPECT_EQ(loaded.volume.at(1, 0, 0), float('1'));
  EXPECT_NEAR(determinant(g.direction), 1.0, 1e-12);
}

TEST_F(VolumeFiles, LeftHandedAxesAreTurnedWithTheirVoxels) {
  std::ofstream(file("left.nrrd"), std::ios::binary)
      << "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 3\n"
         "space directions: (1,0,0) (0,1,0) (0,0,-2)\nkinds: domain domain domain\n"
         "endian: little\nencoding: raw\nspace origin: (0,0,9)\n\n0123456789ab";
  const auto loaded = read_volume(file("left.nrrd"), {});
  const auto& g = loaded.volume.geometry;
  EXPECT_NEAR(determinant(g.direction), 1.0, 1e-12);
  EXPECT_EQ(loaded.warnings.size(), 1u);
  // '8' was the first voxel of the last slice, at z = 9 - 4.
  EXPECT_EQ(loaded.volume.at(0, 0, 0), float('8'));
  EXPECT_NEAR(distance(g.lps_from_index({0, 0, 0}), {0, 0, 5}), 0.0, 1e-12);
  EXPECT_NEAR(distance(g.lps_from_index({0, 0, 2}), {0, 0, 9}), 0.0, 1e-12);
}

TEST_F(VolumeFiles, WithoutSpacingOrWithOtherUnitsOrSkewAreRefused) {
  const std::string head =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nendian: little\nencoding: raw\n";
  std::ofstream(file("bare.nrrd"), std::ios::binary) << head << "\n01234567";
  EXPECT_THAT(error_of(file("bare.nrrd")).what(), HasSubstr("states no voxel spacing"));
  std::ofstream(file("um.nrrd"), std::ios::binary)
      << head << "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
      << "space units: \"um\" \"um\" \"um\"\n\n01234567";
  EXPECT_THAT(error_of(file("um.nrrd")).what(), HasSubstr("not in mm"));
  std::ofstream(file("skew.nrrd"), std::ios::binary)
      << head << "space: left-posterior-superior\nspace directions: (1,0,0) (0.2,1,0) (0,0,1)\n"
      << "\n01234567";
  EXPECT_THAT(error_of(file("skew.nrrd")).what(), HasSubstr("right angles"));
  std::ofstream(file("bare.mha"), std::ios::binary)
      << "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
         "ElementDataFile = LOCAL\n01234567";
  EXPECT_THAT(error_of(file("bare.mha")).what(), HasSubstr("states no voxel spacing"));
}

TEST_F(VolumeFiles, DamagedFilesAreRefusedWithOneLine) {
  write_volume(file("whole.nrrd"), oblique_volume());
  const std::string bytes = read_text(file("whole.nrrd"));
  std::ofstream(file("cut.nrrd"), std::ios::binary) << bytes.substr(0, bytes.size() - 60);
  std::ofstream(file("text.nrrd")) << "this is no volume\n";
  std::ofstream(file("text.nii.gz")) << "this is no volume\n";
  std::ofstream(file("text.mha")) << "this is no volume\n";
  std::ofstream(file("text.vti")) << "<VTKFile type=\"ImageData\"><ImageData";
  for (const char* name : {"cut.nrrd", "text.nrrd", "text.nii.gz", "text.mha", "text.vti"}) {
    const InputError error = error_of(file(name));
    EXPECT_EQ(error.exit_code(), ExitCode::bad_data) << name;
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

TEST_F(VolumeFiles, VtiIsReadInItsSpace) {
  const auto write = [&](const std::string& name, const std::string& space) {
    std::ofstream(file(name))
        << "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">"
           "<ImageData WholeExtent=\"0 1 0 1 0 1\" Origin=\"10 20 30\" Spacing=\"0.5 0.6 0.7\" "
           "Direction=\"1 0 0 0 1 0 0 0 1\">"
           "<FieldData><Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">"
        << int(space[0]) << ' ' << int(space[1]) << ' ' << int(space[2])
        << " 0</Array></FieldData><Piece Extent=\"0 1 0 1 0 1\"><PointData Scalars=\"a\">"
           "<DataArray type=\"Float32\" Name=\"a\" format=\"ascii\">0 1 2 3 4 5 6 7</DataArray>"
           "</PointData></Piece></ImageData></VTKFile>";
    return file(name);
  };
  const auto lps = read_volume_file(write("lps.vti", "LPS"));
  EXPECT_NEAR(distance(lps.geometry.lps_from_index({1, 1, 1}), {10.5, 20.6, 30.7}), 0.0, 1e-9);
  EXPECT_EQ(lps.at(1, 0, 0), 1.0f);
  const auto ras = read_volume_file(write("ras.vti", "RAS"));
  EXPECT_NEAR(distance(ras.geometry.lps_from_index({1, 1, 1}), {-10.5, -20.6, 30.7}), 0.0, 1e-9);
  EXPECT_THAT(error_of(write("xyz.vti", "XYZ")).what(), HasSubstr("only LPS and RAS"));
}

TEST_F(VolumeFiles, AMissingFileIsExit66AndOtherThingsExit65) {
  EXPECT_EQ(error_of(file("missing")).exit_code(), ExitCode::no_input);
  fs::create_directories(file("empty"));
  EXPECT_EQ(error_of(file("empty")).exit_code(), ExitCode::bad_data);
  std::ofstream(file("notes.txt")) << "a text that is long enough to be looked at by the reader\n";
  EXPECT_EQ(error_of(file("notes.txt")).exit_code(), ExitCode::bad_data);
  fs::create_directories(file("texts"));
  std::ofstream(file("texts/notes.txt")) << "a text\n";
  EXPECT_EQ(error_of(file("texts")).exit_code(), ExitCode::bad_data);
  EXPECT_THAT(error_of(file("texts")).what(), HasSubstr("holds no DICOM"));
}

TEST_F(VolumeFiles, AreListedByInspect) {
  write_volume(file("a.nrrd"), oblique_volume());
  const auto found = inspect(file("a.nrrd"));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].usable);
  EXPECT_EQ(found[0].key, "NRRD");
  EXPECT_EQ(found[0].geometry.size, oblique_volume().geometry.size);
}

TEST_F(VolumeFiles, ValuesThatAreNoNumbersAreReplacedAndTold) {
  auto volume = oblique_volume();
  volume.at(1, 1, 1) = std::numeric_limits<float>::quiet_NaN();
  write_volume(file("nan.nrrd"), volume);
  const auto loaded = read_volume(file("nan.nrrd"), {});
  EXPECT_TRUE(std::isfinite(loaded.volume.at(1, 1, 1)));
  EXPECT_EQ(loaded.warnings.size(), 1u);
}

}  // namespace
}  // namespace angio::segmentation
