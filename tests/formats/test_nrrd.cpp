#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/nrrd.hpp"
#include "testing/viewer/case_folder.hpp"
#include "testing/viewer/shapes.hpp"

namespace angio::formats {
namespace {
using testing::HasSubstr;
using viewer::test::TemporaryFolder;

Volume<float> make_volume() {
  VolumeGeometry grid;
  grid.size = {3, 4, 5};
  grid.spacing = {0.25, 0.5, 2.0};
  grid.origin = {-10.125, 3.5, 77.0};
  grid.direction = Mat3{};
  grid.direction(1, 0) = 1.0;  // i runs to the back, j to the right, k to the head
  grid.direction(0, 1) = -1.0;
  grid.direction(2, 2) = 1.0;
  Volume<float> volume(grid);
  for (std::size_t i = 0; i < volume.values.size(); ++i) volume.values[i] = float(i) / 7.0f;
  return volume;
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
}

std::string packed(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(bytes.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

void expect_nrrd_refused(const std::filesystem::path& path, const std::string& text) {
  write_text_atomically(path, text);
  try {
    read_nrrd(path);
    FAIL() << text.substr(0, 60);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(path.filename().string()));
  }
}

TEST(Nrrd, IsReadAsItIsWritten) {
  const TemporaryFolder folder;
  const Volume<float> volume = make_volume();
  Volume<std::uint8_t> mask(volume.geometry, 0);
  for (std::size_t i = 0; i < mask.values.size(); i += 3) mask.values[i] = 1;
  const std::filesystem::path file = folder / "a.nrrd";
  for (const NrrdEncoding encoding : {NrrdEncoding::raw, NrrdEncoding::gzip}) {
    write_nrrd(file, volume, encoding);
    const Volume<float> back = read_nrrd(file);
    EXPECT_EQ(back.values, volume.values);
    EXPECT_EQ(back.geometry.size, volume.geometry.size);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(back.geometry.origin[axis], volume.geometry.origin[axis]);
      EXPECT_EQ(back.geometry.spacing[axis], volume.geometry.spacing[axis]);
    }
    write_nrrd(file, mask, encoding);
    EXPECT_TRUE(std::equal(mask.values.begin(), mask.values.end(), read_nrrd(file).values.begin()));
  }
}

TEST(Nrrd, ComesBackExactlyWithItsPlace) {
  const TemporaryFolder folder;
  const Volume<float> volume = make_volume();
  viewer::test::write_nrrd(folder / "a.nrrd", volume);
  const Volume<float> back = read_nrrd(folder / "a.nrrd");
  EXPECT_EQ(back.geometry, volume.geometry);
  EXPECT_EQ(back.values, volume.values);
}

TEST(Nrrd, GzipIsUnpacked) {
  const TemporaryFolder folder;
  const Volume<float> volume = make_volume();
  viewer::test::write_nrrd(folder / "a.nrrd", volume);
  std::string text = read_text(folder / "a.nrrd");
  const auto body = text.find("\n\n") + 2;
  text = text.substr(0, body) + packed(text.substr(body));
  replace(text, "encoding: raw", "encoding: gzip");
  write_text_atomically(folder / "b.nrrd", text);
  EXPECT_EQ(read_nrrd(folder / "b.nrrd").values, volume.values);
  expect_nrrd_refused(folder / "c.nrrd", text.substr(0, text.size() - 20));
}

TEST(Nrrd, RasIsTurnedToLps) {
  const TemporaryFolder folder;
  const Volume<float> volume = make_volume();
  viewer::test::write_nrrd(folder / "a.nrrd", volume);
  std::string text = read_text(folder / "a.nrrd");
  replace(text, "left-posterior-superior", "right-anterior-superior");
  write_text_atomically(folder / "b.nrrd", text);
  const VolumeGeometry turned = read_nrrd(folder / "b.nrrd").geometry;
  const Vec3 lps = volume.geometry.lps_from_index({1, 2, 3});
  const Vec3 expected{-lps.x, -lps.y, lps.z};
  EXPECT_NEAR(distance(turned.lps_from_index({1, 2, 3}), expected), 0.0, 1e-12);
}

TEST(Nrrd, DamagedFilesAreRefusedByName) {
  const TemporaryFolder folder;
  viewer::test::write_nrrd(folder / "a.nrrd", make_volume());
  const std::string whole = read_text(folder / "a.nrrd");
  expect_nrrd_refused(folder / "b.nrrd", "a text");
  expect_nrrd_refused(folder / "b.nrrd", whole.substr(0, 80));
  expect_nrrd_refused(folder / "b.nrrd", whole.substr(0, whole.size() - 4));
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"sizes: 3 4 5", "sizes: 99999999 4 5"},
                                                        {"sizes: 3 4 5", "sizes: 999999 999999 5"},
                                                        {"sizes: 3 4 5", "sizes: 3 4"},
                                                        {"dimension: 3", "dimension: 4"},
                                                        {"type: float", "type: block"},
                                                        {"encoding: raw", "encoding: bzip2"},
                                                        {"left-posterior-superior", "scanner-xyz"},
                                                        {"(0,0.25,0)", "(0,0,0)"}}) {
    std::string text = whole;
    replace(text, from, to);
    expect_nrrd_refused(folder / "b.nrrd", text);
  }
}

}  // namespace
}  // namespace angio::formats
