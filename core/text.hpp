#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// Words that users type, names of files and options, and lists in messages.
namespace angio {

/// With A to Z as a to z, whatever the locale.
std::string lower_case(std::string text);

/// The extension with its dot, in lower case; empty if there is none.
std::string lower_extension(const std::filesystem::path& path);

/// How many letters must be changed, added or dropped to come from one word to the other
/// (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known name with the least edit distance; the first of equals. @param known  not empty
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

/// The same, if the distance is below the larger of 3 and half of the word's length; else empty.
std::string guess_name(std::string_view word, const std::vector<std::string>& known);

/// "A", "A and B", "A, B, C and 12 other places": one note for all things of a kind, however many.
/// @param things  not empty  @param kind  what they are, in the plural
std::string list_a_few(const std::vector<std::string>& things, std::string_view kind);

}  // namespace angio
