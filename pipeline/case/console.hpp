#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

namespace angio::pipeline {

/// Writes to standard error. What cannot be written there (it is closed, or its disk is full) is
/// left out: it stops no run.
template <class... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = fmt::format(format, std::forward<Values>(values)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace angio::pipeline
