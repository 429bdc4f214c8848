#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.hpp"
#include "pipeline/cli/command_description.hpp"

namespace angio::pipeline {
namespace {

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// In single quotes, as all three shells read them; fish also reads backslashes there.
std::string quoted_for_shell(const std::string& text, bool is_fish = false) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'')
      result += is_fish ? "\\'" : "'\\''";
    else if (c == '\\' && is_fish)
      result += "\\\\";
    else
      result += c;
  }
  return result + "'";
}

std::vector<std::string> names_of(const std::vector<OptionDescription>& options) {
  std::vector<std::string> names;
  for (const OptionDescription& option : options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

/// The branches of a `case` over "COMMAND OPTION" that say what may follow.
std::string choice_branches(const ProgramDescription& program, const char* before,
                            const char* after) {
  std::string text;
  for (const CommandDescription& command : program.commands)
    for (const OptionDescription& option : command.options) {
      if (option.choices.empty() || option.names.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names)
        patterns.push_back(fmt::format("\"{} {}\"", command.name, name));
      text += fmt::format("    {}) {}{}{} ;;\n", fmt::join(patterns, "|"), before,
                          fmt::join(option.choices, " "), after);
    }
  return text;
}

std::string bash_script(const ProgramDescription& program) {
  std::vector<std::string> commands;
  std::string options;
  for (const CommandDescription& command : program.commands) {
    commands.push_back(command.name);
    options += fmt::format("    {}) words=\"{}\" ;;\n", command.name,
                           fmt::join(names_of(command.options), " "));
  }
  return fmt::format(
      "# bash completion for angio; written by `angio completion bash`\n"
      "_angio() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} words= values=\n"
      "  case \"${{COMP_WORDS[1]}} ${{COMP_WORDS[COMP_CWORD-1]}}\" in\n{}  esac\n"
      "  case ${{COMP_WORDS[1]}} in\n{}  esac\n"
      "  [[ $word == -* ]] || words=\n"
      "  ((COMP_CWORD > 1)) || words=\"{} {}\"\n"
      "  COMPREPLY=($(compgen -W \"${{values:-$words}}\" -- \"$word\"))\n"
      "}}\n"
      "complete -o default -F _angio angio\n",
      choice_branches(program, "values=\"", "\""), options, fmt::join(commands, " "),
      fmt::join(names_of(program.options), " "));
}

/// NAME:HELP for each name of _describe's list.
std::string described(const std::vector<OptionDescription>& options) {
  std::string words;
  for (const OptionDescription& option : options)
    for (const std::string& name : option.names)
      words += " " + quoted_for_shell(name + ":" + first_line(option.help));
  return words;
}

std::string zsh_script(const ProgramDescription& program) {
  std::string commands, options;
  for (const CommandDescription& command : program.commands) {
    commands += " " + quoted_for_shell(command.name + ":" + first_line(command.help));
    options += fmt::format("    {}) list=({} ) ;;\n", command.name, described(command.options));
  }
  return fmt::format(
      "#compdef angio\n"
      "# written by `angio completion zsh`\n"
      "local -a list\n"
      "if (( CURRENT == 2 )); then\n"
      "  list=({}{} )\n"
      "  _describe command list\n"
      "  return\n"
      "fi\n"
      "case \"$words[2] $words[CURRENT-1]\" in\n{}esac\n"
      "if [[ $words[CURRENT] == -* ]]; then\n"
      "  case $words[2] in\n{}  esac\n"
      "  _describe option list\n"
      "else\n"
      "  _files\n"
      "fi\n",
      commands, described(program.options), choice_branches(program, "compadd ", "; return"),
      options);
}

std::string fish_option(const OptionDescription& option, const std::string& condition) {
  std::string text = fmt::format("complete -c angio -n {}", quoted_for_shell(condition, true));
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (!option.choices.empty())
    text += fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
  else if (!option.value.empty())
    text += " -r";
  return text + " -d " + quoted_for_shell(first_line(option.help), true) + "\n";
}

std::string fish_script(const ProgramDescription& program) {
  std::string text = "# fish completion for angio; written by `angio completion fish`\n";
  for (const OptionDescription& option : program.options)
    if (!option.names.empty()) text += fish_option(option, "__fish_use_subcommand");
  for (const CommandDescription& command : program.commands) {
    text += fmt::format("complete -c angio -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                        quoted_for_shell(first_line(command.help), true));
    for (const OptionDescription& option : command.options)
      if (!option.names.empty())
        text += fish_option(option, "__fish_seen_subcommand_from " + command.name);
  }
  return text;
}

}  // namespace

std::string completion_script(const ProgramDescription& program, const std::string& shell) {
  if (shell == "bash") return bash_script(program);
  if (shell == "zsh") return zsh_script(program);
  if (shell == "fish") return fish_script(program);
  throw Error(ExitCode::usage, "there is completion for bash, zsh and fish, not for " + shell);
}

}  // namespace angio::pipeline
