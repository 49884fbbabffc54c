#include <CLI/CLI.hpp>

#include "services/cli/command_line_shape.hpp"

namespace hecaton::services::cli {
namespace {

/// Text for troff: no line may begin with a control character, hyphens are to stay hyphens.
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

std::string man_page(const CLI::App& app, const std::string& version) {
  std::string out = ".TH HECATON 1 \"\" \"hecaton " + version + "\" \"User Commands\"\n";
  out += ".SH NAME\nhecaton \\- cells of robot arms that plan their motions together\n";
  out += ".SH SYNOPSIS\n" + bold("hecaton") + " [" + italic("OPTIONS") + "] " + italic("COMMAND") + " …\n";
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
