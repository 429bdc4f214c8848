#include <gtest/gtest.h>

#include <limits>

#include "core/error.hpp"
#include "core/require.hpp"

namespace angio {
namespace {

template <class Act>
std::string words_of(const Act& act) {
  try {
    act();
  } catch (const OptionError& error) {
    return error.what();
  }
  return {};
}

TEST(Require, BothEndsOfTheRangeAreInIt) {
  EXPECT_NO_THROW(require_within("a.b", 0.5, 0.5, 2.0));
  EXPECT_NO_THROW(require_within("a.b", 2.0, 0.5, 2.0));
  EXPECT_THROW(require_within("a.b", 0.499, 0.5, 2.0), OptionError);
  EXPECT_THROW(require_within("a.b", 2.001, 0.5, 2.0), OptionError);
}

TEST(Require, WhatIsNoNumberIsInNoRange) {
  EXPECT_THROW(require_within("a.b", std::numeric_limits<double>::quiet_NaN(), 0.0, 1.0),
               OptionError);
}

TEST(Require, NamesFieldValueAndRange) {
  EXPECT_EQ(words_of([] { require_within("a.b", 3.0, 0.5, 2.0, ". Leave it out"); }),
            "a.b is 3 (it must lie in [0.5, 2]). Leave it out");
  EXPECT_EQ(words_of([] { require(false, "a.b", "0, 2 or 3"); }),
            "a.b is out of range (allowed: 0, 2 or 3)");
  EXPECT_EQ(words_of([] { require(true, "a.b", "0, 2 or 3"); }), "");
}

}  // namespace
}  // namespace angio
