/// hecaton view: runs hecaton-view in place of this process.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/cli/running_cell.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

struct ViewOptions {
  std::string cell;
  std::string listen;
  std::optional<std::uint64_t> port;
  bool control = false;
  bool no_stop = false;
  std::string certificate;
  std::string key;
  std::vector<std::string> origins;
};

/// Does not return; throws Failure when the view cannot be run.
ExitCode become_view(const Settings& settings, const ViewOptions& options) {
  const std::string cell = options.cell.empty() ? settings.cell_file : options.cell;
  if (cell.empty()) {
    throw Failure(ExitCode::kUsage, "view needs the cell file, as CELL, --cell or HECATON_CELL: it has the robots");
  }
  std::vector<std::string> words{cell};
  if (settings.domain) words.insert(words.end(), {"--domain", std::to_string(*settings.domain)});
  if (!options.listen.empty()) words.insert(words.end(), {"--listen", options.listen});
  if (options.port) words.insert(words.end(), {"--port", std::to_string(*options.port)});
  if (options.control) words.emplace_back("--control");
  if (options.no_stop) words.emplace_back("--no-stop");
  if (!options.certificate.empty()) {
    words.insert(words.end(), {"--certificate", options.certificate, "--key", options.key});
  }
  for (const std::string& origin : options.origins) words.insert(words.end(), {"--allow-origin", origin});
  become("hecaton-view", std::move(words));
}

}  // namespace

void add_view(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("view", "Serves a page that shows a running cell, until Ctrl-C");
  auto options = std::make_shared<ViewOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML) (--cell or HECATON_CELL)");
  command
      ->add_option("--listen", options->listen,
                   "IPv4 address of the page (the cell file's, or 127.0.0.1: this host alone)")
      ->type_name("ADDRESS");
  add_whole_number(
      *command, "--port", [options](std::uint64_t port) { options->port = port; },
      "port of the page, 0 to 65535; 0: a free one (the cell file's, or 8000 + DDS domain)", 0, 65535);
  command
      ->add_option(
          "--allow-origin", options->origins,
          "origin of further pages that may connect as Foxglove does, http://vis.example:8080; may be repeated")
      ->type_name("ORIGIN")
      ->allow_extra_args(false);
  CLI::Option* certificate =
      command
          ->add_option(
              "--certificate", options->certificate,
              "certificate of a page that other machines can reach, PEM (the cell file's, or one that the view "
              "makes itself)")
          ->type_name("FILE");
  certificate->needs(
      command->add_option("--key", options->key, "its private key, PEM")->type_name("FILE")->needs(certificate));
  command->add_flag("--control", options->control,
                    "one page at a time holds, resumes, stops, gives goals and edits obstacles, with the token in the "
                    "printed address; in a secured cell it needs an identity of the role operator");
  command->add_flag("--no-stop", options->no_stop, "pages without control cannot stop the cell");
  command->footer(
      "The address of the page is the first line of the output. Every page can stop the cell (Esc); this is no safety "
      "function. Without --control a page gives no other order. With --listen ADDRESS other machines can open the "
      "printed address. The connection is encrypted; the token in the address is the right to see and to stop the "
      "cell. Foxglove and Lichtblick open the same address with ws:// in place of http:// (wss:// of https://); with "
      "/?token=TOKEN behind it they hold, resume and stop.");
  command->callback([&session, options] {
    session.action = [&session, options] { return become_view(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
