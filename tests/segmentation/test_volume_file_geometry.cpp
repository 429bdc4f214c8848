#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/error.hpp"
#include "segmentation/read_run.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/temporary_folder.hpp"

/// Volume files whose geometry is easily mistaken.
namespace angio::segmentation {
namespace {
namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// A NIfTI-1 file of 3 x 4 x 5 numbers that count up, with a plain affine unless changed.
class Nifti {
 public:
  Nifti() {
    put<std::int32_t>(0, 348);
    const std::array<std::int16_t, 8> sizes = {3, 3, 4, 5, 1, 1, 1, 1};
    for (std::size_t d = 0; d < sizes.size(); ++d) put(40 + 2 * d, sizes[d]);
    put<std::int16_t>(70, 16);  // float
    put<std::int16_t>(72, 32);
    for (std::size_t d = 0; d < 8; ++d) put(76 + 4 * d, 1.0f);
    voxel_sizes(0.3f, 0.4f, 0.5f);
    put(108, 352.0f);
    bytes_[123] = 2;  // mm
    std::memcpy(bytes_.data() + 344, "n+1", 4);
  }

  template <class Number>
  void put(std::size_t place, Number number) {
    std::memcpy(bytes_.data() + place, &number, sizeof number);
  }
  void voxel_sizes(float i, float j, float k) {
    put(80, i);
    put(84, j);
    put(88, k);
  }
  void sform(const std::array<float, 12>& rows) {
    put<std::int16_t>(254, 1);
    for (std::size_t n = 0; n < rows.size(); ++n) put(280 + 4 * n, rows[n]);
  }
  void qform(const std::array<float, 3>& turn, const std::array<float, 3>& origin, float handed) {
    put<std::int16_t>(252, 1);
    put(76, handed);
    for (std::size_t n = 0; n < 3; ++n) {
      put(256 + 4 * n, turn[n]);
      put(268 + 4 * n, origin[n]);
    }
  }
  void unit(char code) { bytes_[123] = code; }

  [[nodiscard]] std::string file() const {
    std::string text(bytes_.begin(), bytes_.end());
    for (int v = 0; v < 60; ++v) {
      const auto value = float(v);
      text.append(reinterpret_cast<const char*>(&value), 4);
    }
    return text;
  }

 private:
  std::array<char, 352> bytes_{};
};

class VolumeFileGeometry : public testing::Test {
 protected:
  [[nodiscard]] fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  [[nodiscard]] fs::path write_gz(const std::string& name, const std::string& bytes) const {
    gzFile file = gzopen((folder_ / name).c_str(), "wb");
    gzwrite(file, bytes.data(), unsigned(bytes.size()));
    gzclose(file);
    return folder_ / name;
  }
  static std::string refusal(const fs::path& path, const ReadOptions& options = {}) {
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

/// Where a voxel lies, and its value, whichever way the slices were turned.
void expect_at(const Volume<float>& volume, const Vec3& lps, float value) {
  const Vec3 index = volume.geometry.index_from_lps(lps);
  const int i = int(std::lround(index.x)), j = int(std::lround(index.y)),
            k = int(std::lround(index.z));
  ASSERT_TRUE(volume.geometry.contains(i, j, k));
  EXPECT_NEAR(distance(index, {double(i), double(j), double(k)}), 0.0, 1e-4);
  EXPECT_EQ(volume.at(i, j, k), value);
}

TEST_F(VolumeFileGeometry, NiftiIsTurnedFromRasToLps) {
  Nifti nifti;
  nifti.sform({0.3f, 0, 0, 10, 0, 0.4f, 0, 20, 0, 0, 0.5f, 30});
  for (const fs::path& path : {write("a.nii", nifti.file()), write_gz("a.nii.gz", nifti.file())}) {
    const auto volume = read_volume(path, {}).volume;
    EXPECT_NEAR(determinant(volume.geometry.direction), 1.0, 1e-12);
    expect_at(volume, {-10, -20, 30}, 0.0f);
    expect_at(volume, {-10.6, -20, 30}, 2.0f);
    expect_at(volume, {-10, -21.2, 30}, 9.0f);
    expect_at(volume, {-10, -20, 32}, 48.0f);
  }
}

TEST_F(VolumeFileGeometry, NiftiWithReversedAxesKeepsItsVoxelsInPlace) {
  Nifti nifti;  // a left-handed sform: one axis runs backwards
  nifti.sform({-0.3f, 0, 0, 10, 0, 0.4f, 0, 20, 0, 0, 0.5f, 30});
  const auto volume = read_volume(write("a.nii", nifti.file()), {}).volume;
  EXPECT_NEAR(determinant(volume.geometry.direction), 1.0, 1e-12);
  expect_at(volume, {-10, -20, 30}, 0.0f);
  expect_at(volume, {-9.4, -20, 30}, 2.0f);
  expect_at(volume, {-10, -20, 32}, 48.0f);
}

TEST_F(VolumeFileGeometry, NiftiQformIsAQuaternionWithAHand) {
  Nifti nifti;  // a quarter turn about z: i points to +y, j to -x
  const auto half = float(std::sqrt(0.5));
  nifti.qform({0, 0, half}, {1, 2, 3}, -1.0f);
  const auto volume = read_volume(write("a.nii", nifti.file()), {}).volume;
  expect_at(volume, {-1, -2, 3}, 0.0f);
  expect_at(volume, {-1, -2.6, 3}, 2.0f);
  expect_at(volume, {0.2, -2, 3}, 9.0f);
  expect_at(volume, {-1, -2, 1}, 48.0f);
}

TEST_F(VolumeFileGeometry, NiftiQformTurnsAboutAnyAxis) {
  const Vec3 axis = (1.0 / 3.0) * Vec3{1, 2, 2};
  const double angle = 1.1;
  const Vec3 turn = std::sin(0.5 * angle) * axis;
  const auto at = [&](const Vec3& p) {  // Rodrigues' formula; RAS to LPS
    const Vec3 q = std::cos(angle) * p + std::sin(angle) * cross(axis, p) +
                   (1.0 - std::cos(angle)) * dot(axis, p) * axis + Vec3{1, 2, 3};
    return Vec3{-q.x, -q.y, q.z};
  };
  Nifti nifti;
  nifti.qform({float(turn.x), float(turn.y), float(turn.z)}, {1, 2, 3}, 1.0f);
  const auto volume = read_volume(write("a.nii", nifti.file()), {}).volume;
  expect_at(volume, at({0, 0, 0}), 0.0f);
  expect_at(volume, at({0.6, 0, 0}), 2.0f);
  expect_at(volume, at({0, 1.2, 0}), 9.0f);
  expect_at(volume, at({0, 0, 2.0}), 48.0f);
}

TEST_F(VolumeFileGeometry, NiftiInOtherUnitsIsBroughtToMillimetres) {
  Nifti nifti;
  nifti.voxel_sizes(300, 400, 500);
  nifti.sform({300, 0, 0, 10000, 0, 400, 0, 20000, 0, 0, 500, 30000});
  nifti.unit(3);  // micrometres
  expect_at(read_volume(write("a.nii", nifti.file()), {}).volume, {-10.6, -20, 30}, 2.0f);
}

TEST_F(VolumeFileGeometry, ShearedNiftiIsRefusedAndRoundedOneSetRight) {
  Nifti nifti;
  nifti.sform({0.3f, 0.1f, 0, 10, 0, 0.4f, 0, 20, 0, 0, 0.5f, 30});
  nifti.voxel_sizes(0.3f, float(std::hypot(0.1, 0.4)), 0.5f);
  EXPECT_THAT(refusal(write("shear.nii", nifti.file())), HasSubstr("right angles"));
  Nifti rounded;
  rounded.sform({0.3f, 2e-4f, 0, 10, 0, 0.4f, 0, 20, 0, 0, 0.5f, 30});
  const auto loaded = read_volume(write("rounded.nii", rounded.file()), {});
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("made orthogonal")));
  const auto& d = loaded.volume.geometry.direction;
  const Mat3 square = transpose(d) * d;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) EXPECT_NEAR(square(a, b), a == b ? 1.0 : 0.0, 1e-12);
}

TEST_F(VolumeFileGeometry, NiftiThatStatesTwoVoxelSizesIsRefused) {
  Nifti nifti;
  nifti.sform({0.6f, 0, 0, 10, 0, 0.4f, 0, 20, 0, 0, 0.5f, 30});
  EXPECT_THAT(refusal(write("a.nii", nifti.file())), HasSubstr("two voxel sizes"));
}

TEST_F(VolumeFileGeometry, NiftiWithoutASpaceIsToldAndOneWithoutASizeRefused) {
  Nifti nifti;
  const auto loaded = read_volume(write("a.nii", nifti.file()), {});
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("no patient space")));
  EXPECT_NEAR(loaded.volume.geometry.spacing.y, 0.4, 1e-6);
  nifti.voxel_sizes(0, 0, 0);
  EXPECT_FALSE(refusal(write("zero.nii", nifti.file())).empty());
}

TEST_F(VolumeFileGeometry, NiftiOfTheOtherByteOrderIsTheSame) {
  Nifti nifti;
  nifti.sform({0.3f, 0, 0, 10, 0, 0.4f, 0, 20, 0, 0, 0.5f, 30});
  std::string bytes = nifti.file();
  const auto swap = [&](std::size_t first, std::size_t size, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n)
      std::reverse(bytes.begin() + std::ptrdiff_t(first + n * size),
                   bytes.begin() + std::ptrdiff_t(first + (n + 1) * size));
  };
  swap(0, 4, 1);
  swap(40, 2, 8);
  swap(70, 2, 3);
  swap(76, 4, 8 + 3);
  swap(252, 2, 2);
  swap(256, 4, 18);
  swap(352, 4, 60);
  expect_at(read_volume(write("a.nii", bytes), {}).volume, {-10, -21.2, 30}, 9.0f);
}

TEST_F(VolumeFileGeometry, NiftiOfTheSecondVersionAndItsScaleAreRead) {
  std::string bytes(544, '\0');
  const auto put = [&](std::size_t place, auto number) {
    std::memcpy(bytes.data() + place, &number, sizeof number);
  };
  put(0, std::int32_t(540));
  std::memcpy(bytes.data() + 4, "n+2", 4);
  put(12, std::int16_t(4));
  const std::array<std::int64_t, 4> sizes = {3, 2, 2, 2};
  const std::array<double, 4> voxel = {1.0, 0.3, 0.4, 0.5};
  const std::array<double, 12> rows = {-0.3, 0, 0, 1, 0, -0.4, 0, 2, 0, 0, 0.5, 3};
  put(16, sizes);
  put(104, voxel);
  put(168, std::int64_t(544));
  put(176, 2.0);
  put(184, -5.0);
  put(348, std::int32_t(1));
  put(400, rows);
  for (std::int16_t v = 0; v < 8; ++v) bytes.append(reinterpret_cast<const char*>(&v), 2);
  const auto volume = read_volume(write("a.nii", bytes), {}).volume;
  expect_at(volume, {-1, -2, 3}, -5.0f);
  expect_at(volume, {-0.7, -1.6, 3.5}, 2.0f * 7.0f - 5.0f);
}

TEST_F(VolumeFileGeometry, NiftiOfColoursIsRefused) {
  Nifti nifti;
  nifti.put<std::int16_t>(70, 128);
  EXPECT_THAT(refusal(write("rgb.nii", nifti.file())), HasSubstr("colours"));
}

const char* const kNrrdEnd = "\nendian: little\nencoding: raw\n\n";

TEST_F(VolumeFileGeometry, NrrdOfAnyOrderOfAxesAndBytesLiesInPlace) {
  // Axes i, j, k run along z, x, -y (left-handed), in big-endian 16 bit numbers.
  std::string text =
      "NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 3 2\n"
      "space directions: (0,0,0.5) (0.3,0,0) (0,-0.4,0)\nspace origin: (1,2,3)\nendian: big\n"
      "encoding: raw\n\n";
  for (int v = 0; v < 12; ++v) text += std::string{char(0), char(v)};
  for (const int reversed : {0, 1}) {
    std::string turned = text;
    if (reversed == 1) turned.replace(turned.find("(0,-0.4,0)"), 10, "(0,+0.4,0)");
    const auto volume = read_volume(write("a.nrrd", turned), {}).volume;
    const double y = reversed == 1 ? 2.4 : 1.6;
    EXPECT_NEAR(determinant(volume.geometry.direction), 1.0, 1e-12);
    expect_at(volume, {1, 2, 3}, 0.0f);
    expect_at(volume, {1, 2, 3.5}, 1.0f);
    expect_at(volume, {1.6, 2, 3}, 4.0f);
    expect_at(volume, {1.6, y, 3.5}, 11.0f);
  }
}

TEST_F(VolumeFileGeometry, MetaImageKeepsItsMatrixOffsetAndByteOrder) {
  std::string text =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = True\n"
      "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 7 8 9\nElementSpacing = 0.3 0.4 0.5\n"
      "DimSize = 2 3 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  for (int v = 0; v < 12; ++v) text += std::string{char(0), char(v)};
  const auto volume = read_volume(write("a.mha", text), {}).volume;
  expect_at(volume, {7, 8, 9}, 0.0f);
  expect_at(volume, {7, 8.3, 9}, 1.0f);  // i runs along y
  expect_at(volume, {6.6, 8, 9}, 2.0f);  // j runs along -x
  expect_at(volume, {7, 8, 9.5}, 6.0f);
}

TEST_F(VolumeFileGeometry, AVolumeInCentimetresOrMetresIsBroughtToMillimetresAndTold) {
  const auto scan = [&](const std::string& spacing) {
    return write("a.mha",
                 "ObjectType = Image\nNDims = 3\nBinaryData = True\nOffset = 1 2 3\n"
                 "ElementSpacing = " +
                     spacing +
                     "\nDimSize = 250 250 20\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                     std::string(250 * 250 * 20, 'a'));
  };
  const auto expect = [](const LoadedVolume& loaded, const Vec3& spacing, const Vec3& origin) {
    EXPECT_NEAR(distance(loaded.volume.geometry.spacing, spacing), 0.0, 1e-9);
    EXPECT_NEAR(distance(loaded.volume.geometry.origin, origin), 0.0, 1e-9);
  };
  const auto in_cm = scan("0.04 0.04 0.3");  // 100 mm long, or 10
  const LoadedVolume guessed = read_volume(in_cm, {});
  expect(guessed, {0.4, 0.4, 3.0}, {10, 20, 30});
  EXPECT_THAT(guessed.warnings, Contains(HasSubstr("read in cm: voxels of 0.4 x 0.4 x 3 mm")));
  EXPECT_EQ(inspect(in_cm).front().geometry.spacing.z, guessed.volume.geometry.spacing.z);
  EXPECT_EQ(inspect(in_cm).front().warnings, guessed.warnings);
  expect(read_volume(in_cm, {.unit = LengthUnit::mm}), {0.04, 0.04, 0.3}, {1, 2, 3});
  expect(read_volume(in_cm, {.spacing_mm = {0.04, 0.04, 0.3}}), {0.04, 0.04, 0.3}, {1, 2, 3});
  expect(read_volume(in_cm, {.unit = LengthUnit::inch}), {1.016, 1.016, 7.62}, {25.4, 50.8, 76.2});
  expect(read_volume(scan("0.0004 0.0004 0.003"), {}), {0.4, 0.4, 3.0}, {1000, 2000, 3000});
  const auto frames = read_run(scan("0.04 0.04 0.3"), {}, RunGeometry::given);
  ASSERT_TRUE(frames);  // a detector's pixels are as fine
  EXPECT_NEAR(frames->run.detector_spacing_mm[0], 0.04, 1e-9);
  const LoadedVolume plain = read_volume(scan("0.1 0.1 0.1"), {});
  expect(plain, {0.1, 0.1, 0.1}, {1, 2, 3});
  EXPECT_THAT(plain.warnings, Not(Contains(HasSubstr("read in"))));
}

TEST_F(VolumeFileGeometry, AnotherUnitOverrulesTheFilesAndDicomIsInMillimetres) {
  Nifti nifti;
  nifti.voxel_sizes(300, 400, 500);
  nifti.sform({300, 0, 0, 10000, 0, 400, 0, 20000, 0, 0, 500, 30000});
  nifti.unit(3);  // micrometres
  const auto volume = read_volume(write("a.nii", nifti.file()), {.unit = LengthUnit::mm}).volume;
  EXPECT_NEAR(volume.geometry.spacing.x, 300.0, 1e-9);
  EXPECT_THROW(read_volume(write("a.dcm", "no volume file"), {.unit = LengthUnit::cm}),
               OptionError);
}

TEST_F(VolumeFileGeometry, VtiKeepsItsDirectionAndExtent) {
  const auto volume =
      read_volume(
          write("a.vti",
                "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">"
                "<ImageData WholeExtent=\"2 3 0 1 0 1\" Origin=\"7 8 9\" Spacing=\"0.3 0.4 0.5\" "
                "Direction=\"0 -1 0 1 0 0 0 0 1\"><Piece Extent=\"2 3 0 1 0 1\">"
                "<PointData Scalars=\"a\"><DataArray type=\"Int16\" Name=\"a\" format=\"ascii\">"
                "0 1 2 3 4 5 6 7</DataArray></PointData></Piece></ImageData></VTKFile>"),
          {})
          .volume;
  expect_at(volume, {7, 8.6, 9}, 0.0f);  // the first voxel has index 2 along i, which is y
  expect_at(volume, {7, 8.9, 9}, 1.0f);
  expect_at(volume, {6.6, 8.6, 9}, 2.0f);
  expect_at(volume, {7, 8.6, 9.5}, 4.0f);
}

TEST_F(VolumeFileGeometry, LegacyVtkLiesInPlaceAndGridsAreRefusedByTheirKind) {
  const std::string head = "# vtk DataFile Version 2.0\nby hand\nASCII\nDATASET ";
  const auto volume = read_volume(write("a.vtk", head + "STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"
                                                        "ORIGIN 7 8 9\nASPECT_RATIO 0.3 0.4 0.5\n"
                                                        "POINT_DATA 8\nSCALARS a short\n"
                                                        "LOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n"),
                                  {})
                          .volume;
  expect_at(volume, {7.3, 8, 9}, 1.0f);
  expect_at(volume, {7, 8.4, 9}, 2.0f);
  expect_at(volume, {7, 8, 9.5}, 4.0f);
  EXPECT_THAT(refusal(write("b.vtk", head + "UNSTRUCTURED_GRID\nPOINTS 0 float\n")),
              HasSubstr("UNSTRUCTURED_GRID"));
  EXPECT_THAT(refusal(write("c.vtk", "no VTK file")), HasSubstr("c.vtk"));
}

TEST_F(VolumeFileGeometry, WhatIsNoVolumeOfNumbersIsRefusedByName) {
  const std::string space = "space directions: (1,0,0) (0,1,0) (0,0,1)";
  EXPECT_THAT(refusal(write("flat.nrrd",
                            "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 2 2\n"
                            "spacings: 1 1" +
                                std::string(kNrrdEnd) + "0123")),
              HasSubstr("not three-dimensional"));
  EXPECT_THAT(refusal(write("one.nrrd",
                            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 1\n"
                            "spacings: 1 1 1" +
                                std::string(kNrrdEnd) + "0123")),
              HasSubstr("not three-dimensional"));
  EXPECT_THAT(refusal(write("time.nrrd",
                            "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 2 2 2\n"
                            "spacings: 1 1 1 1" +
                                std::string(kNrrdEnd) + "0123456789abcdef")),
              HasSubstr("several time points"));
  EXPECT_THAT(refusal(write("rgb.nrrd",
                            "NRRD0004\ntype: uint8\ndimension: 4\n"
                            "space: left-posterior-superior\nsizes: 3 2 2 2\n"
                            "space directions: none (1,0,0) (0,1,0) (0,0,1)\n"
                            "kinds: RGB-color domain domain domain" +
                                std::string(kNrrdEnd) + "0123456789abcdef01234567")),
              HasSubstr("3 values per voxel"));
}

TEST_F(VolumeFileGeometry, InfiniteVoxelsAreReplacedAndFilesWithoutAnyNumberRefused) {
  const auto write_values = [&](const std::string& name, float first, float others) {
    std::string text =
        "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)" +
        std::string(kNrrdEnd);
    for (int v = 0; v < 8; ++v)
      text.append(reinterpret_cast<const char*>(v == 0 ? &first : &others), 4);
    return write(name, text);
  };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto loaded = read_volume(write_values("a.nrrd", kInfinity, 5.0f), {});
  EXPECT_EQ(loaded.volume.at(0, 0, 0), 5.0f);
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("1 voxels were not numbers")));
  EXPECT_THAT(refusal(write_values("b.nrrd", kInfinity, -kInfinity)), HasSubstr("no numbers"));
}

TEST_F(VolumeFileGeometry, AFileWithoutAVoxelSizeTakesTheOneGiven) {
  const auto path = write("bare.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2" +
                                           std::string(kNrrdEnd) + "01234567");
  EXPECT_THAT(refusal(path), HasSubstr("--spacing"));
  const auto loaded = read_volume(path, {.spacing_mm = {0.3, 0.4, 0.5}});
  EXPECT_NEAR(distance(loaded.volume.geometry.spacing, {0.3, 0.4, 0.5}), 0.0, 1e-12);
  EXPECT_THAT(loaded.warnings, Contains(HasSubstr("every length rests on that")));
}

TEST_F(VolumeFileGeometry, AHeaderThatAsksForMoreMemoryThanThereIsIsRefused) {
  const auto path = write("huge.nrrd",
                          "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\n"
                          "sizes: 1200 1200 1200\nspace directions: (1,0,0) (0,1,0) (0,0,1)" +
                              std::string(kNrrdEnd) + "0123");
  fs::resize_file(path, 7000000000);  // of holes
  EXPECT_THAT(refusal(path, {.max_memory_gib = 4.0}), HasSubstr("needs 19.31 GiB of memory"));
}

}  // namespace
}  // namespace angio::segmentation
