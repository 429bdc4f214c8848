#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/csv.hpp"
#include "pipeline/cli/manifest.hpp"
#include "run_program.hpp"

namespace angio::pipeline {
namespace {

TEST(Csv, QuotedCellsMayHoldCommasQuotesAndLineEnds) {
  const auto rows = formats::parse_csv("a,\"b,\"\"c\"\"\nd\",e\r\n\nf,,g");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0], (formats::CsvRow{"a", "b,\"c\"\nd", "e"}));
  EXPECT_EQ(rows[1], (formats::CsvRow{"f", "", "g"}));
}

TEST(Csv, WhatIsWrittenReadsBackAndIsNoFormula) {
  for (const std::string text : {"plain", "with, comma", "with \"quotes\"", "two\nlines"})
    EXPECT_EQ(formats::parse_csv(formats::csv_cell(text) + ",x").at(0).at(0), text);
  EXPECT_EQ(formats::csv_cell("=1+1"), "'=1+1");
  EXPECT_EQ(formats::csv_cell("-1.5"), "-1.5");
}

TEST(Manifest, RowsBecomeCasesWithTheirSettings) {
  test::CommandFolder folder;
  write_text_atomically(folder / "scan.nrrd", "");
  write_text_atomically(folder / "m.csv",
                        "case,input,balloon.length_mm,preset,balloon,series\n"
                        "A1,scan.nrrd,20,draft,sc-3.0,2\nB,phantom:straight,,,,\n");
  const auto cases = read_manifest(folder / "m.csv");
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[0].name, "A1");
  EXPECT_EQ(cases[0].input, folder / "scan.nrrd");
  EXPECT_EQ(cases[0].settings,
            (std::vector<std::string>{"input.series=\"2\"", "balloon.length_mm=20"}));
  EXPECT_EQ(cases[0].preset, "draft");
  EXPECT_EQ(cases[0].balloon, "sc-3.0");
  EXPECT_EQ(cases[1].input, "phantom:straight");
  EXPECT_TRUE(cases[1].settings.empty());
  EXPECT_TRUE(cases[1].preset.empty());
}

TEST(Manifest, ARowWinsOverTheBatch) {
  SharedOptions batch;
  batch.presets = {"draft"};
  batch.settings = {"a.b=1"};
  batch.balloon = "sc-2.5";
  const SharedOptions row = row_options(batch, {"A", "", {"a.b=2"}, "fine", "sc-3.0", ""});
  EXPECT_EQ(
      command_line_of(row),
      (std::vector<std::string>{"--preset", "draft", "--preset", "fine", "--balloon", "sc-3.0",
                                "--set", "a.b=1", "--set", "a.b=2", "--backend", "auto"}));
  EXPECT_EQ(command_line_of(row_options(batch, {"A", "", {}, "", "", ""})), command_line_of(batch));
}

TEST(Manifest, MistakesAreRefused) {
  test::CommandFolder folder;
  for (const char* text :
       {"", "case,input\n", "name,input\nA,b\n", "case,input\n../up,b\n", "case,input\nA,b\nA,c\n",
        "case,input\nlogs,b\n", "case,input\nA\n", "case,input\nA,b\nB,\n", "case,input\nA,b,c\n",
        "case,input\nA,\"b\n", "\xFF\xFE c,input\n"}) {
    write_text_atomically(folder / "m.csv", text);
    EXPECT_THROW(read_manifest(folder / "m.csv"), Error) << text;
  }
  EXPECT_THROW(read_manifest(folder / "missing.csv"), Error);
  write_text_atomically(folder / "m.csv", "case,input\nA," + std::string(5000, 'x') + "\n");
  EXPECT_THROW(read_manifest(folder / "m.csv"), Error);
}

/// What a manifest is refused with.
Error refusal_of(const std::string& text) {
  test::CommandFolder folder;
  write_text_atomically(folder / "m.csv", text);
  try {
    read_manifest(folder / "m.csv");
  } catch (const Error& error) {
    return error;
  }
  return {ExitCode::done, "it is taken"};
}

TEST(Manifest, KeysAndValuesAreCheckedAndTheRowIsNamed) {
  const std::string row = "\n# a remark\nA,phantom:straight,long\n";
  for (const auto& [column, where] :
       std::map<std::string, std::string>{{"balloon.lenght_mm", "row 1 "},
                                          {"ballon", "did you mean balloon?"},
                                          {"balloon.length_mm", "row 3 "},
                                          {"preset", "row 3 "},
                                          {"balloon", "row 3 "},
                                          {"input", "twice"}}) {
    const Error error = refusal_of("case,input," + column + row);
    EXPECT_EQ(error.exit_code(), column == "input" ? ExitCode::bad_data : ExitCode::bad_config)
        << column;
    EXPECT_NE(std::string(error.what()).find(where), std::string::npos) << error.what();
  }
}

TEST(Manifest, AllFaultsAreListedALineEach) {
  const Error missing = refusal_of("case,input\nA,no.nrrd\nB,phantom:straight\nC,none.stl\n");
  EXPECT_EQ(missing.exit_code(), ExitCode::no_input);
  const std::string text = missing.what();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
  EXPECT_NE(text.find("row 2 of the manifest (A): there is no no.nrrd"), std::string::npos) << text;
  EXPECT_NE(text.find("row 4 of the manifest (C): there is no none.stl"), std::string::npos);

  const Error mixed = refusal_of(
      "case,input,balloon.length_mm,preset\nA,no.nrrd,x,slow\nA,phantom:straight,5,\n"
      "B,phantom:crooked,-2,\n");
  EXPECT_EQ(mixed.exit_code(), ExitCode::bad_data);
  const std::string all = mixed.what();
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 6) << all;
}

TEST(Manifest, ASummaryNeedsNoInputs) {
  test::CommandFolder folder;
  write_text_atomically(folder / "m.csv", "case,input\nA,gone.nrrd\n");
  EXPECT_EQ(read_manifest(folder / "m.csv", {}, InputsAre::not_needed).size(), 1u);
}

TEST(Manifest, OfASpreadsheetIsRead) {
  test::CommandFolder folder;
  write_text_atomically(folder / "scan;1.nrrd", "");
  write_text_atomically(folder / "scan.nrrd", "");
  write_text_atomically(folder / "m.csv",
                        "\xEF\xBB\xBF"
                        "case; input;balloon.length_mm;\r\n# first day\r\n"
                        "A;\"scan;1.nrrd\";12,5;\r\n;;\r\nB;scan.nrrd;;\r\n");
  const auto cases = read_manifest(folder / "m.csv");
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[0].name, "A");
  EXPECT_EQ(cases[0].input, folder / "scan;1.nrrd");
  EXPECT_EQ(cases[0].settings, std::vector<std::string>{"balloon.length_mm=12.5"});
  EXPECT_EQ(cases[1].input, folder / "scan.nrrd");
  for (const char* text : {"sep=;\r\nCase;Input\r\nA;scan.nrrd\r\n", "case\tinput\nA\tscan.nrrd\n",
                           "case,input\rA,scan.nrrd\r"}) {
    write_text_atomically(folder / "m.csv", text);
    const auto one = read_manifest(folder / "m.csv");
    ASSERT_EQ(one.size(), 1u) << text;
    EXPECT_EQ(one[0].input, folder / "scan.nrrd");
  }
  write_text_atomically(folder / "m.csv", "case,input\nA,scan.nrrd\na,scan.nrrd\n");
  EXPECT_THROW(read_manifest(folder / "m.csv"), Error);
}

}  // namespace
}  // namespace angio::pipeline
