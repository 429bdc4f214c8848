#pragma once

#include <string>
#include <vector>

namespace angio::benchmarks {

/// What a program has measured: paragraphs and tables in Markdown. They are printed as they come,
/// and with `--markdown FILE` written to a file of docs/results, under a head that states what was
/// measured, the command, the commit, the date, the build and the machine.
class ResultTable {
 public:
  /// Takes the options that are its own off the program's arguments:
  ///
  ///     --markdown FILE   write the results there, too
  ///     --command TEXT    the command to state (for scripts that call the program)
  ///
  /// @param title  the head line of the file: what is measured
  ResultTable(std::string title, int& argument_count, char** arguments);

  /// Names the GPU that was used; without a call none is stated.
  void use_gpu(const std::string& name);

  void section(const std::string& title);
  void paragraph(const std::string& text);
  void columns(const std::vector<std::string>& names);
  void row(const std::vector<std::string>& cells);
  /// A piece of Markdown that is complete.
  void markdown(const std::string& text);

  /// Writes the file, at once and whole; does nothing without `--markdown`.
  void write() const;

  /// The whole text of the file.
  [[nodiscard]] std::string text() const;

 private:
  void put(const std::string& text);

  std::string title_, command_, file_, gpu_, body_;
};

/// What main returns: what a benchmark's run does, or, where it throws, the error's exit code (65
/// of one that has none), after one line on stderr.
int run_benchmark(const char* program, int argument_count, char** arguments,
                  int (*run)(int argument_count, char** arguments));

/// As std::snprintf does.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

}  // namespace angio::benchmarks
