#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <thread>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "tests/dicom/example_objects.hpp"
#include "tests/dicom/orthanc.hpp"

namespace angio::dicom {
namespace {
using test::Orthanc;
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr const char* kStudy = "1.2.826.0.1.3680043.2.10";

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A slice with pixels, as an archive wants it.
void write_slice(const fs::path& file, const std::string& series, int number,
                 const std::string& study = kStudy) {
  DcmFileFormat object;
  DcmDataset& d = *object.getDataset();
  const std::string uid = series + "." + std::to_string(number);
  d.putAndInsertString(DCM_SOPClassUID, UID_CTImageStorage);
  d.putAndInsertString(DCM_SOPInstanceUID, uid.c_str());
  d.putAndInsertString(DCM_PatientName, "SECRET^NAME");
  d.putAndInsertString(DCM_PatientID, "4711");
  d.putAndInsertString(DCM_AccessionNumber, "A77");
  d.putAndInsertString(DCM_StudyDate, "20200102");
  d.putAndInsertString(DCM_StudyInstanceUID, study.c_str());
  d.putAndInsertString(DCM_SeriesInstanceUID, series.c_str());
  d.putAndInsertString(DCM_Modality, "CT");
  d.putAndInsertUint16(DCM_Rows, 4);
  d.putAndInsertUint16(DCM_Columns, 4);
  d.putAndInsertUint16(DCM_BitsAllocated, 16);
  d.putAndInsertUint16(DCM_BitsStored, 16);
  d.putAndInsertUint16(DCM_HighBit, 15);
  d.putAndInsertUint16(DCM_PixelRepresentation, 0);
  d.putAndInsertUint16(DCM_SamplesPerPixel, 1);
  d.putAndInsertString(DCM_PhotometricInterpretation, "MONOCHROME2");
  const std::vector<Uint16> pixels(16, Uint16(number));
  d.putAndInsertUint16Array(DCM_PixelData, pixels.data(), pixels.size());
  ASSERT_TRUE(object.saveFile(file.c_str(), EXS_LittleEndianExplicit).good());
}

ExitCode code_of(const std::function<void()>& work, std::string* message = nullptr) {
  try {
    work();
  } catch (const Error& error) {
    if (message != nullptr) *message = error.what();
    return error.exit_code();
  }
  return ExitCode::done;
}

class Archive : public testing::Test {
 protected:
  void SetUp() override {
    if (Orthanc::program().empty()) GTEST_SKIP() << "Orthanc (package orthanc) is not installed";
    archive_ = std::make_unique<Orthanc>();
    ASSERT_TRUE(archive_->answers());
  }
  /// Two series of a study, three slices and two.
  void fill() const {
    std::vector<fs::path> files;
    for (int i = 0; i < 5; ++i) {
      files.push_back(folder_ / ("slice" + std::to_string(i)));
      write_slice(files.back(), std::string(kStudy) + (i < 3 ? ".1" : ".2"), i + 1);
    }
    send_to_archive(archive_->address(), files);
  }
  [[nodiscard]] ArchiveLocation location(ArchiveQuery query) const {
    return {archive_->address(), std::move(query)};
  }

  TemporaryFolder folder_;
  std::unique_ptr<Orthanc> archive_;
};

TEST_F(Archive, GivesBackWhatItWasSent) {
  fill();
  const Fetched fetched = fetch_from_archive(location({.study_uid = kStudy}), folder_ / "fetched");
  EXPECT_EQ(fetched.series_count, 2);
  EXPECT_EQ(fetched.object_count, 5);
  for (int i = 1; i <= 5; ++i) {
    const fs::path file = folder_ / ("fetched/00000" + std::to_string(i) + ".dcm");
    DcmFileFormat object;
    ASSERT_TRUE(object.loadFile(file.c_str()).good());
    const Uint16* pixels = nullptr;
    ASSERT_TRUE(object.getDataset()->findAndGetUint16Array(DCM_PixelData, pixels).good());
    EXPECT_EQ(pixels[7], i) << "in the order of their UIDs";
  }
  struct stat status {};
  ASSERT_EQ(stat((folder_ / "fetched").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  ASSERT_EQ(stat((folder_ / "fetched/000001.dcm").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST_F(Archive, FindsAStudyByNumberDateAndSeries) {
  fill();
  EXPECT_EQ(fetch_from_archive(location({.accession_number = "A77"}), folder_ / "a").object_count,
            5);
  EXPECT_EQ(
      fetch_from_archive(location({.study_uid = kStudy, .series_uid = std::string(kStudy) + ".2"}),
                         folder_ / "b")
          .object_count,
      2);
  EXPECT_EQ(fetch_from_archive(location({.patient_id = "4711", .study_date = "20200101-20200131"}),
                               folder_ / "c")
                .object_count,
            5);
  std::string message;
  for (const ArchiveQuery& query :
       {ArchiveQuery{.accession_number = "B"}, ArchiveQuery{.study_uid = "1.2.3"},
        ArchiveQuery{.study_uid = kStudy, .modality = "XA"}}) {
    EXPECT_EQ(code_of([&] { fetch_from_archive(location(query), folder_ / "d"); }, &message),
              ExitCode::no_input);
    EXPECT_FALSE(fs::exists(folder_ / "d"));
    EXPECT_THAT(message, Not(HasSubstr("1.2")));
  }
  write_slice(folder_ / "other", "1.2.826.0.1.3680043.2.11.1", 1, "1.2.826.0.1.3680043.2.11");
  send_to_archive(archive_->address(), {folder_ / "other"});
  EXPECT_EQ(code_of([&] { fetch_from_archive(location({.patient_id = "4711"}), folder_ / "e"); },
                    &message),
            ExitCode::bad_data);
  EXPECT_THAT(message, HasSubstr("2 such studies"));
}

TEST_F(Archive, TakesTheObjectsThatACaseIsWrittenAs) {
  write_encapsulated_pdf(folder_ / "report.dcm", test::example_pdf());
  write_measurement_report(folder_ / "measurements.dcm", test::example_report());
  double last = 0.0;
  send_to_archive(archive_->address(), {folder_ / "report.dcm", folder_ / "measurements.dcm"},
                  Progress([&](double fraction, std::string_view) { last = fraction; }));
  EXPECT_GE(last, 0.0);
  // Sent again, it is the same object: the archive keeps one.
  send_to_archive(archive_->address(), {folder_ / "report.dcm"});
}

TEST_F(Archive, IsNamedWhereItRefusesOrIsNotThere) {
  write_slice(folder_ / "a.dcm", "1.2.3.4", 1);
  const std::vector<fs::path> files{folder_ / "a.dcm"};
  std::string message;
  ArchiveAddress wrong_title = archive_->address();
  wrong_title.ae_title = "NOBODY";
  EXPECT_EQ(code_of([&] { send_to_archive(wrong_title, files); }, &message), ExitCode::unavailable);
  EXPECT_THAT(message, HasSubstr("refuses"));
  ArchiveAddress wrong_port = archive_->address();
  wrong_port.port = 1;
  EXPECT_EQ(code_of([&] { send_to_archive(wrong_port, files); }, &message), ExitCode::unavailable);
  EXPECT_THAT(message, HasSubstr("cannot be reached"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  write_text_atomically(folder_ / "not.dcm", "no DICOM");
  EXPECT_EQ(code_of([&] { send_to_archive(archive_->address(), {folder_ / "not.dcm"}); }),
            ExitCode::bad_data);
}

TEST_F(Archive, FillsNoFolderThatHoldsSomething) {
  fill();
  make_folder(folder_ / "full");
  write_text_atomically(folder_ / "full/mine", "mine");
  EXPECT_EQ(code_of([&] { fetch_from_archive(location({.study_uid = kStudy}), folder_ / "full"); }),
            ExitCode::cannot_create);
  EXPECT_EQ(read_text(folder_ / "full/mine"), "mine");
}

/// A host that takes connections and never says a word.
class SilentHost {
 public:
  SilentHost() : file_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(file_, reinterpret_cast<const sockaddr*>(&place), sizeof place);
    socklen_t size = sizeof place;
    getsockname(file_, reinterpret_cast<sockaddr*>(&place), &size);
    listen(file_, 4);
    port_ = ntohs(place.sin_port);
  }
  ~SilentHost() { close(file_); }
  SilentHost(const SilentHost&) = delete;
  SilentHost& operator=(const SilentHost&) = delete;
  [[nodiscard]] int port() const { return port_; }

 private:
  int file_;
  int port_ = 0;
};

TEST(SilentArchive, IsGivenUpAfterTheTimeout) {
  const TemporaryFolder folder;
  write_slice(folder / "a.dcm", "1.2.3.4", 1);
  const SilentHost host;
  ArchiveAddress address{.ae_title = "PACS", .host = "127.0.0.1", .port = host.port()};
  address.timeout_s = 2.0;
  const auto start = Clock::now();
  EXPECT_EQ(code_of([&] { send_to_archive(address, {folder / "a.dcm"}); }), ExitCode::unavailable);
  EXPECT_LT(seconds_since(start), 30.0);
}

TEST(SilentArchive, IsLeftAtOnceWhenTheUserStops) {
  const TemporaryFolder folder;
  const SilentHost host;
  ArchiveAddress address{.ae_title = "PACS", .host = "127.0.0.1", .port = host.port()};
  const auto start = Clock::now();
  const Progress stop([&](double, std::string_view) {
    if (seconds_since(start) > 0.5) throw Interrupted();
  });
  EXPECT_EQ(code_of([&] {
              fetch_from_archive({address, {.study_uid = "1.2"}}, folder / "scan", stop);
            }),
            ExitCode::interrupted);
  EXPECT_LT(seconds_since(start), address.timeout_s);
  EXPECT_TRUE(fs::is_empty(folder.path())) << "nothing half-fetched is left";
}

}  // namespace
}  // namespace angio::dicom
