#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "testing/result_table.hpp"

namespace angio::benchmarks {
namespace {

/// A program's arguments.
struct Words {
  std::vector<std::string> words;
  std::vector<char*> pointers;
  int count = 0;

  explicit Words(std::vector<std::string> given) : words(std::move(given)) {
    for (std::string& word : words) pointers.push_back(word.data());
    count = int(words.size());
  }
};

TEST(ResultTable, TakesItsOwnOptionsOffTheArguments) {
  Words words({"/somewhere/program", "one", "--markdown", "file.md", "two"});
  const ResultTable results("Title", words.count, words.pointers.data());
  ASSERT_EQ(words.count, 3);
  EXPECT_STREQ(words.pointers[1], "one");
  EXPECT_STREQ(words.pointers[2], "two");
  EXPECT_NE(results.text().find("`program one two`"), std::string::npos);
}

TEST(ResultTable, StatesNoPlaceOfThisComputer) {
  Words words({"program", "/somewhere/data.csv"});
  const ResultTable results("Title", words.count, words.pointers.data());
  EXPECT_EQ(results.text().find("somewhere"), std::string::npos);
  EXPECT_NE(results.text().find("data.csv"), std::string::npos);
}

TEST(ResultTable, WritesHeadAndTable) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "result_table.md";
  Words words({"program", "--markdown", file.string()});
  ResultTable results("What is measured", words.count, words.pointers.data());
  results.columns({"law", "value"});
  results.row({"p V = Q", formatted("%.1f", 1.25)});
  results.write();
  const std::string text = read_text(file);
  EXPECT_TRUE(text.starts_with("# What is measured\n\n- Command: `program`\n- Commit: "));
  EXPECT_TRUE(text.ends_with("\n\n| law | value |\n| --- | --- |\n| p V = Q | 1.2 |\n"));
  std::filesystem::remove(file);
}

TEST(ResultTable, RefusesAnOptionWithoutAValue) {
  Words words({"program", "--markdown"});
  EXPECT_THROW(ResultTable("Title", words.count, words.pointers.data()), OptionError);
}

}  // namespace
}  // namespace angio::benchmarks
