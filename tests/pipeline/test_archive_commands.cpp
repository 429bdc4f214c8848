#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/child_process.hpp"
#include "dicom/archive.hpp"
#include "run_program.hpp"
#include "tests/dicom/orthanc.hpp"

// A case as DICOM objects, and the way to an archive and back, as a user goes it.
namespace angio::test {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

std::string text_of(const fs::path& file, const DcmTagKey& tag) {
  DcmFileFormat object;
  EXPECT_TRUE(object.loadFile(file.c_str()).good()) << file;
  OFString value;
  object.getDataset()->findAndGetOFString(tag, value);
  return value.c_str();
}

/// A phantom's scan as a patient's, its lumen found, and a report that says something.
class ArchiveCommands : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new CommandFolder;
    const ProgramResult phantom =
        run_program("phantom straight --spacing 0.4 -o " + (*folder_ / "phantom"));
    ASSERT_EQ(phantom.exit_code, 0) << phantom.error;
    scan_ = phantom.out.substr(0, phantom.out.find('\n'));
    for (const fs::path& file : files_of(scan())) {
      DcmFileFormat object;
      if (object.loadFile(file.c_str()).bad()) continue;
      object.getDataset()->putAndInsertString(DCM_PatientName, "SECRET^NAME");
      object.getDataset()->putAndInsertString(DCM_PatientID, "4711");
      ASSERT_TRUE(object.saveFile(file.c_str(), EXS_LittleEndianExplicit).good());
    }
    const ProgramResult run = run_program("run " + scan() + " -o " + case_folder() +
                                          " --name CASE-1 --until segmentation --keep-link");
    ASSERT_EQ(run.exit_code, 0) << run.error;
    write_text_atomically(case_folder() + "/report/index.html",
                          "<html><body><h1>CASE-1</h1><p>a report</p></body></html>");
    write_text_atomically(
        case_folder() + "/metrics.json",
        R"({"status":"done","status_reason":null,"lesion":{"mld_mm":1.25,"mla_mm2":1.5},)"
        R"("balloon":{"peak_pressure_atm":8.0},"peak":{"mld_mm":2.9},"result":{"mld_mm":2.5},)"
        R"("flow":{"vessel":"coronary","ffr_before":0.71,"ffr_after":0.93}})");
  }
  static void TearDownTestSuite() { delete folder_; }

  static const std::string& scan() { return scan_; }
  static std::string case_folder() { return *folder_ / "case"; }
  static std::vector<fs::path> files_of(const std::string& folder) {
    std::vector<fs::path> files;
    if (fs::is_regular_file(folder)) return {folder};
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().extension() != ".json")
        files.push_back(entry.path());
    return files;
  }
  static CommandFolder* folder_;
  static std::string scan_;  ///< what `angio run` takes
};
CommandFolder* ArchiveCommands::folder_ = nullptr;
std::string ArchiveCommands::scan_;

TEST_F(ArchiveCommands, ObjectsNameNobodyUnlessTheyAreAskedTo) {
  const std::string out = *folder_ / "anonymous";
  const ProgramResult result = run_program("convert --to dicom " + case_folder() + " " + out);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::string study = text_of(files_of(scan()).front(), DCM_StudyInstanceUID);
  for (const char* name : {"report.dcm", "measurements.dcm", "lumen.dcm"}) {
    const std::string bytes = read_text(fs::path(out) / name);
    EXPECT_THAT(result.out, HasSubstr(name));
    EXPECT_EQ(text_of(fs::path(out) / name, DCM_PatientName), "CASE-1");
    EXPECT_EQ(bytes.find("SECRET"), std::string::npos) << name;
    EXPECT_EQ(bytes.find(study), std::string::npos) << name;
    EXPECT_EQ(text_of(fs::path(out) / name, DCM_StudyInstanceUID),
              text_of(fs::path(out) / "report.dcm", DCM_StudyInstanceUID));
  }
}

TEST_F(ArchiveCommands, WithTheLinkTheyAreThePatients) {
  const std::string out = *folder_ / "linked";
  const ProgramResult result =
      run_program("convert --to dicom --keep-link " + case_folder() + " " + out);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const fs::path source = files_of(scan()).front();
  for (const char* name : {"report.dcm", "measurements.dcm", "lumen.dcm"}) {
    const fs::path file = fs::path(out) / name;
    EXPECT_EQ(text_of(file, DCM_PatientName), "SECRET^NAME");
    EXPECT_EQ(text_of(file, DCM_PatientID), "4711");
    EXPECT_EQ(text_of(file, DCM_StudyInstanceUID), text_of(source, DCM_StudyInstanceUID));
    EXPECT_NE(read_text(file).find(text_of(source, DCM_SOPInstanceUID)), std::string::npos)
        << name << " refers to the image";
    EXPECT_EQ(fs::status(file).permissions() & fs::perms::all,
              fs::perms::owner_read | fs::perms::owner_write);
  }
  EXPECT_THAT(result.error, Not(HasSubstr("SECRET")));
}

TEST_F(ArchiveCommands, ObjectsPassDciodvfy) {
  if (std::system("command -v dciodvfy > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "dciodvfy (package dicom3tools) is not installed";
  for (const char* link : {"", "--keep-link "}) {
    const std::string out = *folder_ / "judged";
    ASSERT_EQ(run_program("convert --to dicom " + std::string(link) + case_folder() + " " + out)
                  .exit_code,
              0);
    for (const char* name : {"report.dcm", "measurements.dcm", "lumen.dcm"}) {
      const std::string file = (fs::path(out) / name).string();
      EXPECT_GE(std::system(("dciodvfy " + file + " > " + file + ".verdict 2>&1").c_str()), 0);
      EXPECT_THAT(read_text(file + ".verdict"), Not(HasSubstr("Error"))) << name;
    }
  }
}

TEST_F(ArchiveCommands, SendAndFetchAndRunFromAnArchive) {
  if (Orthanc::program().empty()) GTEST_SKIP() << "Orthanc (package orthanc) is not installed";
  const Orthanc archive;
  ASSERT_TRUE(archive.answers());
  const ProgramResult sent = run_program("send " + case_folder() + " --to " + archive.text());
  ASSERT_EQ(sent.exit_code, 0) << sent.error;
  EXPECT_THAT(sent.out, HasSubstr("lumen.dcm sent to ARCHIVE"));

  dicom::send_to_archive(archive.address(), files_of(scan()));
  const std::string study = text_of(files_of(scan()).front(), DCM_StudyInstanceUID);
  const std::string fetched = *folder_ / "fetched";
  const ProgramResult got =
      run_program("fetch " + archive.text() + " --study " + study + " -o " + fetched);
  ASSERT_EQ(got.exit_code, 0) << got.error;
  EXPECT_EQ(files_of(fetched).size(), files_of(scan()).size());
  EXPECT_THAT(got.out + got.error, Not(HasSubstr(study)));

  const std::string again = *folder_ / "again";
  const ProgramResult ran = run_program("run pacs://" + archive.text() + "/" + study + " -o " +
                                        again + " --until segmentation --keep-link");
  ASSERT_EQ(ran.exit_code, 0) << ran.error;
  EXPECT_EQ(read_text(again + "/segmentation/lumen_mask.nrrd"),
            read_text(case_folder() + "/segmentation/lumen_mask.nrrd"));
  EXPECT_THAT(ran.out + ran.error, Not(HasSubstr(study)));
  EXPECT_THAT(read_text(again + "/source.private.json"), HasSubstr("pacs://"));
  EXPECT_THAT(read_text(again + "/run.json"), Not(HasSubstr("pacs")));
}

int count_of(const std::string& part, const std::string& text) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

// Beside the lines of progress.
TEST_F(ArchiveCommands, WhatCannotBeDoneIsOneLineAndItsCode) {
  const std::string bare = *folder_ / "bare";
  ASSERT_EQ(run_program("run " + scan() + " -o " + bare + " --until segmentation").exit_code, 0);
  const std::vector<std::pair<std::string, int>> calls{
      {"send " + case_folder() + " --to nowhere", 64},
      {"send " + case_folder() + " --to PACS@127.0.0.1:1 --timeout 2", 69},
      {"send " + (*folder_ / "none") + " --to PACS@127.0.0.1:1", 66},
      {"send " + bare + " --to PACS@127.0.0.1:1", 66},  // no report
      {"fetch PACS@127.0.0.1:1 -o " + (*folder_ / "x"), 64},
      {"fetch PACS@127.0.0.1:1 --study 1.2 --timeout 2 -o " + (*folder_ / "x"), 69},
      {"run pacs://PACS@127.0.0.1:1 -o " + (*folder_ / "y"), 64},
      {"run pacs://PACS@127.0.0.1:1/1.2 -o " + (*folder_ / "y"), 69},
      {"convert --keep-link " + case_folder() + " " + (*folder_ / "a.pdf"), 64},
      {"convert --to dicom " + scan() + " " + (*folder_ / "z"), 64}};
  for (const auto& [call, code] : calls) {
    const ProgramResult result = run_program(call);
    EXPECT_EQ(result.exit_code, code) << call << "\n" << result.error;
    EXPECT_EQ(count_of("\nangio: ", "\n" + result.error), 1) << call << "\n" << result.error;
  }
  EXPECT_FALSE(fs::exists(*folder_ / "x"));
  write_text_atomically(bare + "/report/index.html", "<html><body><p>x</p></body></html>");
  const ProgramResult unlinked =
      run_program("convert --to dicom --keep-link " + bare + " " + (*folder_ / "w"));
  EXPECT_EQ(unlinked.exit_code, 66);
  EXPECT_THAT(unlinked.error, HasSubstr("--keep-link"));
}

TEST_F(ArchiveCommands, TheReportGoesOntoPaper) {
  const std::string pdf = *folder_ / "report.pdf";
  ASSERT_EQ(run_program("convert " + case_folder() + " " + pdf).exit_code, 0);
  EXPECT_EQ(read_text(pdf).substr(0, 5), "%PDF-");
}

}  // namespace
}  // namespace angio::test
