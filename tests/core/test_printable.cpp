#include <gtest/gtest.h>

#include "core/printable.hpp"

namespace angio {
namespace {

TEST(Printable, KeepsWords) {
  const std::string words = "Gr\u00e4fin \u8840\u7ba1 \U0001F600";
  EXPECT_EQ(printable(words), words);
}

TEST(Printable, CommandsNoTerminal) {
  EXPECT_EQ(printable("a\x1b[31mb\r\n\tc\x7f"), "a?[31mb???c?");
  EXPECT_EQ(printable("a\u009b31m"), "a?31m");  // a control sequence's beginning in one letter
  EXPECT_EQ(printable("nrrd\u202egpj"), "nrrd?gpj");  // would show as nrrdjpg
}

TEST(Printable, IsUtf8WhateverTheBytes) {
  EXPECT_EQ(printable("Gr\xe4"
                      "fin"),
            "Gr?fin");                               // Latin-1
  EXPECT_EQ(printable("\xc0\xaf"), "??");            // an overlong slash
  EXPECT_EQ(printable("\xed\xa0\x80"), "???");       // half of a pair
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "????");  // beyond Unicode
  EXPECT_EQ(printable("cut \xe2\x82"), "cut ??");
}

}  // namespace
}  // namespace angio
