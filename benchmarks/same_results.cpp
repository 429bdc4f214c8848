// Do two builds of the program give the same results?
//
//     same_results BEFORE AFTER [--input FILE]... [--only NAME]... [--markdown FILE]
//
// BEFORE and AFTER are programs. Each runs the seed paper's five experiments, with a short
// schedule, three phantoms, and the given inputs, from the start to the report. All files of both
// cases must be the same, byte for byte, but for what says when, by which version and how fast:
// run.json, and in metrics.json and the report the times and the version. A row for each case, with
// the files that differ. Exit codes: 0 no difference, 1 a difference, 64 usage.

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "testing/pipeline/case_content.hpp"
#include "testing/result_table.hpp"
#include "testing/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;

struct Trial {
  std::string name;
  std::string arguments;  ///< of `angio run`
};

struct Arguments {
  std::string before, after;
  std::vector<std::string> inputs, only;
};

std::vector<Trial> make_trials(const std::vector<std::string>& inputs) {
  const std::string brief = " --set inflation.inflate_s=1 --set inflation.deflate_s=0.5";
  std::vector<Trial> trials = {
      {"paper-cloth", "--preset paper-cloth"},
      {"paper-unilateral", "--preset paper-unilateral" + brief},
      {"paper-bilateral", "--preset paper-bilateral" + brief},
      {"paper-ytype", "--preset paper-ytype" + brief},
      {"paper-coronary", "--preset paper-coronary" + brief},
      {"coronary", "phantom:coronary --preset draft"},
      {"layered wall", "phantom:unilateral --preset draft --set wall.model=layered"},
      {"wire as a rod", "phantom:unilateral --preset draft --set guidewire.model=rod" + brief}};
  for (const std::string& input : inputs)
    trials.push_back({fs::path(input).filename().string(), "'" + input + "' --preset draft"});
  return trials;
}

/// @return the exit code
int run(const std::string& program, const Trial& trial, const fs::path& folder) {
  const std::string command = "'" + program + "' run " + trial.arguments +
                              " --backend cpu --quiet -o '" + folder.string() + "' >'" +
                              folder.string() + ".log' 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// What "angio --version" prints, without the program's name.
std::string version_of(const std::string& program, const fs::path& folder) {
  const fs::path file = folder / "version";
  if (std::system(("'" + program + "' --version >'" + file.string() + "'").c_str()) != 0) return {};
  const std::string text = angio::read_text(file);
  const auto begin = text.find(' ');
  return begin == std::string::npos ? std::string()
                                    : text.substr(begin + 1, text.find('\n') - begin - 1);
}

std::string without(std::string text, const std::string& words) {
  for (auto at = text.find(words); !words.empty() && at != std::string::npos;
       at = text.find(words, at))
    text.erase(at, words.size());
  return text;
}

struct Difference {
  std::size_t files = 0;
  std::vector<std::string> which;
};

Difference compare(const fs::path& before, const std::string& version_before, const fs::path& after,
                   const std::string& version_after) {
  const auto a = angio::test::case_content(before), b = angio::test::case_content(after);
  Difference difference{a.size(), {}};
  for (const auto& [file, text] : a)
    if (file != "run.json" &&
        (!b.contains(file) || without(text, version_before) != without(b.at(file), version_after)))
      difference.which.push_back(file);
  for (const auto& entry : b)
    if (!a.contains(entry.first)) difference.which.push_back(entry.first);
  return difference;
}

std::string in_words(const Difference& difference) {
  if (difference.which.empty()) return "same";
  std::string words =
      fmt::format("{} differ: {}", difference.which.size(), difference.which.front());
  if (difference.which.size() > 1) words += ", " + difference.which[1];
  return difference.which.size() > 2 ? words + ", ..." : words;
}

/// @return false if they make no sense
bool parse(int argc, char** argv, Arguments& arguments) {
  std::vector<std::string> programs;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--input" && i + 1 < argc)
      arguments.inputs.push_back(fs::absolute(argv[++i]).string());
    else if (word == "--only" && i + 1 < argc)
      arguments.only.emplace_back(argv[++i]);
    else if (!word.starts_with("--"))
      programs.push_back(fs::absolute(word).string());
    else
      return false;
  }
  if (programs.size() != 2) return false;
  arguments.before = programs[0];
  arguments.after = programs[1];
  return true;
}

bool is_asked_for(const Arguments& arguments, const std::string& name) {
  bool is_asked = arguments.only.empty();
  for (const std::string& only : arguments.only) is_asked = is_asked || name == only;
  return is_asked;
}

}  // namespace

int main(int argc, char** argv) try {
  constexpr int kUsage = 64;
  angio::benchmarks::ResultTable results("The results of two builds, byte for byte", argc, argv);
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    fmt::print(
        stderr,
        "usage: same_results BEFORE AFTER [--input FILE]... [--only NAME]... [--markdown FILE]\n");
    return kUsage;
  }
  const angio::test::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  const std::string before = version_of(arguments.before, folder),
                    after = version_of(arguments.after, folder);
  results.paragraph(fmt::format("Before: {}. After: {}.", before, after));
  results.columns({"case", "files", "result"});
  std::size_t differences = 0;
  for (const Trial& trial : make_trials(arguments.inputs)) {
    if (!is_asked_for(arguments, trial.name)) continue;
    const int code_before = run(arguments.before, trial, folder / "before"),
              code_after = run(arguments.after, trial, folder / "after");
    Difference difference = compare(folder / "before", before, folder / "after", after);
    if (code_before != code_after)
      difference.which.insert(difference.which.begin(),
                              fmt::format("exit codes {} and {}", code_before, code_after));
    results.row({trial.name, std::to_string(difference.files), in_words(difference)});
    differences += difference.which.size();
    for (const char* used : {"before", "after"}) fs::remove_all(folder / used);
  }
  results.paragraph(fmt::format("{} differences.", differences));
  results.write();
  return differences == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const std::exception& error) {
  fmt::print(stderr, "same_results: {}\n", error.what());
  return EXIT_FAILURE;
}
