#include "pipeline/case/hidden_input.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <set>
#include <sstream>
#include <system_error>
#include <vector>

#include "pipeline/case/input_kind.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

/// Would a word go on from one character to the next? Letters (of any alphabet) and digits do.
bool goes_on(char before, char after) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_letter = [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code >= 0x80 || std::isalpha(code) != 0;
  };
  return (is_letter(before) && is_letter(after)) || (is_digit(before) && is_digit(after));
}

/// Replaces `what` where `stands(first, end)` says that it stands for itself.
template <class Stands>
void replace_all(std::string& text, const std::string& what, const std::string& by,
                 const Stands& stands) {
  if (what.empty()) return;
  for (auto at = text.find(what); at != std::string::npos;) {
    const bool is_it = stands(at, at + what.size());
    if (is_it) text.replace(at, what.size(), by);
    at = text.find(what, is_it ? at + by.size() : at + 1);
  }
}

void replace_paths(std::string& text, const std::string& what, const std::string& by) {
  replace_all(text, what, by, [](std::size_t, std::size_t) { return true; });
}

/// Whole words only: no folder "in" is in "inlet".
void replace_names(std::string& text, const std::string& what, const std::string& by) {
  replace_all(text, what, by, [&](std::size_t first, std::size_t end) {
    return (first == 0 || !goes_on(text[first - 1], text[first])) &&
           (end == text.size() || !goes_on(text[end - 1], text[end]));
  });
}

bool is_number(const std::string& name) {
  return name.find_first_not_of("0123456789") == std::string::npos;
}

/// Only as a part of a path, in quotes, or before an extension; a number only between slashes or
/// quotes.
void replace_quoted(std::string& text, const std::string& what, const std::string& by) {
  replace_all(text, what, by, [&](std::size_t first, std::size_t end) {
    const auto at = [&](std::size_t i) { return i < text.size() ? text[i] : ' '; };
    const auto is_quote = [](char c) { return c == '"' || c == '\'' || c == '`'; };
    const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
    const char before = first > 0 ? text[first - 1] : ' ', after = at(end);
    if (goes_on(before, text[first]) || goes_on(text[end - 1], after)) return false;
    if (is_quote(before) && is_quote(after)) return true;
    if (is_number(what)) return before == '/' && after == '/';
    return before == '/' || after == '/' || (after == '.' && is_letter(at(end + 1)));
  });
}

/// The input's path in every form that a message could have it in.
std::vector<std::string> forms_of(const fs::path& input) {
  std::error_code ignored;
  std::vector<std::string> forms = {input.string(), input.lexically_normal().string(),
                                    fs::absolute(input, ignored).string(),
                                    fs::weakly_canonical(input, ignored).string()};
  for (std::string& form : forms)
    while (form.size() > 1 && form.back() == '/') form.pop_back();
  return forms;
}

/// Names in a folder; as many as a message could be about.
std::vector<std::string> names_in(const fs::path& input) {
  constexpr std::size_t kMost = 200'000;
  std::vector<std::string> names;
  std::error_code error;
  auto entry =
      fs::recursive_directory_iterator(input, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator() && names.size() < kMost;
       entry.increment(error))
    names.push_back(entry->path().filename().string());
  return names;
}

/// A name that no message has as a word of its own: it is taken wherever it stands.
bool tells(const std::string& name) {
  return name.size() > 3 && name.find_first_of("0123456789._- ") != std::string::npos;
}

/// Numbers, and words that messages are made of, as an input's folder may be called, and nobody is:
/// what they say must stay readable.
bool is_word_of_messages(const std::string& name) {
  static const std::set<std::string> kWords = [] {
    std::istringstream words(
        "a all an and another are artery as at balloon be been beside but by can cannot case cm "
        "could CT ct data diameter DICOM dicom edge end ends file files folder frame frames from "
        "give has have here holds if image images in inlet input is it its label labels least "
        "length lesion line lines lumen mask mesh mm more MR mr narrow no not of on one only or "
        "out outlet path pieces place places points radius run scan series so some stage stenosis "
        "study surface than that the there this to tree unit up vessel vessels view views volume "
        "voxel voxels wall was where with within XA xa");
    return std::set<std::string>(std::istream_iterator<std::string>(words), {});
  }();
  return kWords.contains(name) || is_number(name);
}

void sort_longest_first(std::vector<std::string>& names) {
  std::sort(names.begin(), names.end(),
            [](const std::string& a, const std::string& b) { return a.size() > b.size(); });
}

}  // namespace

std::string without_input(std::string message, const std::string& input) {
  if (input.empty() || input.starts_with(kPhantomPrefix)) return message;
  std::vector<std::string> forms = forms_of(input);
  sort_longest_first(forms);
  for (const std::string& form : forms) {
    if (form.find('/') != std::string::npos && form.size() > 1)
      replace_paths(message, form, "INPUT");
    else if (is_word_of_messages(form))
      replace_quoted(message, form, "INPUT");
    else if (form != "." && form != "..")
      replace_names(message, form, "INPUT");
  }
  std::vector<std::string> names = names_in(input), words;
  for (const std::string& form : forms) {
    names.push_back(fs::path(form).stem().string());  // a header's data beside it
    const std::string own = fs::path(form).filename().string();
    (is_word_of_messages(own) ? names : words).push_back(own);
  }
  const auto is_told = std::partition(names.begin(), names.end(),
                                      [](const std::string& name) { return !tells(name); });
  words.insert(words.end(), is_told, names.end());
  names.erase(is_told, names.end());
  sort_longest_first(words);
  for (const std::string& name : words) replace_names(message, name, "FILE");
  sort_longest_first(names);
  for (const std::string& name : names) replace_quoted(message, name, "FILE");
  return message;
}

}  // namespace angio::pipeline
