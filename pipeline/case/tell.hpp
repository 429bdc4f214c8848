#pragma once

#include <fmt/format.h>

#include <utility>

#include "core/printable.hpp"

namespace angio::pipeline {

/// Writes a line to standard output; what a file or a name puts into it commands no terminal.
template <class... Values>
void tell(fmt::format_string<Values...> format, Values&&... values) {
  fmt::print("{}\n", printable(fmt::format(format, std::forward<Values>(values)...)));
}

}  // namespace angio::pipeline
