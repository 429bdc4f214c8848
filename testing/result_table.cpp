#include "testing/result_table.hpp"

#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "pipeline/commit.hpp"

namespace angio::benchmarks {
namespace {

/// A word of the command as it is stated: where a file lies on this computer concerns nobody.
std::string stated(const std::string& word) {
  return word.starts_with("/") ? std::filesystem::path(word).filename().string() : word;
}

/// The value of the first line of a /proc file that begins with a name; empty if there is none.
std::string proc_value(const char* file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with(name) || colon == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? std::string() : line.substr(begin);
  }
  return {};
}

std::string machine() {
  const std::string processor = proc_value("/proc/cpuinfo", "model name");
  std::string text = std::to_string(sysconf(_SC_NPROCESSORS_ONLN)) + " cores of " +
                     (processor.empty() ? "an unknown processor" : processor);
  const std::string memory = proc_value("/proc/meminfo", "MemTotal");
  if (!memory.empty())
    text += formatted(", %.0f GiB", std::strtod(memory.c_str(), nullptr) / (1024.0 * 1024.0));
  return text;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  char text[16];
  std::tm utc{};
  std::strftime(text, sizeof text, "%Y-%m-%d", gmtime_r(&now, &utc));
  return text;
}

std::string joined(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

}  // namespace

ResultTable::ResultTable(std::string title, int& argument_count, char** arguments)
    : title_(std::move(title)) {
  std::string command = std::filesystem::path(arguments[0]).filename().string();
  int kept = 1;
  for (int i = 1; i < argument_count; ++i) {
    const std::string word = arguments[i];
    if (word == "--markdown" || word == "--command") {
      if (i + 1 >= argument_count) throw OptionError(word + " needs a value");
      (word == "--markdown" ? file_ : command_) = arguments[++i];
      continue;
    }
    command += " " + stated(word);
    arguments[kept++] = arguments[i];
  }
  argument_count = kept;
  if (command_.empty()) command_ = command;
}

void ResultTable::put(const std::string& text) {
  body_ += text;
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void ResultTable::use_gpu(const std::string& name) { gpu_ = name; }
void ResultTable::section(const std::string& title) { put("\n## " + title + "\n"); }
void ResultTable::paragraph(const std::string& text) { put("\n" + text + "\n"); }
void ResultTable::markdown(const std::string& text) { put(text); }
void ResultTable::row(const std::vector<std::string>& cells) { put(joined(cells)); }

void ResultTable::columns(const std::vector<std::string>& names) {
  put("\n" + joined(names) + joined(std::vector<std::string>(names.size(), "---")));
}

std::string ResultTable::text() const {
  const std::string commit = pipeline::kCommit;
  std::string head = "# " + title_ + "\n\n";
  head += "- Command: `" + command_ + "`\n";
  head +=
      "- Commit: " + (commit.empty() ? "not known" : commit) + ", measured on " + today() + "\n";
  head += std::string("- Build: ") + ANGIO_BUILD_TYPE + ", GCC " + __VERSION__ + "\n";
  head += "- Machine: " + machine() + (gpu_.empty() ? "" : "; GPU: " + gpu_) + "\n";
  return head + (body_.starts_with("\n") ? "" : "\n") + body_;
}

void ResultTable::write() const {
  if (!file_.empty()) write_text_atomically(file_, text());
}

int run_benchmark(const char* program, int argument_count, char** arguments,
                  int (*run)(int argument_count, char** arguments)) {
  try {
    return run(argument_count, arguments);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return int(error.exit_code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return int(ExitCode::bad_data);
  }
}

std::string formatted(const char* format, ...) {
  std::va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(std::size_t(length < 0 ? 0 : length), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  return text;
}

}  // namespace angio::benchmarks
