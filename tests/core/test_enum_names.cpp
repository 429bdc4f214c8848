#include <gtest/gtest.h>

#include "core/enum_names.hpp"

namespace angio {
namespace {
enum class Fruit { apple, pear, plum };
enum class Nameless { one };
}  // namespace

template <>
struct EnumNames<Fruit> {
  static constexpr std::array kNames{"apple", "pear", "plum"};
};

namespace {

TEST(EnumNames, AreReadAsTheyAreWritten) {
  for (const Fruit fruit : {Fruit::apple, Fruit::pear, Fruit::plum})
    EXPECT_EQ(enum_of_name<Fruit>(enum_name(fruit)), fruit);
  EXPECT_STREQ(enum_name(Fruit::plum), "plum");
}

TEST(EnumNames, OthersAreNotRead) {
  for (const char* name : {"", "Apple", "app", "apples"})
    EXPECT_FALSE(enum_of_name<Fruit>(name)) << name;
}

TEST(EnumNames, AreListedInWords) { EXPECT_EQ(list_enum_names<Fruit>(), "apple, pear or plum"); }

static_assert(NamedEnum<Fruit> && !NamedEnum<Nameless>);

}  // namespace
}  // namespace angio
