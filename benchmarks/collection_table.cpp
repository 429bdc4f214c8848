// The table of the collection: what each run gave against what a person reads in the case.
//
//     collection_table RUNS.csv READINGS.csv ENDS.csv -o OUT [--markdown FILE]
//
// RUNS.csv, written by collection.sh: folder,case,file,input,exit_code,wall_s,cpu_s. Writes
// OUT/collection.csv, a row a case, and OUT/collection.md, the same for people with a summary of
// each split; with --markdown that goes to FILE, too, with commit, machine and command at its head.
// docs/collection.md says what the columns mean and by which rules they are counted.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/collection_row.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {
namespace fs = std::filesystem;

const Reading& reading_of(const std::vector<Reading>& readings, const formats::CsvRow& run) {
  for (const Reading& reading : readings)
    if (reading.case_name == run[1] && reading.file == run[2]) return reading;
  throw InputError("no reading of " + run[1] + ", " + run[2] + ". Add one to public_readings.csv");
}

CollectionRow judge(const formats::CsvRow& run, const Reading& reading) {
  CollectionRow row;
  row.name = fs::path(run[0]).filename().string();
  row.split = reading.split;
  row.certainty = reading.certainty;
  row.exit_code = std::stoi(run[4]);
  row.wall_s = std::stod(run[5]);
  row.cpu_s = std::stod(run[6]);
  try {
    judge_run(run[0], row);
    judge_against(reading, run[0], run[3], row);
  } catch (const std::exception& error) {  // a damaged case must not hide the others
    fmt::print(stderr, "collection_table: {}: {}\n", run[0], error.what());
    row.status += " (not judged)";
  }
  return row;
}

std::string csv_of(const std::vector<CollectionRow>& rows) {
  std::string text = std::string(kCollectionHeader) + "\n";
  for (const CollectionRow& row : rows) text += csv_line(row) + "\n";
  return text;
}

std::string markdown_of(const std::vector<CollectionRow>& rows) {
  std::string text;
  for (const char* split : {"dev", "heldout"}) {
    std::vector<CollectionRow> of_split;
    for (const CollectionRow& row : rows)
      if (row.split == split) of_split.push_back(row);
    if (of_split.empty()) continue;
    text += fmt::format("### {}: {} cases\n\n", split, of_split.size()) + markdown_head();
    for (const CollectionRow& row : of_split) text += markdown_line(row) + "\n";
    text += "\n" + summary(of_split) + "\n";
  }
  return text;
}

int make_table(const fs::path& runs_csv, const fs::path& readings_csv, const fs::path& ends_csv,
               const fs::path& out, benchmarks::ResultTable& results) {
  const std::vector<Reading> readings = read_readings(readings_csv, ends_csv);
  const std::vector<formats::CsvRow> runs = formats::parse_csv(read_text(runs_csv));
  constexpr std::size_t kColumns = 7;
  std::vector<CollectionRow> rows;
  for (std::size_t r = 1; r < runs.size(); ++r) {
    if (runs[r].size() != kColumns)
      throw InputError(runs_csv.string() + ", row " + std::to_string(r + 1) +
                       ", is damaged (it has not seven cells). Run collection.sh again");
    rows.push_back(judge(runs[r], reading_of(readings, runs[r])));
  }
  write_text_atomically(out / "collection.csv", csv_of(rows));
  write_text_atomically(out / "collection.md", markdown_of(rows));
  results.markdown("\n" + markdown_of(rows));
  results.write();
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable results("The public collection, judged against a person's reading",
                                         argc, argv);
  if (argc != 6 || std::string(argv[4]) != "-o") {
    fmt::print(stderr,
               "usage: collection_table RUNS.csv READINGS.csv ENDS.csv -o OUT [--markdown FILE]\n");
    return int(angio::ExitCode::usage);
  }
  return angio::make_table(argv[1], argv[2], argv[3], argv[5], results);
} catch (const angio::Error& error) {
  fmt::print(stderr, "collection_table: {}\n", error.what());
  return int(error.exit_code());
}
