#include <dcmtk/dcmdata/dcddirif.h>
#include <dcmtk/dcmdata/dcrlerp.h>
#include <dcmtk/dcmjpeg/djrplol.h>
#include <dcmtk/dcmjpls/djrparam.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <fstream>
#include <random>

#include "core/atomic_file.hpp"
#include "tests/segmentation/dicom_encoders.hpp"
#include "tests/segmentation/dicom_objects.hpp"

/// The ways in which DICOM arrives: folders, discs, archives, transfer syntaxes.
namespace angio::segmentation {
namespace {
using testing::Contains;
using testing::HasSubstr;

using DicomInput = DicomFolder;

/// Packs named byte strings.
void write_zip(const fs::path& path,
               const std::vector<std::pair<std::string, std::string>>& files) {
  int error = 0;
  zip_t* zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  ASSERT_TRUE(zip);
  for (const auto& [name, bytes] : files) {
    zip_source_t* source = zip_source_buffer(zip, bytes.data(), bytes.size(), 0);
    ASSERT_GE(zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8), 0);
  }
  ASSERT_EQ(zip_close(zip), 0);
}

std::vector<std::pair<std::string, std::string>> bytes_of_folder(const fs::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file())
      files.push_back({entry.path().filename().string(), read_text(entry.path())});
  return files;
}

TEST_F(DicomInput, AZipArchiveIsReadLikeItsFolder) {
  fs::create_directories(file("in"));
  Slice slice;
  for (const E_TransferSyntax syntax :
       {EXS_LittleEndianExplicit, EXS_DeflatedLittleEndianExplicit}) {
    for (int k = 0; k < 5; ++k) {
      slice.position.z = 0.5 * k;
      slice.pixel = [k](int i, int j) { return 100 * k + 5 * j + i; };
      write_slice(file("in/s" + std::to_string(9 - k)), slice, syntax);
    }
    auto files = bytes_of_folder(file("in"));
    files.push_back({"readme.txt", "not a scan, but long enough to be looked at by the reader"});
    write_zip(file("scan.zip"), files);
    const auto packed = read_volume(file("scan.zip"), {});
    const auto unpacked = read_volume(file("in"), {});
    EXPECT_EQ(packed.volume.geometry, unpacked.volume.geometry);
    EXPECT_EQ(packed.volume.values, unpacked.volume.values);
    EXPECT_TRUE(inspect(file("scan.zip"))[0].usable);
  }
}

TEST_F(DicomInput, NamesInAnArchiveReachNoPlaceOnTheDisk) {
  fs::create_directories(file("in/deep"));
  write_series(3, {}, EXS_LittleEndianExplicit, "in/");
  auto files = bytes_of_folder(file("in"));
  files[0].first = "../../escaped";
  files[1].first = "/tmp/angio-escaped";
  write_zip(file("in/deep/scan.zip"), files);
  EXPECT_EQ(read_volume(file("in/deep/scan.zip"), {}).volume.geometry.size[2], 3);
  EXPECT_FALSE(fs::exists(file("escaped")));
  EXPECT_FALSE(fs::exists("/tmp/angio-escaped"));
  EXPECT_EQ(std::distance(fs::directory_iterator(file("in/deep")), {}), 1);
}

TEST_F(DicomInput, AZipBombIsRefused) {
  std::string zeros(std::size_t(200) << 20, '\0');
  std::copy_n("DICM", 4, zeros.begin() + 128);
  write_zip(file("bomb.zip"), {{"a.dcm", zeros}});
  ASSERT_LT(fs::file_size(file("bomb.zip")), std::uintmax_t(1) << 20);
  EXPECT_THAT(refusal_of(file("bomb.zip")), HasSubstr("over 1000 times its size"));
}

TEST_F(DicomInput, ATruncatedOrEmptyArchiveIsRefused) {
  write_series(3, {}, EXS_LittleEndianExplicit, "s");
  const auto files = bytes_of_folder(folder());
  write_zip(file("scan.zip"), files);
  const std::string bytes = read_text(file("scan.zip"));
  for (const std::size_t size : {bytes.size() / 2, bytes.size() - 10, std::size_t(30)}) {
    std::ofstream(file("cut.zip"), std::ios::binary) << bytes.substr(0, size);
    EXPECT_THAT(refusal_of(file("cut.zip")), HasSubstr("zip archive"));
  }
}

TEST_F(DicomInput, ADicomdirLeadsToItsFilesWhateverTheirCase) {
  fs::create_directories(file("IMAGES"));
  Slice slice;
  for (int k = 0; k < 4; ++k) {
    slice.position.z = 0.5 * k;
    slice.number = k + 1;
    slice.more = [](DcmDataset& d) {
      put(d, DCM_StudyID, "1");
      put(d, DCM_StudyDate, "20200101");
      put(d, DCM_StudyTime, "120000");
      put(d, DCM_SeriesNumber, "1");
      put(d, DCM_Modality, "CT");
      put(d, DCM_ImageType, "ORIGINAL\\PRIMARY\\AXIAL");
    };
    write_slice(file("IMAGES/I" + std::to_string(k)), slice);
  }
  OFLog::configure(OFLogger::OFF_LOG_LEVEL);
  DicomDirInterface dicomdir;
  dicomdir.disableConsistencyCheck();
  ASSERT_TRUE(
      dicomdir
          .createNewDicomDir(DicomDirInterface::AP_GeneralPurpose, file("DICOMDIR").c_str(), "TEST")
          .good());
  for (int k = 0; k < 4; ++k)
    ASSERT_TRUE(
        dicomdir.addDicomFile(("IMAGES/I" + std::to_string(k)).c_str(), folder().c_str()).good());
  ASSERT_TRUE(dicomdir.writeDicomDir().good());
  write_slice(file("unlisted"), slice);
  EXPECT_EQ(read_volume(file("DICOMDIR"), {}).volume.geometry.size[2], 4);
  EXPECT_EQ(read_volume(folder(), {}).volume.geometry.size[2], 4) << "the unlisted is a copy";
  fs::rename(file("IMAGES"), file("images"));
  EXPECT_EQ(read_volume(file("DICOMDIR"), {}).volume.geometry.size[2], 4);
  fs::remove(file("images/I3"));
  EXPECT_THAT(read_volume(file("DICOMDIR"), {}).warnings, Contains(HasSubstr("1 of the 4 files")));
  fs::remove_all(file("images"));
  EXPECT_THAT(refusal_of(file("DICOMDIR")), HasSubstr("Copy the whole disc"));
}

TEST_F(DicomInput, ADicomdirCannotLeadOutOfItsFolder) {
  fs::create_directories(file("disc"));
  write_series(3, {}, EXS_LittleEndianExplicit, "OUT");
  fs::create_directory_symlink(folder(), file("disc/LINK"));
  DcmFileFormat dicomdir;
  DcmDataset& d = *dicomdir.getDataset();
  put(d, DCM_SOPClassUID, UID_MediaStorageDirectoryStorage);
  put(d, DCM_SOPInstanceUID, "1.2.3");
  for (const char* id : {"..\\OUT100", "LINK\\OUT99", "\\tmp\\OUT98", "."}) {
    DcmItem* record = nullptr;
    ASSERT_TRUE(d.findOrCreateSequenceItem(DCM_DirectoryRecordSequence, record, -2).good());
    put(*record, DCM_DirectoryRecordType, "IMAGE");
    put(*record, DCM_ReferencedFileID, id);
  }
  ASSERT_TRUE(dicomdir.saveFile(file("disc/DICOMDIR").c_str(), EXS_LittleEndianExplicit).good());
  EXPECT_THAT(refusal_of(file("disc/DICOMDIR")), HasSubstr("none of the files"));
}

TEST_F(DicomInput, LinksPipesAndLoopsInAFolderDoNotStopIt) {
  fs::create_directories(file("series"));
  write_series(3, {}, EXS_LittleEndianExplicit, "series/");
  fs::create_directories(file("in"));
  fs::create_directory_symlink(file("series"), file("in/linked"));
  fs::create_directory_symlink(file("in"), file("in/loop"));
  fs::create_symlink(file("nowhere"), file("in/broken"));
  std::ofstream(file("in/empty")).close();
  ASSERT_EQ(mkfifo(file("in/pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_volume(file("in"), {}).volume.geometry.size[2], 3);
  EXPECT_THAT(refusal_of(file("in/pipe")), HasSubstr("pipe"));
  EXPECT_THAT(refusal_of("/dev/zero"), HasSubstr("device"));
  fs::rename(file("in/pipe"), file("in/pipe.nrrd"));
  EXPECT_THAT(refusal_of(file("in/pipe.nrrd")), HasSubstr("pipe"));
}

TEST_F(DicomInput, FilesThatCannotBeOpenedAreTold) {
  if (geteuid() == 0) GTEST_SKIP() << "root opens every file";
  write_series(3);
  write_series(2, {}, EXS_LittleEndianExplicit, "locked");
  for (const char* name : {"locked100", "locked99"}) fs::permissions(file(name), fs::perms::none);
  EXPECT_THAT(read_volume(folder(), {}).warnings, Contains(HasSubstr("2 files or folders cannot")));
}

TEST_F(DicomInput, PartsOfAConcatenationAreOneVolume) {
  for (int part = 0; part < 2; ++part) {
    EnhancedObject object;
    for (int k = 0; k < 3; ++k) {
      Slice slice;
      slice.sop_class = UID_EnhancedCTImageStorage;
      slice.position.z = 0.3 * (3 * part + k);
      slice.pixel = [=](int, int) { return 3 * part + k; };
      slice.number = part + 1;
      object.frames.push_back(slice);
    }
    object.more = [](DcmDataset& d) { put(d, DCM_ConcatenationUID, "1.2.3.4"); };
    write_enhanced(file(std::to_string(part)), object);
  }
  const auto volume = read_volume(folder(), {}).volume;
  EXPECT_EQ(volume.geometry.size[2], 6);
  EXPECT_EQ(volume.at(0, 0, 5), 5.0f);
}

/// A stack of noise, in which any wrong prediction would show.
Slice noise_slice(bool is_signed, int bits) {
  Slice slice;
  slice.rows = 31;
  slice.columns = 17;
  slice.is_signed = is_signed;
  slice.bits_allocated = bits <= 8 ? 8 : 16;
  slice.bits_stored = bits;
  slice.pixel = [](int i, int j) {
    return int((unsigned(i) * 2654435761u + unsigned(j) * 40503u * unsigned(i + 7)) >> 9);
  };
  return slice;
}

TEST_F(DicomInput, EveryLosslessCompressionGivesTheSamePixels) {
  const Encoders encoders;
  for (const bool is_signed : {false, true})
    for (const int bits : {8, 12, 16}) {
      const Slice slice = noise_slice(is_signed, bits);
      write_series(3, slice);
      const auto expected = read_volume(folder(), {}).volume.values;
      const auto compare = [&](E_TransferSyntax syntax, const DcmRepresentationParameter* how,
                               const std::string& what) {
        write_series(3, slice);
        for (const auto& entry : fs::directory_iterator(folder()))
          recode(entry.path(), syntax, how);
        EXPECT_EQ(read_volume(folder(), {}).volume.values, expected)
            << what << ", " << bits << " bits, signed " << is_signed;
      };
      for (int predictor = 1; predictor <= 7; ++predictor) {
        const DJ_RPLossless how(predictor, 0);
        compare(EXS_JPEGProcess14, &how, "JPEG predictor " + std::to_string(predictor));
      }
      const DJ_RPLossless first_order(1, 0);
      compare(EXS_JPEGProcess14SV1, &first_order, "JPEG first order");
      const DJLSRepresentationParameter jpeg_ls(0, OFTrue);
      compare(EXS_JPEGLSLossless, &jpeg_ls, "JPEG-LS");
      const DcmRLERepresentationParameter rle;
      compare(EXS_RLELossless, &rle, "RLE");
    }
}

// Decoders take what Rows and Columns ask for before they see a stream.
TEST_F(DicomInput, AFewBytesClaimNoGigabytes) {
  const Encoders encoders;
  const DcmRLERepresentationParameter rle;
  const DJLSRepresentationParameter jpeg_ls(0, OFTrue);
  for (const auto& [syntax, how] :
       {std::pair<E_TransferSyntax, const DcmRepresentationParameter*>{EXS_RLELossless, &rle},
        {EXS_JPEGLSLossless, &jpeg_ls}}) {
    write_series(2);
    for (const auto& entry : fs::directory_iterator(folder())) {
      recode(entry.path(), syntax, how);
      DcmFileFormat object;
      ASSERT_TRUE(object.loadFile(entry.path().c_str()).good());
      object.getDataset()->putAndInsertUint16(DCM_Rows, 20000);
      object.getDataset()->putAndInsertUint16(DCM_Columns, 20000);
      ASSERT_TRUE(object.saveFile(entry.path().c_str(), syntax).good());
    }
    EXPECT_THAT(refusal(), HasSubstr("far too short for the pixels"));
  }
}

TEST_F(DicomInput, AnUnknownTransferSyntaxIsNamed) {
  write_series(2);
  for (const auto& entry : fs::directory_iterator(folder())) {
    std::string bytes = read_text(entry.path());
    const std::string syntax = "1.2.840.10008.1.2.1";  // becomes one of the same length
    bytes.replace(bytes.find(syntax), syntax.size(), "1.2.840.10008.9.9.9");
    std::ofstream(entry.path(), std::ios::binary) << bytes;
  }
  EXPECT_THAT(refusal(), HasSubstr("transfer syntax"));
}

TEST_F(DicomInput, MemoryIsAskedForBeforeItIsTaken) {
  Slice slice;
  slice.rows = slice.columns = 64;
  write_series(4, slice);
  EXPECT_THAT(refusal({.max_memory_gib = 1e-5}),
              HasSubstr("GiB of memory, but 1e-05 GiB are allowed"));
  EXPECT_NO_THROW(read_volume(folder(), {.max_memory_gib = 1.0}));
}

TEST(ReadOptions, DefaultsAreValidAndBadOnesAreNamed) {
  EXPECT_NO_THROW(ReadOptions{}.validate());
  EXPECT_THROW((ReadOptions{.spacing_mm = {0.3, 0.3, 0.0}}.validate()), OptionError);
  EXPECT_THROW((ReadOptions{.spacing_mm = {-1, 1, 1}}.validate()), OptionError);
  EXPECT_THROW(ReadOptions{.max_memory_gib = -1}.validate(), OptionError);
}

}  // namespace
}  // namespace angio::segmentation
