#pragma once

#include <string>
#include <string_view>

namespace angio {

/// A line for a terminal: what a name or a file's text could do to it is made harmless. Control
/// characters, also line breaks and those of Unicode that turn the writing about, become `?`, as
/// does each byte that is not UTF-8.
std::string printable(std::string_view text);

}  // namespace angio
