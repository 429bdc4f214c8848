#include "pipeline/cli/command_description.hpp"

#include <CLI/CLI.hpp>
#include <sstream>
#include <string_view>

#include "formats/tokens.hpp"

namespace angio::pipeline {
namespace {

/// The names in a check's description, as TEXT:{auto,cpu,cuda}.
std::vector<std::string> checked_choices(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.find('}');
  std::vector<std::string> choices;
  if (open == std::string::npos || close == std::string::npos) return choices;
  std::istringstream list(type.substr(open + 1, close - open - 1));
  for (std::string choice; std::getline(list, choice, ',');) choices.push_back(choice);
  return choices;
}

/// The range in a check's description, as INT in [0 - 1024].
void add_range(const std::string& type, OptionDescription& option) {
  constexpr std::string_view kBegin = " in [", kBetween = " - ";
  const std::size_t begin = type.find(kBegin), between = type.find(kBetween, begin);
  if (begin == std::string::npos || between == std::string::npos) return;
  option.least = formats::parse_number<double>(
      std::string_view(type).substr(begin + kBegin.size(), between - begin - kBegin.size()));
  const std::size_t last = between + kBetween.size();
  option.most = formats::parse_number<double>(
      std::string_view(type).substr(last, type.find(']', last) - last));
}

OptionDescription describe_option(const CLI::Option& option, const KnownValues& known) {
  OptionDescription result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  const std::string type = option.get_type_name();
  if (option.get_items_expected_max() > 0) result.value = type.substr(0, type.find_first_of(":{ "));
  if (option.get_positional() && result.names.empty()) result.value = option.get_name(true);
  result.choices = checked_choices(type);
  for (const std::string& name : result.names)
    if (const auto found = known.find(name); found != known.end()) result.choices = found->second;
  result.help = option.get_description();
  result.required = option.get_required();
  result.is_repeatable = option.get_items_expected_max() > 1;
  result.is_list = option.get_items_expected_max() > 1 && option.get_delimiter() == ',';
  result.group = option.get_group();
  result.default_value = option.get_default_str();
  add_range(type, result);
  return result;
}

std::vector<OptionDescription> describe_options(const CLI::App& app, const KnownValues& known) {
  std::vector<OptionDescription> options;
  for (const CLI::Option* option : app.get_options())
    options.push_back(describe_option(*option, known));
  return options;
}

}  // namespace

ProgramDescription describe(const CLI::App& app, const KnownValues& known) {
  ProgramDescription program{app.get_description(), describe_options(app, known), {}};
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_group().empty())
      program.commands.push_back(
          {command->get_name(), command->get_description(), describe_options(*command, known)});
  return program;
}

}  // namespace angio::pipeline
