#include "pipeline/case/hidden_input.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "pipeline/case/input_kind.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  if (what.empty()) return;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
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

/// Names in a folder and, where it is a file, its own; as many as a message could be about.
std::vector<std::string> names_in(const fs::path& input) {
  constexpr std::size_t kMost = 200'000;
  std::vector<std::string> names = {input.filename().string()};
  std::error_code error;
  auto entry =
      fs::recursive_directory_iterator(input, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator() && names.size() < kMost;
       entry.increment(error))
    names.push_back(entry->path().filename().string());
  return names;
}

/// A name of a letter or two, or one that is a word of a message ("volume"), tells of nobody: it is
/// taken only where it stands as a file's name does.
bool tells(const std::string& name) {
  return name.size() > 3 && name.find_first_of("0123456789._- ") != std::string::npos;
}

}  // namespace

std::string without_input(std::string message, const std::string& input) {
  if (input.empty() || input.starts_with(kPhantomPrefix)) return message;
  std::vector<std::string> forms = forms_of(input);
  std::sort(forms.begin(), forms.end(),
            [](const std::string& a, const std::string& b) { return a.size() > b.size(); });
  for (const std::string& form : forms)
    if (form.size() > 1) replace_all(message, form, "INPUT");
  std::vector<std::string> names = names_in(input);
  std::sort(names.begin(), names.end(),
            [](const std::string& a, const std::string& b) { return a.size() > b.size(); });
  for (const std::string& name : names)
    if (tells(name) || name == fs::path(input).filename()) replace_all(message, name, "FILE");
  return message;
}

}  // namespace angio::pipeline
