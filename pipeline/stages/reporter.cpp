#include "pipeline/stages/reporter.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/printable.hpp"
#include "pipeline/case/console.hpp"

namespace angio::pipeline {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void print_event(const json& event) {
  fmt::print("{}\n", event.dump(-1, ' ', false, json::error_handler_t::replace));
  std::fflush(stdout);
}

constexpr std::string_view kClearLine = "\r\x1b[K";

}  // namespace

void catch_interrupts() { angio::catch_interrupts(); }

void throw_if_interrupted() { angio::throw_if_interrupted(); }

Reporter::Reporter(ReportStyle style)
    : style_(style), terminal_(style == ReportStyle::automatic && isatty(STDERR_FILENO) != 0) {}

void Reporter::begin_stage(std::string_view stage) {
  throw_if_interrupted();
  stage_ = stage;
  last_tenth_ = 0;
  stage_start_ = last_shown_ = Clock::now();
  if (style_ == ReportStyle::json)
    print_event({{"event", "begin"}, {"stage", stage_}});
  else if (terminal_)
    show(0.0, "");
}

void Reporter::end_stage(std::string_view stage, std::string_view outcome, double seconds) {
  if (style_ == ReportStyle::json) {
    print_event({{"event", "end"}, {"stage", stage}, {"outcome", outcome}, {"seconds", seconds}});
  } else if (style_ != ReportStyle::quiet) {
    say("{}{:<13} {} ({:.1f} s)\n", terminal_ ? kClearLine : "", stage, outcome, seconds);
  }
}

void Reporter::warn(std::string_view stage, const std::string& warning) {
  if (style_ == ReportStyle::json)
    print_event({{"event", "warning"}, {"stage", stage}, {"text", warning}});
  else
    say("{}{:<13} note: {}\n", terminal_ ? kClearLine : "", stage, printable(warning));
}

void Reporter::note(const std::string& text) {
  if (style_ == ReportStyle::json)
    print_event({{"event", "note"}, {"text", text}});
  else if (style_ != ReportStyle::quiet)
    say("{}{}\n", terminal_ ? kClearLine : "", printable(text));
}

void Reporter::result(const std::string& path) {
  if (style_ == ReportStyle::json)
    print_event({{"event", "result"}, {"path", path}});
  else
    fmt::print("{}\n", path);
  std::fflush(stdout);
}

Progress Reporter::progress() {
  return Progress([this](double fraction, std::string_view step) {
    throw_if_interrupted();
    show(fraction, step);
  });
}

void Reporter::show(double fraction, std::string_view step) {
  const double elapsed = seconds_since(stage_start_);
  if (terminal_) {
    if (fraction > 0.0 && seconds_since(last_shown_) < 0.1) return;
    last_shown_ = Clock::now();
    constexpr int kBarWidth = 30;
    const int filled = int(fraction * kBarWidth);
    const std::string left =
        fraction > 0.05 ? fmt::format("{:.0f} s left", elapsed / fraction * (1.0 - fraction))
                        : std::string();
    say("{}{:<13} [{:=<{}}{:<{}}] {:3.0f} % {} {}", kClearLine, stage_, "", filled, "",
        kBarWidth - filled, 100.0 * fraction, left, step);
    std::fflush(stderr);
    return;
  }
  constexpr double kLongestSilence = 8.0;  // [s]
  const int percent = int(fraction * 100.0 + 1e-9), tenth = percent / 10;
  const bool is_next = tenth > last_tenth_;
  if (tenth >= 10 || (!is_next && seconds_since(last_shown_) < kLongestSilence)) return;
  last_tenth_ = std::max(tenth, last_tenth_);
  last_shown_ = Clock::now();
  if (style_ == ReportStyle::json)
    print_event({{"event", "progress"}, {"stage", stage_}, {"fraction", fraction}, {"step", step}});
  else if (style_ != ReportStyle::quiet)
    say("{:<13} {} %{}{}\n", stage_, is_next ? 10 * tenth : percent, step.empty() ? "" : " ", step);
}

}  // namespace angio::pipeline
