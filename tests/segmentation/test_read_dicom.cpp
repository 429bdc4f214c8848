#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "segmentation/detail/dicom_pixels.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/with_data.hpp"
#include "tests/segmentation/dicom_objects.hpp"

namespace angio::segmentation {
namespace {
using testing::HasSubstr;

using ReadDicom = DicomFolder;

TEST_F(ReadDicom, KeepsGeometryAndValuesInEveryUncompressedSyntax) {
  for (E_TransferSyntax syntax : {EXS_LittleEndianExplicit, EXS_LittleEndianImplicit,
                                  EXS_BigEndianExplicit, EXS_DeflatedLittleEndianExplicit}) {
    Slice slice;
    slice.slope = 2.0;
    slice.intercept = -1024.0;
    write_series(4, slice, syntax);
    const auto loaded = read_volume(folder(), {});
    const auto& g = loaded.volume.geometry;
    EXPECT_EQ(g.size, (std::array<int, 3>{5, 6, 4}));
    EXPECT_DOUBLE_EQ(g.spacing.x, 0.4);
    EXPECT_DOUBLE_EQ(g.spacing.y, 0.6);
    EXPECT_DOUBLE_EQ(g.spacing.z, 0.5);
    EXPECT_EQ(g.origin, (Vec3{-1, -2, 0}));
    EXPECT_EQ(loaded.volume.at(0, 0, 0), 2.0f * 100.0f - 1024.0f);
    EXPECT_EQ(loaded.volume.at(1, 2, 3), 2.0f * 111.0f - 1024.0f);
  }
}

TEST_F(ReadDicom, ExtendsTheSignOfTwelveBits) {
  Slice slice;
  slice.is_signed = true;
  slice.pixel = [](int i, int) { return i - 2; };
  write_series(3, slice);
  const auto volume = read_volume(folder(), {}).volume;
  EXPECT_EQ(volume.at(0, 0, 0), -2.0f);
  EXPECT_EQ(volume.at(3, 0, 0), 1.0f);
}

TEST_F(ReadDicom, AppliesEachSlicesOwnRescale) {
  for (int k = 0; k < 3; ++k) {
    Slice slice;
    slice.position.z = 0.5 * k;
    slice.slope = 1.0 + k;
    write_slice(file(std::to_string(k)), slice);
  }
  const auto volume = read_volume(folder(), {}).volume;
  for (int k = 0; k < 3; ++k) EXPECT_EQ(volume.at(0, 0, k), 100.0f * float(1 + k));
}

TEST_F(ReadDicom, InvertsMonochrome1AndSaysSo) {
  Slice slice;
  slice.photometric = "MONOCHROME1";
  write_series(3, slice);
  const auto loaded = read_volume(folder(), {});
  EXPECT_EQ(loaded.volume.at(0, 0, 0), 4095.0f - 100.0f);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_THAT(loaded.warnings[0], HasSubstr("MONOCHROME1"));
}

TEST_F(ReadDicom, RefusesLossyPixelsUnlessAllowed) {
  Slice slice;
  slice.lossy = "01";
  write_series(3, slice);
  EXPECT_THAT(refusal(), HasSubstr("--allow-lossy"));
  EXPECT_NO_THROW(read_volume(folder(), {.series = "", .allow_lossy = true}));
}

TEST_F(ReadDicom, TakesTheLargestSeriesAndNamesTheOthers) {
  write_series(3);
  Slice large;
  large.series = "1.2.826.0.1.3680043.2.200";
  large.rows = 12;
  write_series(4, large, EXS_LittleEndianExplicit, "b");
  Slice run;
  run.series = "1.2.826.0.1.3680043.2.300";
  run.sop_class = UID_XRayAngiographicImageStorage;
  run.rows = 40;
  write_series(5, run, EXS_LittleEndianExplicit, "c");
  const auto loaded = read_volume(folder(), {});
  EXPECT_EQ(loaded.volume.geometry.size, (std::array<int, 3>{5, 12, 4}));
  EXPECT_EQ(loaded.warnings.size(), 2u);
  // Every series can be chosen by its number and by its key.
  const auto listed = inspect(folder());
  ASSERT_EQ(listed.size(), 3u);
  EXPECT_FALSE(listed[0].usable);
  EXPECT_EQ(read_volume(folder(), {.series = "3"}).volume.geometry.size[2], 3);
  EXPECT_EQ(read_volume(folder(), {.series = listed[2].key}).volume.geometry.size[2], 3);
  EXPECT_THAT(refusal({.series = "9"}), HasSubstr("there is no series"));
}

TEST_F(ReadDicom, RefusesASecondaryCaptureWithoutGeometryAndAnAnonymisedSeries) {
  Slice slice;
  slice.has_geometry = false;
  write_series(3, slice);
  EXPECT_THAT(refusal(), HasSubstr("is missing"));
  slice.sop_class = UID_SecondaryCaptureImageStorage;
  write_series(3, slice);
  EXPECT_THAT(refusal(), HasSubstr("secondary capture without geometry"));
}

TEST_F(ReadDicom, RefusesADamagedSliceAtTheEndOfAStack) {
  write_series(4);
  const fs::path last = folder() / "a97";
  fs::resize_file(last, fs::file_size(last) - 20);
  const std::string text = refusal();
  EXPECT_THAT(text, HasSubstr("in file 2 of 4 by name"));
  EXPECT_EQ(text.find("a97"), std::string::npos) << "file names may hold a patient's name";
  EXPECT_EQ(text.find('\n'), std::string::npos);
}

TEST_F(ReadDicom, TellsNoIdentityAnywhere) {
  write_series(3);
  Slice other;
  other.pixel = [](int, int) { return 7; };
  write_slice(folder() / "double", other, EXS_LittleEndianExplicit);
  const std::string text = refusal();
  EXPECT_THAT(text, HasSubstr("repeats a position"));
  for (const char* secret : {"SECRET", "1.2.826"})
    EXPECT_EQ(text.find(secret), std::string::npos) << text;
  for (const auto& series : inspect(folder()))
    for (const auto& field : {series.key, series.kind, series.verdict})
      EXPECT_EQ(field.find("1.2.826"), std::string::npos);
}

TEST_F(ReadDicom, ReadsFilesWithoutPreamble) {
  write_series(3);
  for (const auto& entry : fs::directory_iterator(folder())) {
    DcmFileFormat file;
    ASSERT_TRUE(file.loadFile(entry.path().c_str()).good());
    file.getDataset()->loadAllDataIntoMemory();
    ASSERT_TRUE(file.saveFile(entry.path().c_str(), EXS_LittleEndianImplicit, EET_ExplicitLength,
                              EGL_recalcGL, EPD_withoutPadding, 0, 0, EWM_dataset)
                    .good());
  }
  EXPECT_EQ(read_volume(folder(), {}).volume.geometry.size[2], 3);
}

TEST_F(ReadDicom, SurvivesTruncatedAndScrambledFiles) {
  write_series(3);
  const std::string whole = read_text(folder() / "a99");
  std::mt19937 random(11);
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = whole;
    if (trial % 3 == 0) bytes.resize(random() % whole.size());
    for (int b = 0; trial % 3 != 0 && b < 4; ++b)
      bytes[132 + random() % (whole.size() - 132)] = char(random());
    std::ofstream(folder() / "a99", std::ios::binary) << bytes;
    try {
      const auto loaded = read_volume(folder(), {});
      EXPECT_GT(loaded.volume.values.size(), 0u);
    } catch (const Error& error) {
      EXPECT_NE(error.exit_code(), ExitCode::internal) << error.what();
    }
  }
}

detail::DicomHeader header_of(const fs::path& path) {
  const auto headers = detail::read_dicom_headers({{path, -1}});
  EXPECT_EQ(headers.size(), 1u);
  return headers.empty() ? detail::DicomHeader{} : headers.front();
}

/// Every pixel of an object, whatever its kind.
std::vector<float> decode_all(const fs::path& path) {
  const auto header = header_of(path);
  if (!header.problem.empty()) throw InputError(header.problem);
  std::vector<detail::SliceReference> members;
  for (int f = 0; f < int(header.frames.size()); ++f) members.push_back({0, f});
  return detail::decode_frames({header}, members);
}

/// Real and made-up objects that are not part of the repository.
using ReadDicomData = angio::test::WithData;

TEST_F(ReadDicomData, NoTrapGivesASilentlyWrongMillimetre) {
  struct Trap {
    const char* name;
    double spacing_z;  ///< 0: it must be refused
  };
  for (const Trap& trap :
       {Trap{"x3_ok.dcm", 0.3}, Trap{"x3_rev.dcm", 0.3}, Trap{"x3_jitter.dcm", 0.3},
        Trap{"x3_framesc.dcm", 0.3}, Trap{"x3_nosc.dcm", 0.3}, Trap{"series_ok", 0.5},
        Trap{"series_rescale_vary", 0.5}, Trap{"x3_gap.dcm", 0}, Trap{"series_missing_mid", 0},
        Trap{"series_missing_second", 0},
        Trap{"series_tilt", 0.5 * std::cos(20.0 * units::kPi / 180.0)}, Trap{"series_dup", 0.5},
        Trap{"enhxa.dcm", 0}, Trap{"xa_frametime.dcm", 0}, Trap{"xa_noptr.dcm", 0},
        Trap{"xa_pixelspacing.dcm", 0}, Trap{"xa_ptr_missing.dcm", 0}, Trap{"xa_vector.dcm", 0}}) {
    const fs::path path = data("dicom-traps") / trap.name;
    if (trap.spacing_z == 0.0) {
      EXPECT_THROW(read_volume(path, {}), InputError) << trap.name;
      continue;
    }
    const auto volume = read_volume(path, {}).volume;
    EXPECT_NEAR(volume.geometry.spacing.z, trap.spacing_z, 2e-4) << trap.name;
    EXPECT_NEAR(determinant(volume.geometry.direction), 1.0, 1e-12) << trap.name;
  }
}

TEST_F(ReadDicomData, ProjectionRunsAreNamedAsSuch) {
  try {
    read_volume(data("dicom-traps/xa_frametime.dcm"), {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("rotational run"));
    EXPECT_EQ(error.exit_code(), ExitCode::bad_data);
  }
}

TEST_F(ReadDicomData, LosslessCodecsDecodeToTheUncompressedPixels) {
  const auto decoded = [&](const std::string& name) {
    return decode_all(data("dicom-codecs") / name);
  };
  const auto reference = decoded("XA1_UNC");
  for (const char* name : {"XA1_RLE", "XA1_JPLL", "XA1_JLSL", "XA1_J2KR"})
    EXPECT_EQ(decoded(name), reference) << name;
}

TEST_F(ReadDicomData, LossyCodecsAreKnownAsLossy) {
  for (const char* name : {"XA1_J2KI", "XA1_JLSN", "XA1_JPLY"})
    EXPECT_TRUE(header_of(data("dicom-codecs") / name).lossy) << name;
  for (const char* name : {"XA1_UNC", "XA1_RLE", "XA1_JPLL", "XA1_JLSL", "XA1_J2KR"})
    EXPECT_FALSE(header_of(data("dicom-codecs") / name).lossy) << name;
}

TEST_F(ReadDicomData, AStreamThatLostSomethingIsKnownEvenIfItsHeaderDeniesIt) {
  const fs::path file = fs::temp_directory_path() / ("angio-denied-" + std::to_string(getpid()));
  DcmFileFormat object;
  ASSERT_TRUE(object.loadFile(data("dicom-codecs/XA1_J2KI").c_str()).good());
  object.loadAllDataIntoMemory();
  put(*object.getDataset(), DCM_LossyImageCompression, "00");
  ASSERT_TRUE(object.saveFile(file.c_str(), object.getDataset()->getOriginalXfer()).good());
  EXPECT_TRUE(header_of(file).lossy);
  fs::remove(file);
}

TEST_F(ReadDicomData, DamagedStreamsNeverTakeTheProgramDown) {
  const fs::path file = fs::temp_directory_path() / ("angio-stream-" + std::to_string(getpid()));
  std::mt19937 random(5);
  for (const char* name : {"XA1_RLE", "XA1_JPLL", "XA1_JLSL", "XA1_J2KR"}) {
    const std::string whole = read_text(data("dicom-codecs") / name);
    for (int trial = 0; trial < 6; ++trial) {
      std::string bytes = whole;
      if (trial == 0) bytes.resize(whole.size() / 2);
      for (int b = 0; trial > 0 && b < 20; ++b)
        bytes[whole.size() / 4 + random() % (whole.size() / 2)] = char(random());
      std::ofstream(file, std::ios::binary) << bytes;
      try {
        decode_all(file);
      } catch (const InputError&) {
      }
    }
  }
  fs::remove(file);
}

}  // namespace
}  // namespace angio::segmentation
