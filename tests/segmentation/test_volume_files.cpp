#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkXMLImageDataWriter.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/nrrd.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/temporary_folder.hpp"
#include "tests/segmentation/tiff_stack.hpp"

namespace angio::segmentation {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

class VolumeFiles : public testing::Test {
 protected:
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
  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
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

/// @param window_bits  as zlib has them: 15 for its own format, 31 for gzip
std::string compressed(const std::string& bytes, int window_bits) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, uLong(bytes.size())), '\0');
  std::string in = bytes;
  stream.next_in = reinterpret_cast<unsigned char*>(in.data());
  stream.avail_in = unsigned(in.size());
  stream.next_out = reinterpret_cast<unsigned char*>(out.data());
  stream.avail_out = unsigned(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string nifti_of(const Volume<float>& volume) {
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t place, auto value) {
    std::memcpy(&bytes[place], &value, sizeof value);
  };
  put(0, std::int32_t(348));
  put(40, std::int16_t(3));
  for (std::size_t a = 0; a < 3; ++a) {
    put(42 + 2 * a, std::int16_t(volume.geometry.size[a]));
    put(80 + 4 * a, 0.5f);
  }
  put(70, std::int16_t(16));
  put(108, 352.0f);
  put(344, std::array<char, 4>{'n', '+', '1', '\0'});
  return bytes + std::string(reinterpret_cast<const char*>(volume.values.data()),
                             volume.values.size() * sizeof(float));
}

std::string vti_of(const Volume<float>& volume, int mode, bool compress) {
  vtkNew<vtkImageData> image;
  const auto& size = volume.geometry.size;
  image->SetDimensions(size[0], size[1], size[2]);
  image->AllocateScalars(VTK_FLOAT, 1);
  std::copy(volume.values.begin(), volume.values.end(),
            static_cast<float*>(image->GetScalarPointer()));
  vtkNew<vtkXMLImageDataWriter> writer;
  writer->SetDataMode(mode);
  writer->EncodeAppendedDataOff();
  if (!compress) writer->SetCompressorTypeToNone();
  writer->SetInputData(image);
  writer->WriteToOutputStringOn();
  writer->Write();
  return writer->GetOutputString();
}

TEST_F(VolumeFiles, NrrdComesBackAsWritten) {
  const auto volume = oblique_volume();
  formats::write_nrrd(file("a.nrrd"), volume);
  const auto back = read_volume_file(file("a.nrrd"));
  expect_same_geometry(back.geometry, volume.geometry);
  EXPECT_EQ(back.values, volume.values);
}

/// Directions differ in their last bits: the guarded reader makes axes orthogonal again.
TEST_F(VolumeFiles, OurOwnNrrdReaderAgreesWithTheGuardedOne) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 5; ++trial) {
    Volume<float> volume = oblique_volume();
    const Vec3 i = normalized(Vec3{normal(random), normal(random), normal(random)});
    const Vec3 k = normalized(cross(i, Vec3{normal(random), normal(random), normal(random)}));
    const Vec3 j = cross(k, i);
    for (int row = 0; row < 3; ++row) {
      volume.geometry.direction(row, 0) = i[row];
      volume.geometry.direction(row, 1) = j[row];
      volume.geometry.direction(row, 2) = k[row];
    }
    formats::write_nrrd(file("a.nrrd"), volume);
    const Volume<float> ours = formats::read_nrrd(file("a.nrrd"));
    const Volume<float> guarded = read_volume_file(file("a.nrrd"));
    EXPECT_EQ(ours.values, guarded.values);
    expect_same_geometry(ours.geometry, guarded.geometry);
  }
}

TEST_F(VolumeFiles, NrrdIsLpsGzipAndTheSameBytesEachTime) {
  Volume<std::uint8_t> mask(oblique_volume().geometry, 1);
  formats::write_nrrd(file("a.nrrd"), mask);
  formats::write_nrrd(file("b.nrrd"), mask);
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
  std::ofstream(file("nowhere.nrrd"), std::ios::binary)
      << head << "space directions: (1,0,0) (0,1,0) (0,0,1)\n\n01234567";
  EXPECT_THAT(error_of(file("nowhere.nrrd")).what(), HasSubstr("\"space dimension: 3\""));
  std::ofstream(file("bare.mha"), std::ios::binary)
      << "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
         "ElementDataFile = LOCAL\n01234567";
  EXPECT_THAT(error_of(file("bare.mha")).what(), HasSubstr("states no voxel spacing"));
}

TEST_F(VolumeFiles, ATiffStackIsReadWithTheSpacingThatIsGiven) {
  const std::string bytes = tests::tiff_stack(5, 4, 3);
  std::ofstream(file("stack.tif"), std::ios::binary) << bytes;
  EXPECT_THAT(error_of(file("stack.tif")).what(), HasSubstr("no TIFF file does"));
  ReadOptions options;
  options.spacing_mm = {0.4, 0.5, 0.6};
  const auto volume = read_volume(file("stack.tif"), options).volume;
  EXPECT_EQ(volume.geometry.size, (std::array{5, 4, 3}));
  EXPECT_DOUBLE_EQ(volume.geometry.spacing.y, 0.5);
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i) EXPECT_EQ(volume.at(i, j, k), float(1000 * k + 10 * j + i));
  // Cut within its last page, and no TIFF at all.
  std::ofstream(file("cut.tif"), std::ios::binary) << bytes.substr(0, bytes.size() - 12);
  EXPECT_THROW(read_volume(file("cut.tif"), options), InputError);
  std::ofstream(file("words.tif")) << "not a volume\n";
  EXPECT_THROW(read_volume(file("words.tif"), options), InputError);
}

TEST_F(VolumeFiles, WhatIsNoVolumeButIsNamedForOneIsCalledSo) {
  for (const char* name : {"words.nrrd", "words.mha"}) {
    std::ofstream(file(name)) << "not a volume\n";
    EXPECT_THAT(error_of(file(name)).what(), HasSubstr(std::string(name) + " is no "));
  }
}

TEST_F(VolumeFiles, DamagedFilesAreRefusedWithOneLine) {
  formats::write_nrrd(file("whole.nrrd"), oblique_volume());
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

/// A file of VTK's legacy format, 20 x 15 x 10 points, up to its values.
std::string legacy_vtk(const std::string& encoding, const std::string& values) {
  return "# vtk DataFile Version 3.0\nmade by hand\n" + encoding +
         "\nDATASET STRUCTURED_POINTS\nDIMENSIONS 20 15 10\nORIGIN 1 2 3\nSPACING 0.5 0.5 0.5\n" +
         values;
}

std::string big_endian(const std::vector<float>& values) {
  std::string bytes;
  for (const float value : values) {
    std::string of_one(reinterpret_cast<const char*>(&value), sizeof value);
    bytes.append(of_one.rbegin(), of_one.rend());
  }
  return bytes;
}

/// Every way in which a volume file may end before its time.
std::vector<std::size_t> places_to_cut(std::size_t size) {
  std::vector<std::size_t> places{1, size / 2, size - 1, size - 2, size - 4, size - 9, size - 33};
  for (std::size_t n = 1; n < 40; ++n) places.push_back(n * size / 40);
  std::erase_if(places, [&](std::size_t place) { return place == 0 || place >= size; });
  return places;
}

TEST_F(VolumeFiles, NoneIsReadThatIsTruncatedAnywhere) {
  Volume<float> volume = oblique_volume();
  volume.geometry.size = {20, 15, 10};
  volume.values.resize(3000);
  for (std::size_t v = 0; v < 3000; ++v) volume.values[v] = float(v * 7919 % 1013);
  const std::string voxels(reinterpret_cast<const char*>(volume.values.data()), 12000);
  std::string written;
  for (const float value : volume.values) written += std::to_string(int(value)) + "\n";
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 20 15 10\n"
      "ElementSpacing = 0.5 0.5 0.5\nElementType = MET_FLOAT\n";
  const std::string nrrd =
      "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 20 15 10\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nendian: little\n";
  formats::write_nrrd(file("gzip.nrrd"), volume);
  const std::string zlib = compressed(voxels, 15);
  const std::map<std::string, std::string> whole{
      {"gzip.nrrd", read_text(file("gzip.nrrd"))},
      {"raw.nrrd", nrrd + "encoding: raw\n\n" + voxels},
      {"text.nrrd", nrrd + "encoding: ascii\n\n" + written},
      {"raw.mha", meta + "BinaryData = True\nElementDataFile = LOCAL\n" + voxels},
      {"zlib.mha", meta + "BinaryData = True\nCompressedData = True\nCompressedDataSize = " +
                       std::to_string(zlib.size()) + "\nElementDataFile = LOCAL\n" + zlib},
      {"text.mha", meta + "BinaryData = False\nElementDataFile = LOCAL\n" + written},
      {"raw.nii", nifti_of(volume)},
      {"gzip.nii.gz", compressed(nifti_of(volume), 31)},
      {"raw.vti", vti_of(volume, vtkXMLWriter::Appended, false)},
      {"zlib.vti", vti_of(volume, vtkXMLWriter::Appended, true)},
      {"inline.vti", vti_of(volume, vtkXMLWriter::Binary, true)},
      {"text.vti", vti_of(volume, vtkXMLWriter::Ascii, false)},
      {"text.vtk",
       legacy_vtk("ASCII", "POINT_DATA 3000\nSCALARS a float\nLOOKUP_TABLE default\n") + written},
      {"field.vtk", legacy_vtk("ASCII", "POINT_DATA 3000\nFIELD f 1\na 1 3000 float\n") + written},
      {"raw.vtk",
       legacy_vtk("BINARY", "POINT_DATA 3000\nSCALARS a float 1\nLOOKUP_TABLE default\n") +
           big_endian(volume.values) + "\n"}};
  for (const auto& [name, bytes] : whole) {
    std::ofstream(file(name), std::ios::binary) << bytes;
    EXPECT_EQ(read_volume(file(name), {}).volume.values, volume.values) << name;
    for (const std::size_t place : places_to_cut(bytes.size())) {
      if (bytes.find_first_not_of(" \n", place) == std::string::npos) continue;  // only blanks lost
      std::ofstream(file(name), std::ios::binary) << bytes.substr(0, place);
      EXPECT_THROW(read_volume(file(name), {}), InputError)
          << name << ": " << place << " of " << bytes.size() << " bytes were read as if whole";
    }
  }
}

TEST_F(VolumeFiles, NoneIsReadWhoseOwnFileOfVoxelsIsTruncatedOrMissing) {
  const std::string voxels(std::size_t(4 * 4 * 4), 'x');
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\n"
      "ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = ";
  std::ofstream(file("one.mhd")) << meta << "voxels.raw\n";
  std::ofstream(file("list.mhd")) << meta << "LIST\ns1.raw\ns2.raw\ns3.raw\ns4.raw\n";
  std::ofstream(file("numbered.mhd")) << meta << "s%d.raw 1 4 1\n";
  std::ofstream(file("one.nhdr"))
      << "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\n"
         "encoding: raw\ndata file: voxels.raw\n";
  const auto write = [&](const std::string& name, std::size_t count) {
    std::ofstream(file(name), std::ios::binary) << voxels.substr(0, count);
  };
  write("voxels.raw", 64);
  for (const char* slice : {"s1.raw", "s2.raw", "s3.raw", "s4.raw"}) write(slice, 16);
  const auto names = {"one.mhd", "one.nhdr", "list.mhd", "numbered.mhd"};
  for (const char* name : names)
    EXPECT_EQ(read_volume(file(name), {}).volume.values, std::vector<float>(64, float('x')))
        << name;
  write("voxels.raw", 63);
  write("s3.raw", 15);
  for (const char* name : names) EXPECT_THAT(error_of(file(name)).what(), HasSubstr("truncated"));
  fs::remove(file("voxels.raw"));
  fs::remove(file("s3.raw"));
  for (const char* name : names) error_of(file(name));
}

TEST_F(VolumeFiles, NoneTakesItsVoxelsFromElsewhere) {
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\n"
      "ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = ";
  const std::string nrrd =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\n";
  fs::create_directory(file("inner"));
  std::ofstream(file("voxels.raw")) << "12345678";
  for (const std::string& from :
       {file("voxels.raw").string(), std::string("../../etc/passwd"),
        std::string("inner/../voxels.raw"), std::string("LIST\n/etc/passwd"),
        std::string("/dev/zero"), std::string("inner")}) {
    std::ofstream(file("a.mhd")) << meta << from << "\n";
    EXPECT_THAT(error_of(file("a.mhd")).what(), HasSubstr("beside its header")) << from;
    std::ofstream(file("a.nhdr")) << nrrd << "data file: " << from << "\n\n";
    EXPECT_THAT(error_of(file("a.nhdr")).what(), HasSubstr("beside its header")) << from;
  }
}

TEST_F(VolumeFiles, InspectRefusesWhatIsShorterThanItsHeaderSays) {
  std::ofstream(file("cut.mha"), std::ios::binary)
      << "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementSpacing = 1 1 1\n"
         "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n0123456789";
  const auto all = inspect(file("cut.mha"));
  ASSERT_EQ(all.size(), 1u);
  EXPECT_FALSE(all[0].usable);
  EXPECT_THAT(all[0].verdict, HasSubstr("truncated"));
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
  formats::write_nrrd(file("a.nrrd"), oblique_volume());
  const auto found = inspect(file("a.nrrd"));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].usable);
  EXPECT_EQ(found[0].key, "NRRD");
  EXPECT_EQ(found[0].geometry.size, oblique_volume().geometry.size);
}

TEST_F(VolumeFiles, ValuesThatAreNoNumbersAreReplacedAndTold) {
  auto volume = oblique_volume();
  volume.at(1, 1, 1) = std::numeric_limits<float>::quiet_NaN();
  formats::write_nrrd(file("nan.nrrd"), volume);
  const auto loaded = read_volume(file("nan.nrrd"), {});
  EXPECT_TRUE(std::isfinite(loaded.volume.at(1, 1, 1)));
  EXPECT_EQ(loaded.warnings.size(), 1u);
}

}  // namespace
}  // namespace angio::segmentation
