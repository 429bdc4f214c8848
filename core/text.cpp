#include "core/text.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace angio {

std::string lower_case(std::string text) {
  for (char& letter : text)
    if (letter >= 'A' && letter <= 'Z') letter = char(letter - 'A' + 'a');
  return text;
}

std::string lower_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t(0));
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& known) {
  return *std::min_element(known.begin(), known.end(),
                           [&](const std::string& a, const std::string& b) {
                             return edit_distance(name, a) < edit_distance(name, b);
                           });
}

std::string guess_name(std::string_view word, const std::vector<std::string>& known) {
  if (known.empty()) return {};
  const std::string nearest = nearest_name(word, known);
  const std::size_t most = std::max<std::size_t>(3, word.size() / 2);
  return edit_distance(word, nearest) < most ? nearest : std::string();
}

std::string list_a_few(const std::vector<std::string>& things, std::string_view kind) {
  constexpr std::size_t kMost = 4;
  const std::size_t named = things.size() > kMost ? kMost - 1 : things.size();
  std::string words;
  for (std::size_t i = 0; i < named; ++i) {
    if (i > 0) words += i + 1 == things.size() ? " and " : ", ";
    words += things[i];
  }
  if (named < things.size())
    words += " and " + std::to_string(things.size() - named) + " other " + std::string(kind);
  return words;
}

}  // namespace angio
