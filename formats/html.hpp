#pragma once

#include <string>
#include <string_view>

/// Text for HTML, SVG and XML.
namespace angio::formats {

/// Replaces & < > " ' so that a text can stand in an element or in a quoted attribute. Control
/// characters, which XML does not allow, become spaces.
std::string escape_html(std::string_view text);

/// The shortest text that reads back as the same number, whatever the locale.
std::string number_text(double value);

/// A number to so many decimals, whatever the locale; "–" where it is not finite.
std::string fixed_text(double value, int decimals);

/// Bytes in base64 (RFC 4648).
std::string base64(std::string_view bytes);

}  // namespace angio::formats
