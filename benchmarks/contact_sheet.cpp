// One sheet a case, and a page of them all: what a person looks at, one by one, before a table is
// believed.
//
//     contact_sheet CASE... -o DIR [--logs DIR] [--table FILE.csv]
//
// DIR/<case>.png for each case folder, DIR/index.html with thumbnails. --logs: a folder with
// <case>.log, whose last line explains a case without results. --table: shown above the thumbnails.
// Exit codes: 0 done, 2 some sheets failed, 64 usage.

#include "viewer/contact_sheet.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

struct Arguments {
  std::vector<fs::path> cases;
  fs::path out, logs, table;
};

/// @return false if they make no sense
bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    fs::path* value = word == "-o"        ? &arguments.out
                      : word == "--logs"  ? &arguments.logs
                      : word == "--table" ? &arguments.table
                                          : nullptr;
    if (value == nullptr) {
      if (word.starts_with("-")) return false;
      arguments.cases.push_back(fs::path(word).lexically_normal());
      if (arguments.cases.back().filename().empty())
        arguments.cases.back() = arguments.cases.back().parent_path();
    } else if (++i < argc) {
      *value = argv[i];
    } else {
      return false;
    }
  }
  return !arguments.cases.empty() && !arguments.out.empty();
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kSomeFailed = 2, kUsage = 64;
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    fmt::print(stderr, "usage: contact_sheet CASE... -o DIR [--logs DIR] [--table FILE.csv]\n");
    return kUsage;
  }
  std::vector<std::string> sheets;
  int failed = 0;
  for (const fs::path& folder : arguments.cases) try {
      const std::string name = folder.filename().string();
      const fs::path log = arguments.logs.empty() ? fs::path() : arguments.logs / (name + ".log");
      angio::viewer::write_contact_sheet(folder, arguments.out / (name + ".png"), log);
      sheets.push_back(name + ".png");
      fmt::print("{}\n", (arguments.out / sheets.back()).string());
    } catch (const std::exception& error) {
      fmt::print(stderr, "contact_sheet: {}: {}\n", folder.string(), error.what());
      ++failed;
    }
  angio::viewer::write_sheet_index(arguments.out / "index.html", sheets, arguments.table);
  return failed == 0 ? EXIT_SUCCESS : kSomeFailed;
}
