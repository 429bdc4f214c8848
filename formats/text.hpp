#pragma once

#include <string>
#include <string_view>

/// Numbers and bytes as text.
namespace angio::formats {

/// The shortest text that reads back as the same number, whatever the locale.
std::string number_text(double value);

/// A number to so many decimals, whatever the locale; "–" where it is not finite.
std::string fixed_text(double value, int decimals);

/// Bytes in base64 (RFC 4648).
std::string base64(std::string_view bytes);

/// The other way. Empty if the text is no base64.
std::string from_base64(std::string_view text);

}  // namespace angio::formats
