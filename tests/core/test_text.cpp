#include <gtest/gtest.h>

#include "core/text.hpp"

namespace angio {
namespace {

TEST(LowerExtension, IsTheLastOneWithItsDot) {
  EXPECT_EQ(lower_extension("A.B/Scan.NII.GZ"), ".gz");
  EXPECT_EQ(lower_extension("A.B/Scan"), "");
}

TEST(EditDistance, CountsLettersChangedAddedAndDropped) {
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", "abc"), 0u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);  // Levenshtein's textbook pair
  EXPECT_EQ(edit_distance("sitting", "kitten"), 3u);
}

TEST(NearestName, IsTheFirstOfEquals) {
  EXPECT_EQ(nearest_name("bat", {"cart", "cat", "rat"}), "cat");
}

TEST(ListAFew, IsShortHoweverManyThereAre) {
  EXPECT_EQ(list_a_few({"A"}, "ends"), "A");
  EXPECT_EQ(list_a_few({"A", "B"}, "ends"), "A and B");
  EXPECT_EQ(list_a_few({"A", "B", "C", "D"}, "ends"), "A, B, C and D");
  EXPECT_EQ(list_a_few({"A", "B", "C", "D", "E"}, "ends"), "A, B, C and 2 other ends");
}

TEST(GuessName, IsNothingWhereNoneIsNear) {
  EXPECT_EQ(guess_name("lenght", {"length", "width"}), "length");
  EXPECT_EQ(guess_name("colour", {"length", "width"}), "");
  EXPECT_EQ(guess_name("colour", {}), "");
}

}  // namespace
}  // namespace angio
