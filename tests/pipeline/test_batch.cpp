#include <gtest/gtest.h>

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
  write_text_atomically(folder / "m.csv",
                        "case,input,balloon.length_mm\nA1,scan.nrrd,20\nB,phantom:straight,\n");
  const auto cases = read_manifest(folder / "m.csv", {});
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[0].name, "A1");
  EXPECT_EQ(cases[0].input, folder / "scan.nrrd");
  EXPECT_EQ(cases[0].settings, std::vector<std::string>{"balloon.length_mm=20"});
  EXPECT_EQ(cases[1].input, "phantom:straight");
  EXPECT_TRUE(cases[1].settings.empty());
}

TEST(Manifest, MistakesAreRefused) {
  test::CommandFolder folder;
  for (const char* text : {"", "case,input\n", "name,input\nA,b\n", "case,input\n../up,b\n",
                           "case,input\nA,b\nA,c\n", "case,input\nlogs,b\n", "case,input\nA\n",
                           "case,input\nA,b\nB,\n", "case,input\nA,b,c\n", "\xFF\xFE c,input\n"}) {
    write_text_atomically(folder / "m.csv", text);
    EXPECT_THROW(read_manifest(folder / "m.csv", {}), InputError) << text;
  }
  EXPECT_THROW(read_manifest(folder / "missing.csv", {}), InputError);
  write_text_atomically(folder / "m.csv", "case,input\nA," + std::string(5000, 'x') + "\n");
  EXPECT_THROW(read_manifest(folder / "m.csv", {}), InputError);
}

TEST(Manifest, KeysAndValuesAreCheckedAndTheRowIsNamed) {
  test::CommandFolder folder;
  for (const char* column : {"balloon.lenght_mm", "balloon.length_mm"}) {
    write_text_atomically(folder / "m.csv", std::string("case,input,") + column +
                                                "\n# a remark\nA,phantom:straight,long\n");
    try {
      read_manifest(folder / "m.csv", {});
      FAIL() << column;
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code(), ExitCode::bad_config);
      EXPECT_NE(std::string(error.what()).find("row 3 "), std::string::npos) << error.what();
    }
  }
}

TEST(Manifest, OfASpreadsheetIsRead) {
  test::CommandFolder folder;
  write_text_atomically(folder / "m.csv",
                        "\xEF\xBB\xBF"
                        "case;input;balloon.length_mm\r\n# first day\r\n"
                        "A;\"phantom:straight;x\";12\r\n;;\r\nB;scan.nrrd;\r\n");
  const auto cases = read_manifest(folder / "m.csv", {});
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[0].name, "A");
  EXPECT_EQ(cases[0].input, "phantom:straight;x");
  EXPECT_EQ(cases[0].settings, std::vector<std::string>{"balloon.length_mm=12"});
  EXPECT_EQ(cases[1].input, folder / "scan.nrrd");
}

}  // namespace
}  // namespace angio::pipeline
