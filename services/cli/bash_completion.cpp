#include <algorithm>

#include <CLI/CLI.hpp>

#include "services/cli/command_line_shape.hpp"

namespace hecaton::services::cli {
namespace {

void add_word(std::string& words, const std::string& word) {
  words += (words.empty() ? "" : " ") + word;
}

std::string flags_of(const CLI::App& app) {
  std::string words;
  for (const CLI::Option* option : options_of(app)) {
    for (const std::string& name : option->get_lnames()) add_word(words, "--" + name);
  }
  return words;
}

/// Rows of a case statement: what may follow each option of the command `path` that takes a value. Choices are told by
/// a type "a|b|c". Options of hecaton itself may stand behind every command.
void write_values(const CLI::App& app, const std::string& path, std::string& out) {
  const bool of_all = app.get_parent() == nullptr;
  const auto pattern_of = [&](const std::string& name) {
    return of_all ? "*\" " + name + "\"" : "\"" + path + " " + name + "\"";
  };
  for (const CLI::Option* option : options_of(app)) {
    if (option->get_positional() || option->get_items_expected_max() == 0) continue;
    std::string pattern;
    for (const std::string& name : option->get_snames()) pattern += pattern_of("-" + name) + " | ";
    pattern += pattern_of("--" + option->get_lnames().front());
    std::string type = option->get_type_name();
    std::string values;
    if (type.find('|') != std::string::npos) {
      std::replace(type.begin(), type.end(), '|', ' ');
      values = "COMPREPLY=($(compgen -W '" + type + "' -- \"$current\")); ";
    } else if (type == "FILE" || type == "DIR") {
      values = "COMPREPLY=($(compgen -f -- \"$current\")); ";
    }
    out.append("    ").append(pattern).append(") ").append(values).append("return ;;\n");
  }
  for (const CLI::App* command : subcommands_of(app)) write_values(*command, path + " " + command->get_name(), out);
}

/// What comes after the words of `path` ("hecaton obstacle"), as a row of a case statement.
void write_rows(const CLI::App& app, const std::string& path, const std::string& inherited, std::string& out) {
  std::string words = flags_of(app);
  add_word(words, inherited);
  add_word(words, "--help");
  for (const CLI::App* command : subcommands_of(app)) add_word(words, command->get_name());
  out += "    \"" + path + "\") words=\"" + words + "\" ;;\n";
  const std::string global = inherited.empty() ? flags_of(app) : inherited;
  for (const CLI::App* command : subcommands_of(app)) {
    write_rows(*command, path + " " + command->get_name(), global, out);
  }
}

std::string command_names(const CLI::App& app) {
  std::string names;
  for (const CLI::App* command : subcommands_of(app)) {
    add_word(names, command->get_name());
    add_word(names, command_names(*command));
  }
  return names;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::string rows;
  write_rows(app, app.get_name(), "", rows);
  std::string values;
  write_values(app, app.get_name(), values);
  return "# bash completion of hecaton, written by `hecaton completion bash`.\n"
         "_hecaton() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} path=hecaton words= i\n"
         "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
         "    case \" " +
         command_names(app) +
         " \" in\n"
         "      *\" ${COMP_WORDS[i]} \"*) path+=\" ${COMP_WORDS[i]}\" ;;\n"
         "    esac\n"
         "  done\n"
         "  case \"$path $previous\" in\n" +
         values +
         "  esac\n"
         "  case $path in\n" +
         rows +
         "  esac\n"
         "  # Arms come from the running cell: only where an arm is meant, and without waiting for a cell that is not "
         "there.\n"
         "  case $path in\n"
         "    hecaton\\ goal | hecaton\\ wait | hecaton\\ hold | hecaton\\ resume | hecaton\\ stop | hecaton\\ attach "
         "| hecaton\\ detach)\n"
         "      [[ $current == -* ]] || words+=\" $(hecaton arms --connect-timeout 300ms 2>/dev/null | awk 'NR > 1 { "
         "print $1 }')\" ;;\n"
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  case $path in\n"
         "    hecaton\\ up | hecaton\\ agent | hecaton\\ check | hecaton\\ plan | hecaton\\ simulate) "
         "COMPREPLY+=($(compgen -f -- "
         "\"$current\")) ;;\n"
         "  esac\n"
         "}\n"
         "complete -o filenames -F _hecaton hecaton\n";
}

}  // namespace hecaton::services::cli
