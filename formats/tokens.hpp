#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace angio::formats {

/// Cuts a text into words at white space.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) {}

  /// The next word; empty at the end.
  std::string_view next() {
    constexpr std::string_view kSpace = " \t\r\n\f\v";
    const auto first = text_.find_first_not_of(kSpace, position_);
    if (first == std::string_view::npos) {
      position_ = text_.size();
      return {};
    }
    position_ = std::min(text_.find_first_of(kSpace, first), text_.size());
    return text_.substr(first, position_ - first);
  }
  /// Passes by the rest of the line.
  void skip_line() { position_ = std::min(text_.find('\n', position_), text_.size()); }

 private:
  std::string_view text_;
  std::size_t position_ = 0;
};

/// Cuts a text into lines, without their line ends.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  std::optional<std::string_view> next() {
    if (position_ >= text_.size()) return std::nullopt;
    const auto end = std::min(text_.find('\n', position_), text_.size());
    std::string_view line = text_.substr(position_, end - position_);
    position_ = end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }
  /// Where the next line begins.
  [[nodiscard]] std::size_t position() const { return std::min(position_, text_.size()); }

 private:
  std::string_view text_;
  std::size_t position_ = 0;
};

/// A whole word as a number, whatever the locale; nothing if it is not one.
template <class Number>
std::optional<Number> parse_number(std::string_view word) {
  if (word.size() > 1 && word.front() == '+') word.remove_prefix(1);
  Number value{};
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace angio::formats
