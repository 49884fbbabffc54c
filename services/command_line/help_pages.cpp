#include <algorithm>
#include <cctype>

#include <CLI/CLI.hpp>

#include "services/command_line/program.hpp"

namespace hecaton::services::cli {

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : app.get_options()) {
    if (option != app.get_help_ptr()) options.push_back(option);
  }
  // Option groups are subcommands without a name.
  for (const CLI::App* group : app.get_subcommands(nullptr)) {
    if (!group->get_name().empty()) continue;
    for (const CLI::Option* option : options_of(*group)) options.push_back(option);
  }
  std::stable_partition(options.begin(), options.end(),
                        [](const CLI::Option* option) { return option->get_positional(); });
  return options;
}

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  std::vector<const CLI::App*> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (!command->get_name().empty()) commands.push_back(command);
  }
  return commands;
}

// The completion.

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

/// Rows of a case statement: completions of the value of each option of the command `path`. A type "a|b|c" lists
/// choices. Options of the program itself may follow any command.
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

/// A row of a case statement: completions after the words of `path` ("hecaton obstacle").
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

void collect_paths(const CLI::App& app, const std::string& path, const std::vector<std::string>& positionals,
                   std::string& patterns) {
  for (const CLI::Option* option : options_of(app)) {
    if (!option->get_positional() ||
        std::find(positionals.begin(), positionals.end(), option->get_name()) == positionals.end()) {
      continue;
    }
    patterns += (patterns.empty() ? "\"" : " | \"") + path + "\"";
    break;
  }
  for (const CLI::App* command : subcommands_of(app)) {
    collect_paths(*command, path + " " + command->get_name(), positionals, patterns);
  }
}

/// A case statement that runs `action` after commands that have one of these positionals.
std::string case_of_paths(const CLI::App& app, const std::vector<std::string>& positionals, const std::string& action) {
  std::string patterns;
  collect_paths(app, app.get_name(), positionals, patterns);
  if (patterns.empty()) return {};
  return "  case $path in\n    " + patterns + ") " + action + " ;;\n  esac\n";
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  const std::string& program = app.get_name();
  std::string function = "_" + program;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string rows;
  write_rows(app, program, "", rows);
  std::string values;
  write_values(app, program, values);
  // Asks the running cell for its arms, only after commands with a positional ARM, and for at most 300 ms.
  const std::string arms =
      case_of_paths(app, {"ARM"},
                    "[[ $current == -* ]] || words+=\" $(" + program +
                        " arms --connect-timeout 300ms 2>/dev/null | awk 'NR > 1 { print $1 }')\"");
  const std::string files = case_of_paths(app, {"CELL", "FILE"}, "COMPREPLY+=($(compgen -f -- \"$current\"))");
  return "# bash completion of " + program + ", written by `" + program + " completion bash`.\n" + function +
         "() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} path=" +
         program +
         " words= i\n"
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
         rows + "  esac\n" + arms + "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n" + files +
         "}\ncomplete -o filenames -F " + function + " " + program + "\n";
}

// The man page.

namespace {

/// Text for troff: control characters at the beginning of a line, backslashes and hyphens are escaped.
std::string escaped(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool line_start = i == 0 || text[i - 1] == '\n';
    if (line_start && (text[i] == '.' || text[i] == '\'')) out += "\\&";
    if (text[i] == '\\') {
      out += "\\e";
    } else if (text[i] == '-') {
      out += "\\-";
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string bold(const std::string& text) {
  return "\\fB" + escaped(text) + "\\fR";
}
std::string italic(const std::string& text) {
  return "\\fI" + escaped(text) + "\\fR";
}

std::string names_of(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += (names.empty() ? "" : ", ") + bold("-" + name);
  for (const std::string& name : option.get_lnames()) names += (names.empty() ? "" : ", ") + bold("--" + name);
  if (option.get_items_expected_max() > 0) names += " " + italic(option.get_type_name());
  return names;
}

void write_options(const CLI::App& app, std::string& out) {
  for (const CLI::Option* option : options_of(app)) {
    out += ".TP\n";
    out += option->get_positional() ? italic(option->get_name()) : names_of(*option);
    out += "\n" + escaped(option->get_description());
    if (!option->get_default_str().empty()) out += escaped(" (" + option->get_default_str() + ")");
    if (!option->get_envname().empty()) out += " (environment: " + escaped(option->get_envname()) + ")";
    out += "\n";
  }
}

void write_command(const CLI::App& app, const std::string& path, std::string& out) {
  const std::string name = path + " " + app.get_name();
  std::string line = bold(name);
  for (const CLI::Option* option : options_of(app)) {
    if (option->get_positional()) line += " " + italic(option->get_name());
  }
  const auto commands = subcommands_of(app);
  if (!commands.empty()) line += " " + italic("COMMAND");
  out += ".SS " + line + "\n" + escaped(app.get_description()) + ".\n";
  write_options(app, out);
  if (!app.get_footer().empty()) out += ".PP\n" + escaped(app.get_footer()) + "\n";
  for (const CLI::App* command : commands) write_command(*command, name, out);
}

}  // namespace

std::string man_page(const CLI::App& app, const std::string& summary, const std::string& version) {
  const std::string& name = app.get_name();
  std::string title = name;
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string out = ".TH " + title + " 1 \"\" \"" + name + " " + version + "\" \"User Commands\"\n";
  out += ".SH NAME\n" + escaped(name) + " \\- " + escaped(summary) + "\n";
  out += ".SH SYNOPSIS\n" + bold(name) + " [" + italic("OPTIONS") + "] " + italic("COMMAND") + " …\n";
  out += ".SH DESCRIPTION\n" + escaped(app.get_description()) + "\n";
  out +=
      ".PP\nData goes to stdout, messages to stderr. Angles are in radians, lengths in metres; durations need a unit "
      "(20ms). Colours are used on terminals only, and never when " +
      bold("NO_COLOR") + " is set.\n";
  out += ".SH OPTIONS\nThey may stand before or after the command.\n";
  write_options(app, out);
  out += ".SH COMMANDS\n";
  for (const CLI::App* command : subcommands_of(app)) write_command(*command, app.get_name(), out);
  out += ".SH EXIT STATUS\n" + escaped(app.get_footer()) + "\n";
  return out;
}

}  // namespace hecaton::services::cli
