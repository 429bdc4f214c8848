#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "run_program.hpp"

namespace angio::test {
namespace {

namespace fs = std::filesystem;

/// A failure prints one line, returns its code, and leaves nothing in `folder` but what was there.
void expect_failure(const std::string& arguments, int exit_code, const std::string& hint,
                    const CommandFolder& folder) {
  const auto count = [&] {
    return std::distance(fs::recursive_directory_iterator(folder.path()),
                         fs::recursive_directory_iterator());
  };
  const auto before = count();
  const ProgramResult result = run_program(arguments);
  EXPECT_EQ(result.exit_code, exit_code) << arguments << "\n" << result.error;
  EXPECT_EQ(result.error_line_count(), 1) << arguments << "\n" << result.error;
  EXPECT_NE(result.error.find(hint), std::string::npos) << arguments << "\n" << result.error;
  EXPECT_EQ(count(), before) << arguments << " left something behind";
}

TEST(CommandLine, HelpAndVersionAreResults) {
  EXPECT_EQ(run_program("--help").exit_code, 0);
  EXPECT_NE(run_program("run --help").out.find("--from"), std::string::npos);
  EXPECT_EQ(run_program("--version").out.rfind("angio ", 0), 0u);
}

TEST(CommandLine, EveryCommandOfTheContractHasHelp) {
  for (const char* command : {"run", "inspect", "segment", "centerline", "mesh", "simulate",
                              "report", "view", "film", "fit", "convert", "figure", "phantom",
                              "batch", "sweep", "recommend", "verify", "doctor", "inflate"})
    EXPECT_EQ(run_program(std::string(command) + " --help").exit_code, 0) << command;
}

TEST(CommandLine, HelpOfRunIsGroupedAndOnlyItListsThePresets) {
  const std::string run = run_program("run --help").out;
  const std::size_t input = run.find("\nInput:"), treatment = run.find("\nTreatment:"),
                    output = run.find("\nOutput:");
  ASSERT_NE(std::max({input, treatment, output}), std::string::npos) << run;
  EXPECT_NE(run.find("--series", input), std::string::npos);
  EXPECT_NE(run.find("--balloon", treatment), std::string::npos);
  EXPECT_NE(run.find("--keep-link", output), std::string::npos);
  EXPECT_NE(run.find("paper-ytype"), std::string::npos);
  for (const char* command : {"segment", "centerline", "mesh", "simulate", "report", "batch"})
    EXPECT_EQ(run_program(std::string(command) + " --help").out.find("paper-"), std::string::npos)
        << command;
}

// The words of a command's --help that begin with a dash or stand at its place.
std::vector<std::string> long_options(const std::string& help) {
  std::vector<std::string> names;
  std::istringstream words(help);
  for (std::string word; std::getline(words, word, '\n');) {
    const std::size_t begin = word.find("--"), end = word.find_first_of(" ,", begin);
    if (word.starts_with("  -") && begin != std::string::npos)
      names.push_back(word.substr(begin, end - begin));
  }
  return names;
}

TEST(CommandLine, CompletionAndManualKnowEveryOption) {
  const std::string bash = run_program("completion bash").out,
                    zsh = run_program("completion zsh").out,
                    fish = run_program("completion fish").out, manual = run_program("manual").out;
  for (const char* command : {"run", "inspect", "segment", "view", "film", "figure", "convert",
                              "phantom", "batch", "sweep", "recommend", "verify", "inflate"}) {
    const std::vector<std::string> names =
        long_options(run_program(std::string(command) + " --help").out);
    ASSERT_FALSE(names.empty()) << command;
    for (const std::string& name : names) {
      EXPECT_NE(bash.find(" " + name), std::string::npos) << command << " " << name;
      EXPECT_NE(zsh.find("'" + name + ":"), std::string::npos) << command << " " << name;
      EXPECT_NE(fish.find("-l " + name.substr(2) + " "), std::string::npos) << name;
      std::string escaped;
      for (const char c : name) escaped += c == '-' ? "\\-" : std::string(1, c);
      EXPECT_NE(manual.find(escaped), std::string::npos) << command << " " << name;
    }
  }
  EXPECT_EQ(run_program("completion csh").exit_code, 64);
}

TEST(CommandLine, BashCompletesCommandsOptionsAndValues) {
  CommandFolder folder;
  write_text_atomically(folder / "angio.bash", run_program("completion bash").out);
  const auto completed = [&](const std::string& words) {
    const std::string script = ". '" + folder / "angio.bash" + "'; COMP_WORDS=(" + words +
                               "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _angio; "
                               "echo ${COMPREPLY[*]}";
    write_text_atomically(folder / "try.bash", script);
    write_text_atomically(folder / "out", "");
    EXPECT_EQ(
        std::system(("bash '" + folder / "try.bash" + "' > '" + folder / "out" + "'").c_str()), 0);
    return file_text(folder.path() / "out");
  };
  EXPECT_EQ(completed("angio ph"), "phantom\n");
  EXPECT_EQ(completed("angio run --conta"), "--contact\n");
  EXPECT_EQ(completed("angio run --contact p"), "paper\n");
  EXPECT_EQ(completed("angio run ''"), "\n");  // a file: left to the shell
}

TEST(CommandLine, UsageErrorsReturn64AndSuggest) {
  CommandFolder folder;
  expect_failure("", 64, "--help", folder);
  expect_failure("rnu x -o y", 64, "run", folder);
  expect_failure("--bogus", 64, "there is no option --bogus", folder);
  expect_failure("run phantom:straight -o '" + folder / "c" + "' --qiet", 64, "--quiet", folder);
  expect_failure("run phantom:straight", 64, "-o", folder);
  expect_failure("run phantom:straight -o '" + folder / "c" + "' --until meshes", 64, "meshing",
                 folder);
  expect_failure("phantom nonsense -o '" + folder / "p" + "'", 64, "straight", folder);
}

TEST(CommandLine, AnOptionsFaultNamesOptionValueAndWhatIsExpected) {
  CommandFolder folder;
  const std::string run = "run phantom:straight -o '" + folder / "c" + "' ";
  for (const char* inlet : {"1,2", "abc", "1,2,x"}) {
    expect_failure(run + "--inlet " + inlet, 64, std::string("--inlet ") + inlet, folder);
    expect_failure(run + "--inlet " + inlet, 64, "expected a point X,Y,Z in LPS [mm]", folder);
  }
  expect_failure(run + "--spacing 1,2", 64, "--spacing 1,2 cannot be used (expected three", folder);
  expect_failure(run + "--from foo", 64, "--from foo", folder);
  expect_failure(run + "--threads 4096", 64, "--threads: Value 4096 not in range 0 to 1024",
                 folder);
  expect_failure(run + "--max-memory x", 64, "--max-memory: Value x not in range 0 to 65536",
                 folder);
  for (const char* views : {"abc", "1", "1,1", "1,", "1,x", "0,2", "1;2"})
    expect_failure(
        run + "--views '" + views + "'", 64,
        std::string("--views ") + views + " cannot be used (expected numbers of two views or more",
        folder);
  for (const char* ends : {"abc", "1,2,3", "1,2,3,4", "1,2,3,4,5,6,7,-8", "1,2,3,4,5,6,7,nan"})
    expect_failure(run + "--ends " + ends, 64,
                   std::string("--ends ") + ends + " cannot be used (expected four numbers a view",
                   folder);
  expect_failure("film c -o x.mp4 --fps x", 64, "--fps x cannot be used (expected a number",
                 folder);
  expect_failure("film c -o x.mp4 --fps 99", 78, "--fps 99", folder);
  expect_failure("inflate -o d --radius 1 --pressures 1,x", 64, "--pressures 1,x", folder);
  expect_failure(run + "--set centerline.inlet_lps_mm=[1,2]", 78, "[ 1, 2 ]", folder);
}

TEST(CommandLine, AGpuThatIsNotThereIsRefusedAtTheStart) {
  const auto doctor = nlohmann::json::parse(run_program("doctor --json").out);
  if (doctor.at("backend_used") == "cuda") GTEST_SKIP() << "there is a GPU";
  CommandFolder folder;
  write_text_atomically(folder / "m.csv", "case,input\na,phantom:straight\n");
  const std::string cuda = " --backend cuda -o '" + folder / "c" + "'";
  for (const std::string& call :
       {"run phantom:straight" + cuda, "run pacs://A@localhost:1/1.2" + cuda,
        "batch '" + folder / "m.csv" + "'" + cuda})
    expect_failure(call, 69, "--backend cuda", folder);
  const std::string until = "run phantom:straight,length=15 --until segmentation --quiet";
  EXPECT_EQ(run_program(until + cuda).exit_code, 0) << "no stage that needs one";
  expect_failure("run" + cuda, 69, "--backend cuda", folder);
}

TEST(CommandLine, WrongOptionsReturn78) {
  CommandFolder folder;
  const std::string run = "run phantom:straight -o '" + folder / "c" + "' ";
  expect_failure(run + "--set ballon.length_mm=3", 78, "balloon.length_mm", folder);
  expect_failure(run + "--set balloon.length_mm=-3", 78, "balloon.length_mm", folder);
  expect_failure(run + "--preset fast", 78, "draft", folder);
}

TEST(CommandLine, MissingOrUnusableInputsReturn66And65) {
  CommandFolder folder;
  const std::string to = " -o '" + folder / "c" + "'";
  fs::create_directory(folder.path() / "empty");
  write_text_atomically(folder / "text/notes.txt", "no image\n");
  write_text_atomically(folder / "broken.nrrd", "NRRD0004\n# cut off\n");
  write_text_atomically(folder / "broken.stl", "solid nothing\nendsolid\n");
  expect_failure("run '" + folder / "nowhere" + "'" + to, 66, "nowhere", folder);
  expect_failure("inspect '" + folder / "nowhere" + "'", 66, "nowhere", folder);
  expect_failure("run '" + folder / "empty" + "'" + to, 65, "", folder);
  expect_failure("run '" + folder / "text" + "'" + to, 65, "", folder);
  expect_failure("run '" + folder / "text/notes.txt" + "'" + to, 65, "", folder);
  expect_failure("run '" + folder / "broken.nrrd" + "'" + to, 65, "", folder);
  expect_failure("run '" + folder / "broken.stl" + "'" + to, 65, "", folder);
  expect_failure("mesh '" + folder / "empty" + "'", 66, "angio run", folder);
  expect_failure("batch '" + folder / "no.csv" + "'" + to, 66, "no.csv", folder);
}

TEST(CommandLine, AFolderThatIsNotOursIsLeftAlone) {
  CommandFolder folder;
  write_text_atomically(folder / "mine/letter.txt", "dear");
  expect_failure("run phantom:straight -o '" + folder / "mine" + "'", 73, "--force", folder);
  write_text_atomically(folder / "file", "x");
  expect_failure("run phantom:straight -o '" + folder / "file" + "'", 73, "-o", folder);
  expect_failure("run phantom:straight -o /proc/angio-case", 73, "-o", folder);
}

TEST(CommandLine, PipesAndDevicesAreRefusedBeforeTheyAreRead) {
  CommandFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe.stl").c_str(), 0600), 0);
  for (const std::string& input : {folder / "pipe.stl", std::string("/dev/zero")})
    for (const char* verb : {"inspect", "run"})
      expect_failure(verb + (" '" + input + "'") +
                         (std::string(verb) == "run" ? " -o '" + folder / "case" + "'" : ""),
                     65, "neither a file nor a folder", folder);
}

TEST(CommandLine, AFolderOfOneVolumeOrSurfaceIsThatFile) {
  CommandFolder folder;
  for (const char* format : {"nrrd", "surface"}) {
    const std::string data = folder / format, file = format + std::string("-case");
    ASSERT_EQ(run_program("phantom straight --length 12 --spacing 0.5 --format " +
                          std::string(format) + " -o '" + data + "'")
                  .exit_code,
              0);
    ASSERT_EQ(run_program("inspect --json '" + data + "'").exit_code, 0);
    const ProgramResult result =
        run_program("run '" + data + "' --until segmentation --quiet -o '" + folder / file + "'");
    EXPECT_EQ(result.exit_code, 0) << format << result.error;
  }
  fs::create_directories(folder.path() / "both");
  fs::copy(folder.path() / "nrrd/volume.nrrd", folder.path() / "both/a.nrrd");
  write_text_atomically(folder.path() / "both/b.stl", "solid\n");
  expect_failure("run '" + folder / "both" + "' -o '" + folder / "none" + "'", 65,
                 "both/a.nrrd -o CASE", folder);
  const ProgramResult listed = run_program("inspect '" + folder / "both" + "'");
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_NE(listed.out.find("one of these files"), std::string::npos) << listed.out;
  for (const std::string& verb : {std::string("inspect"), "run -o '" + folder / "none" + "'"})
    expect_failure(verb + " '" + folder / "nrrd-case" + "'", 65, "is a case of angio", folder);
}

TEST(CommandLine, AFolderThatIsNoCaseYetIsSaidToBeNone) {
  CommandFolder folder;
  fs::create_directories(folder.path() / "new");
  const ProgramResult result = run_program("run -o '" + folder / "new" + "'");
  EXPECT_EQ(result.exit_code, 64);
  EXPECT_NE(result.error.find("is no case yet"), std::string::npos) << result.error;
  EXPECT_EQ(result.error.find("--set"), std::string::npos) << result.error;
  const ProgramResult swallowed = run_program("run --set mesh.edges_per_circumference=12 -o x");
  EXPECT_NE(swallowed.error.find("before any --set"), std::string::npos) << swallowed.error;
}

TEST(CommandLine, InspectSaysWhatARunTakesAndWhatNot) {
  CommandFolder folder;
  ASSERT_EQ(run_program("phantom straight --format xa-views --views 0/0 --spacing 0.6 -o '" +
                        folder / "one" + "'")
                .exit_code,
            0);
  const ProgramResult one = run_program("inspect --json '" + folder / "one/xa_views" + "'");
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_TRUE(nlohmann::json::parse(one.out).at("series").at(0).at("taken_as").is_null());
  ASSERT_EQ(run_program("phantom straight --format xa-views --views 0/0,40/0 --spacing 0.6 -o '" +
                        folder / "two" + "'")
                .exit_code,
            0);
  const ProgramResult two = run_program("inspect '" + folder / "two/xa_views" + "'");
  EXPECT_EQ(two.exit_code, 0);
  EXPECT_EQ(two.out.find("refused"), std::string::npos) << two.out;
  EXPECT_NE(two.out.find("usable by `angio run`: view 2"), std::string::npos) << two.out;
}

TEST(CommandLine, FullOrClosedStreamsEndNoRunByASignal) {
  const auto exit_code = [](const std::string& words) {
    const int status = std::system((std::string("'") + ANGIO_PROGRAM + "' " + words).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  CommandFolder folder;
  const std::string run =
      "phantom straight --length 10 --radius 1 --format nrrd -o '" + folder / "p";
  EXPECT_EQ(exit_code("--version >/dev/full 2>&1"), 74);
  EXPECT_EQ(exit_code("doctor --json >/dev/full 2>/dev/full"), 74);
  EXPECT_EQ(exit_code("no-such-command 2>/dev/full"), 64);
  EXPECT_EQ(exit_code(run + "1' >/dev/null 2>/dev/full"), 0);
  EXPECT_EQ(exit_code(run + "2' <&- >&- 2>&-"), 0);
}

TEST(CommandLine, DoctorAndInspectSpeakJson) {
  const auto doctor = nlohmann::json::parse(run_program("doctor --json").out);
  EXPECT_GE(doctor.at("threads").get<int>(), 1);
  CommandFolder folder;
  ASSERT_EQ(
      run_program("phantom straight --length 10 --radius 1 --format nrrd -o '" + folder / "p" + "'")
          .exit_code,
      0);
  const auto found =
      nlohmann::json::parse(run_program("inspect --json '" + folder / "p/volume.nrrd" + "'").out);
  EXPECT_TRUE(found.at("series").at(0).at("usable").get<bool>());
}

}  // namespace
}  // namespace angio::test
