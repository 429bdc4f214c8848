#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "core/progress.hpp"

namespace angio::pipeline {

/// How a run talks to people (standard error) or to programs (standard output).
enum class ReportStyle {
  automatic,  ///< a bar with the time left on a terminal, otherwise lines
  lines,      ///< a line per stage and per 10 %
  quiet,      ///< warnings and errors only
  json,       ///< one JSON object per event, on standard output
};

class Reporter {
 public:
  explicit Reporter(ReportStyle style);

  void begin_stage(std::string_view stage);
  void end_stage(std::string_view stage, std::string_view outcome, double seconds);
  void warn(std::string_view stage, const std::string& warning);
  void note(const std::string& text);
  /// The run's result: a path on standard output.
  void result(const std::string& path);

  /// Reports into the running stage; throws Interrupted once the user has asked to stop.
  [[nodiscard]] Progress progress();

 private:
  void show(double fraction, std::string_view step);

  ReportStyle style_;
  bool terminal_;
  std::string stage_;
  int last_tenth_ = 0;
  std::chrono::steady_clock::time_point stage_start_;
  std::chrono::steady_clock::time_point last_shown_;
};

/// Makes SIGINT and SIGTERM end the run at the next report of progress.
void catch_interrupts();
/// @throws Interrupted if the user has asked to stop
void throw_if_interrupted();

}  // namespace angio::pipeline
