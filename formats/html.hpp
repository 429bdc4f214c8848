#pragma once

#include <string>
#include <string_view>

namespace angio::formats {

/// Replaces & < > " ' so that a text can stand in an element or in a quoted attribute of HTML, SVG
/// and XML. Control characters, which XML does not allow, become spaces.
std::string escape_html(std::string_view text);

}  // namespace angio::formats
