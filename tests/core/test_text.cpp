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

TEST(GuessName, IsNothingWhereNoneIsNear) {
  EXPECT_EQ(guess_name("lenght", {"length", "width"}), "length");
  EXPECT_EQ(guess_name("colour", {"length", "width"}), "");
  EXPECT_EQ(guess_name("colour", {}), "");
}

}  // namespace
}  // namespace angio
