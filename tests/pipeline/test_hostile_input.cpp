#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "pipeline/case/hidden_input.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {
namespace fs = std::filesystem;
using test::ProgramResult;
using test::run_program;

/// Every failure is one line for people, with a documented code, whatever a name holds.
void expect_one_clean_line(const ProgramResult& result, int exit_code) {
  EXPECT_EQ(result.exit_code, exit_code) << result.error;
  EXPECT_EQ(result.error_line_count(), 1) << result.error;
  for (const char letter : result.error)
    EXPECT_TRUE(letter == '\n' || static_cast<unsigned char>(letter) >= 0x20) << result.error;
}

TEST(StrangeNames, CommandNoTerminal) {
  test::CommandFolder folder;
  const std::string path = folder / "\x1b[31mred\r.nrrd";
  write_text_atomically(path, "no NRRD");
  const std::string file = "'" + path + "'";
  const auto inspected = run_program("inspect " + file);
  EXPECT_EQ(inspected.out.find('\x1b'), std::string::npos);
  EXPECT_EQ(inspected.error.find('\x1b'), std::string::npos);
  EXPECT_EQ(inspected.error.find('\r'), std::string::npos);
}

TEST(StrangeNames, ThatAreNotUtf8AreTakenOrRefusedInOneLine) {
  test::CommandFolder folder;
  const std::string path = folder /
                           "Gr\xe4"
                           "f.nrrd";
  write_text_atomically(path, "no NRRD");
  const std::string file = "'" + path + "'";
  expect_one_clean_line(run_program("run " + file + " -o '" + folder / "case" + "'"), 65);
  const auto json = run_program("inspect --json " + file);
  EXPECT_NE(json.exit_code, 70) << json.error;
  const auto named = run_program(
      "run phantom:straight,length=8,spacing=0.8 --until segmentation -o '" + folder / "named" +
      "' --quiet --name 'Gr\xe4"
      "fin'");
  EXPECT_NE(named.exit_code, 70) << named.error;
}

TEST(FileSizeLimit, IsAFullDiskAndNoSignal) {
  test::CommandFolder folder;
  const std::string command =
      "ulimit -f 4; exec '" + std::string(ANGIO_PROGRAM) +
      "' run phantom:straight,length=8,spacing=0.5 --until segmentation -o '" + folder / "case" +
      "' --quiet 2>'" + folder / "error" + "' >/dev/null";
  const int status = std::system(("bash -c \"" + command + "\"").c_str());
  EXPECT_EQ(WEXITSTATUS(status), 74) << test::file_text(folder / "error");
}

/// Waits until a process holds SIGTERM back or catches it: until the program's first instruction
/// the kernel alone can answer.
void wait_for_start(pid_t id) {
  constexpr unsigned long kBit = 1UL << (SIGTERM - 1);
  for (int i = 0; i < 10'000; ++i) {
    std::ifstream status("/proc/" + std::to_string(id) + "/status");
    for (std::string word; status >> word;)
      if (word == "SigBlk:" || word == "SigCgt:") {
        std::string mask;
        status >> mask;
        if ((std::stoul(mask, nullptr, 16) & kBit) != 0) return;
      }
    usleep(1000);
  }
}

/// Starts a run and ends it by a signal, so long after its first instruction.
int exit_code_after(int signal, int milliseconds, const fs::path& folder) {
  const pid_t id = fork();
  if (id == 0) {
    const std::string error = (folder / "error").string();
    if (!std::freopen(error.c_str(), "a", stderr) || !std::freopen("/dev/null", "w", stdout))
      _exit(1);
    const std::string output = (folder / "case").string();
    execl(ANGIO_PROGRAM, ANGIO_PROGRAM, "run", "phantom:straight,length=30,spacing=0.25", "-o",
          output.c_str(), "--quiet", static_cast<char*>(nullptr));
    _exit(1);
  }
  wait_for_start(id);
  usleep(unsigned(milliseconds) * 1000U);
  kill(id, signal);
  int status = 0;
  waitpid(id, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(Interrupts, AreHeardWhileLibrariesAreLoaded) {
  test::CommandFolder folder;
  for (const int signal : {SIGINT, SIGTERM})
    for (const int milliseconds : {0, 20, 50, 100, 200, 600})
      EXPECT_EQ(exit_code_after(signal, milliseconds, folder.path()), 75)
          << milliseconds << " ms, " << test::file_text(folder / "error");
}

TEST(HiddenInput, PathsAndNamesAreGone) {
  test::CommandFolder folder;
  const fs::path scans = folder.path() / "Nachname_Vorname";
  fs::create_directories(scans / "Studie 1");
  fs::create_directories(scans / "Meyer");
  write_text_atomically(scans / "Studie 1" / "IM_Nachname.dcm", "x");
  const std::string input = scans.string();
  EXPECT_EQ(without_input("the folder " + input + " holds no DICOM", input),
            "the folder INPUT holds no DICOM");
  EXPECT_EQ(without_input("cannot read IM_Nachname.dcm (damaged)", input),
            "cannot read FILE (damaged)");
  EXPECT_EQ(without_input(input + "/Studie 1/IM_Nachname.dcm is cut", input + "/"),
            "INPUT/FILE/FILE is cut");
  EXPECT_EQ(without_input(input + "/Meyer: no images", input), "INPUT/FILE: no images");
  EXPECT_EQ(without_input("phantom:straight is none", "phantom:straight"),
            "phantom:straight is none");
}

TEST(HiddenInput, IsAWholeWord) {
  const std::string note = "the inlet is not certain; there is no room in creases";
  EXPECT_EQ(without_input(note, "in"), note);
  EXPECT_EQ(without_input("moved, and corrected", "scans/cor"), "moved, and corrected");
  EXPECT_EQ(without_input("cannot read cor: damaged", "scans/cor"), "cannot read FILE: damaged");
  EXPECT_EQ(without_input("Ase is empty, the phase is not", "Ase"),
            "INPUT is empty, the phase is not");
  EXPECT_EQ(without_input("in/IM_1 is cut; in 'in' there is more, and in x/in/y", "in"),
            "INPUT/IM_1 is cut; in 'INPUT' there is more, and in x/INPUT/y");
  EXPECT_EQ(without_input("cannot read A_Name.raw", "x/A_Name.nhdr"), "cannot read FILE.raw");
  EXPECT_EQ(without_input("cannot read Nachname_2.raw", "Nachname"), "cannot read INPUT_2.raw");
  EXPECT_EQ(without_input("cannot read Carotid.raw. The Carotid is cut", "x/Carotid.nhdr"),
            "cannot read FILE.raw. The Carotid is cut");
  EXPECT_EQ(without_input("1.5 mm, at 12.3 mm; 1/12; x/12/IM_1", "12"),
            "1.5 mm, at 12.3 mm; 1/12; x/INPUT/IM_1");
}

TEST(UnreadableFiles, BesideASeriesStopNobody) {
  if (geteuid() == 0) GTEST_SKIP() << "root reads everything";
  test::CommandFolder folder;
  ASSERT_EQ(run_program("phantom straight --length 8 --spacing 0.8 --format dicom -o '" +
                        folder / "scan" + "'")
                .exit_code,
            0);
  write_text_atomically(fs::path(folder / "scan") / "secret.dcm", "x");
  chmod((fs::path(folder / "scan") / "secret.dcm").c_str(), 0);
  EXPECT_EQ(run_program("run '" + folder / "scan" + "' --until segmentation --quiet -o '" +
                        folder / "case" + "'")
                .exit_code,
            0);
}

}  // namespace
}  // namespace angio::pipeline
