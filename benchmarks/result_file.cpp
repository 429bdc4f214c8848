// Puts a head (command, commit, date, build, machine) before the Markdown on standard input, as
// every program here does with its own results. For scripts.
//
//     result_file TITLE --command TEXT --markdown FILE < TABLE.md

#include <cstdio>
#include <exception>
#include <iostream>
#include <iterator>
#include <string>

#include "testing/result_table.hpp"

int main(int argument_count, char** arguments) {
  constexpr int kUsage = 64, kFailed = 70;
  try {
    const std::string title = argument_count > 1 ? arguments[1] : "";
    angio::benchmarks::ResultTable results(title, argument_count, arguments);
    if (argument_count != 2) {
      std::fprintf(stderr, "usage: result_file TITLE --command TEXT --markdown FILE < TABLE.md\n");
      return kUsage;
    }
    results.markdown({std::istreambuf_iterator<char>(std::cin), {}});
    results.write();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "result_file: %s\n", error.what());
    return kFailed;
  }
}
