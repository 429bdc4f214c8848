#include "pipeline/cli/verify_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "pipeline/case/console.hpp"
#include "pipeline/cli/verify_case.hpp"

namespace angio::pipeline {
namespace {

using nlohmann::json;

void print_json(const std::string& folder, const Verification& found) {
  json findings = json::array();
  for (const Finding& finding : found.findings)
    findings.push_back({{"kind", finding.kind}, {"place", finding.place}, {"text", finding.text}});
  fmt::print("{}\n", json{{"case", folder},
                          {"clean", found.findings.empty()},
                          {"files", found.file_count},
                          {"findings", findings},
                          {"notes", found.notes}}
                         .dump(-1, ' ', false, json::error_handler_t::replace));
}

void print_lines(const std::string& folder, const Verification& found) {
  for (const Finding& finding : found.findings)
    fmt::print("{}: {:<10} {} ({})\n", folder, finding.kind, finding.place, finding.text);
  for (const std::string& note : found.notes) say("{}: note: {}\n", folder, note);
  if (found.findings.empty()) fmt::print("{}: clean, {} files\n", folder, found.file_count);
}

}  // namespace

void add_verify_command(CLI::App& app, VerifyArguments& verify) {
  CLI::App& command = *app.add_subcommand(
      "verify",
      "are a case's files as they were left, and of the settings that it has now?\n"
      "lists files changed or missing, stages stale or unfinished; writes nothing");
  command.add_option("CASE", verify.cases, "one case's folder or more")
      ->required()
      ->expected(1, -1);
  command.add_flag("--json", verify.as_json, "a JSON object a case, a line each");
}

int do_verify(const VerifyArguments& arguments) {
  std::size_t unclean_count = 0;
  for (const std::filesystem::path& folder : arguments.cases) {
    Verification found;
    try {
      found = verify_case(CaseFolder(folder));
    } catch (const Error& error) {
      if (arguments.cases.size() == 1) throw;
      found.findings.push_back({"damaged", "run.json", error.what()});
    }
    (arguments.as_json ? print_json : print_lines)(folder.string(), found);
    unclean_count += found.findings.empty() ? 0 : 1;
  }
  if (unclean_count == 0) return int(ExitCode::done);
  std::fflush(stdout);  // both may go to one file
  const std::string what =
      arguments.cases.size() == 1
          ? arguments.cases.front().string() + " is"
          : fmt::format("{} of {} cases: each is", unclean_count, arguments.cases.size());
  throw InputError(what +
                   " not as the last run left it (see above). Run it again, `angio run INPUT -o "
                   "CASE`, or take it from a copy");
}

}  // namespace angio::pipeline
