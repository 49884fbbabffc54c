/// hecaton replay, hecaton explain: what a recording shows at any of its times.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <arpa/inet.h>

#include "services/cli/commands.hpp"
#include "services/cli/opened_recording.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/recorder/mcap_format.hpp"
#include "services/replay/explain.hpp"
#include "services/replay/replay_service.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kLongest = 1e9;  // [s]

struct Options {
  std::vector<std::string> files;
  std::string listen = "127.0.0.1";
  std::uint64_t port = 0;
  double at = 0.0;  ///< since the begin of the recording [s]
  std::string arm;
};

void require_address(const std::string& listen) {
  in_addr parsed{};
  if (inet_pton(AF_INET, listen.c_str(), &parsed) == 1) return;
  throw Failure(ExitCode::kBadInput, "--listen '" + config::printable(listen) +
                                         "' must be an IPv4 address of this host: 127.0.0.1 for this host alone, "
                                         "0.0.0.0 for all of its networks");
}

ExitCode run_replay(const Options& options) {
  require_address(options.listen);
  const std::unique_ptr<OpenedRecording> recording = open_recording(options.files);
  replay::Replay replay(recording->cell);
  replay.seek(time_in(*recording, options.at, "--at"));
  const ShutdownSignal shutdown(ShutdownSignal::Second::kEndsProcess);
  try {
    replay::ReplayService service(recording->files, replay, options.listen, static_cast<std::uint16_t>(options.port),
                                  shutdown);
    config::View address;
    address.listen = options.listen;
    address.port = service.port();
    std::fprintf(stderr, "replaying %s of cell %s; Ctrl-C ends it\n", duration_text(recording->length()).c_str(),
                 recording->files.cell.cell.name.c_str());
    std::cout << config::view_url(address, 0) << std::endl;
    service.run();
  } catch (const std::runtime_error& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
  return ExitCode::kDone;
}

ExitCode run_explain(const Settings& settings, const Options& options) {
  const std::unique_ptr<OpenedRecording> recording = open_recording(options.files);
  std::string names;
  bool known = false;
  for (const planner::PlannedArm& planned : recording->files.cell.cell.arms) {
    known = known || planned.arm.name == options.arm;
    names += (names.empty() ? "" : ", ") + planned.arm.name;
  }
  if (!known) {
    throw Failure(ExitCode::kBadInput,
                  "--arm '" + config::printable(options.arm) + "' must be an arm of the recording: " + names);
  }
  const auto time = time_in(*recording, options.at, "--at");
  recording->cell.move_to(time);
  const std::vector<std::string> sentences = replay::explain(recording->cell.state(), options.arm, time);
  std::string table;
  for (const std::string& sentence : sentences) table += sentence + "\n";
  const auto unix_ms = std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
  print(settings, {{"arm", options.arm}, {"at_s", options.at}, {"unix_ms", unix_ms}, {"sentences", sentences}}, table);
  return ExitCode::kDone;
}

void add_files(CLI::App& command, Options& options) {
  command.add_option("FILE", options.files, "recording (.mcap); the files of a split recording in their order")
      ->required()
      ->expected(1, 10000);
}

void add_time(CLI::App& command, Options& options, const char* description) {
  add_number(
      command, "--at", [&options](double at) { options.at = at; }, description, config::Bounds{0.0, kLongest, "s"});
}

}  // namespace

void add_replay(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("replay", "Serves the page of a recording, with a time line, until Ctrl-C");
  auto options = std::make_shared<Options>();
  add_files(*command, *options);
  command->add_option("--listen", options->listen, "IPv4 address of the page (127.0.0.1: this host alone)")
      ->type_name("ADDRESS");
  add_whole_number(
      *command, "--port", [options](std::uint64_t port) { options->port = port; },
      "port of the page, 0 to 65535; 0: a free one (0)", 0, 65535);
  add_time(*command, *options, "show this time first, since the begin of the recording [s] (0)");
  command->footer(
      "The address of the page is the first line of the output. All pages of one replay show the same time. The cell "
      "file and its robots come from the recording. A damaged recording is shown as far as its CRCs prove it.");
  command->callback([&session, options] { session.action = [options] { return run_replay(*options); }; });
}

void add_explain(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("explain", "Says what bound an arm at one time of a recording");
  auto options = std::make_shared<Options>();
  add_files(*command, *options);
  command->add_option("--arm", options->arm, "name of the arm")->required()->type_name("ARM");
  add_time(*command, *options, "time since the begin of the recording [s] (0)");
  command->footer(
      "It names the order, why the arm stands, its goal, the pair of bodies that bounds its motion, what its planner "
      "tries, the ages of its inputs, and open faults.");
  command->callback([&session, options] {
    session.action = [&session, options] { return run_explain(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
