/// hecaton replay, hecaton explain: what a recording shows at any of its times.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <arpa/inet.h>

#include "services/cli/commands.hpp"
#include "services/cli/opened_recording.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/recorder/mcap_format.hpp"
#include "services/replay/explain.hpp"
#include "services/replay/replay_service.hpp"
#include "services/replay/verification.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kLatestInstant = 1e9;  // [s]

struct ReplayOptions {
  std::vector<std::string> files;
  std::string listen = "127.0.0.1";
  std::uint64_t port = 0;
  double at = 0.0;  ///< since the begin of the recording [s]
  std::string arm;
  bool verify = false;
  std::vector<std::string> arms;  ///< to verify; empty: all
};

void require_address(const std::string& listen) {
  in_addr parsed{};
  if (inet_pton(AF_INET, listen.c_str(), &parsed) == 1) return;
  throw Failure(ExitCode::kBadInput, "--listen '" + config::printable(listen) +
                                         "' must be an IPv4 address of this host: 127.0.0.1 for this host alone, "
                                         "0.0.0.0 for all of its networks");
}

ExitCode run_replay(const ReplayOptions& options) {
  require_address(options.listen);
  const std::unique_ptr<OpenedRecording> recording = open_recording(options.files);
  replay::Replay replay(recording->cell);
  replay.seek(time_in(*recording, options.at, "--at"));
  const ShutdownSignal shutdown(ShutdownSignal::Second::kEndsProcess);
  try {
    config::View address;
    address.listen = options.listen;
    address.port = static_cast<int>(options.port);
    replay::ReplayService service(recording->files, replay, address, shutdown);
    std::fprintf(stderr, "replaying %s of cell %s; Ctrl-C ends it\n", duration_text(recording->length()).c_str(),
                 recording->files.cell.cell.name.c_str());
    const std::string& drawn = recording->files.note;
    if (!drawn.empty()) std::fprintf(stderr, "hecaton: %s\n", drawn.c_str());
    if (const auto note = service.note()) std::fprintf(stderr, "%s\n", note->c_str());
    std::cout << service.url() << std::endl;
    service.run();
  } catch (const std::runtime_error& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
  return ExitCode::kDone;
}

/// Throws Failure unless the recorded cell has all of the arms.
void require_recorded_arms(const planner::Cell& cell, const std::vector<std::string>& arms) {
  std::string names;
  for (const std::string& name : names_of(cell)) names += (names.empty() ? "" : ", ") + name;
  for (const std::string& arm : arms) {
    const auto known = [&](const planner::PlannedArm& planned) { return planned.arm.name == arm; };
    if (std::any_of(cell.arms.begin(), cell.arms.end(), known)) continue;
    throw Failure(ExitCode::kBadInput,
                  "--arm '" + config::printable(arm) + "' must be an arm of the recording: " + names);
  }
}

ExitCode run_explain(const Settings& settings, const ReplayOptions& options) {
  const std::unique_ptr<OpenedRecording> recording = open_recording(options.files);
  require_recorded_arms(recording->files.cell.cell, {options.arm});
  const auto time = time_in(*recording, options.at, "--at");
  const replay::LongestBinding before = replay::longest_binding(recording->cell, options.arm, time);
  const std::vector<std::string> sentences = replay::explain(recording->cell.state(), options.arm, time, before);
  std::string table;
  for (const std::string& sentence : sentences) table += sentence + "\n";
  const auto unix_ms = std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
  print(settings,
        {{"arm", options.arm},
         {"at_s", options.at},
         {"unix_ms", unix_ms},
         {"sentences", sentences},
         {"findings", notes_json(recording->index.notes)}},
        table);
  return ExitCode::kDone;
}

Json json_of(const replay::ArmVerification& arm) {
  Json json{{"arm", arm.arm},
            {"ticks", arm.recorded},
            {"recomputed", arm.recomputed()},
            {"equal", arm.equal},
            {"differing", arm.differing},
            {"without_set_point", arm.without_set_point},
            {"not_verifiable", arm.unverified},
            {"missing", arm.missing},
            {"memories", arm.memories},
            {"differing_memories", arm.differing_memories},
            {"commands", arm.commands},
            {"differing_commands", arm.differing_commands},
            {"first_difference", nullptr}};
  if (arm.first) {
    const replay::TickDifference& first = *arm.first;
    json["first_difference"] = {{"tick", first.tick},
                                {"time_s", first.time},
                                {"node", first.node},
                                {"joint", first.joint},
                                {"velocity", first.velocity},
                                {"recorded", first.recorded},
                                {"recomputed", first.recomputed}};
  }
  return json;
}

/// What the table does not show, a line each.
std::string lines_of(const replay::ArmVerification& arm) {
  std::string lines;
  const auto line = [&](const std::string& text) { lines += arm.arm + ": " + text + "\n"; };
  for (const auto& [reason, count] : arm.unverified) {
    line(std::to_string(count) + " ticks were not verified: " + reason);
  }
  if (arm.missing > 0) line(std::to_string(arm.missing) + " ticks are missing in the recording");
  if (arm.without_set_point > 0) {
    line(std::to_string(arm.without_set_point) + " ticks have no set-point: the planner had no fresh state of the arm");
  }
  if (arm.differing_memories > 0) {
    line("the memory of the planner differs at " + std::to_string(arm.differing_memories) + " of " +
         std::to_string(arm.memories) + " snapshots");
  }
  if (arm.differing_commands > 0) {
    line(std::to_string(arm.differing_commands) + " of " + std::to_string(arm.commands) +
         " recorded commands have other set-points than their ticks");
  }
  if (!arm.first) return lines;
  const replay::TickDifference& first = *arm.first;
  std::array<char, 96> values{};
  std::snprintf(values.data(), values.size(), "%.17g recorded, %.17g recomputed", first.recorded, first.recomputed);
  line("first difference: tick " + std::to_string(first.tick) + " of " + first.node + " at " +
       decimal_text(first.time, 3) + " s: " +
       (first.joint.empty() ? "the memory of the planner"
                            : (first.velocity ? "velocity of joint " : "joint ") + first.joint + ": " + values.data()));
  return lines;
}

ExitCode run_verify(const Settings& settings, const ReplayOptions& options) {
  replay::Verification verified;
  try {
    const replay::RecordedFiles files = replay::read_recorded_files(options.files);
    require_recorded_arms(files.cell.cell, options.arms);
    Progress progress;
    verified = replay::verify_recording(options.files, files.cell.cell, options.arms, [&](double share) {
      progress.show("verifying " + options.files.front(), share * 100.0, 100.0, "%");
    });
  } catch (const std::runtime_error& error) {
    if (dynamic_cast<const Failure*>(&error) != nullptr) throw;
    throw Failure(ExitCode::kBadInput, error.what());
  }
  for (const std::string& note : verified.notes) std::fprintf(stderr, "hecaton: %s\n", note.c_str());
  Json arms = Json::array();
  Table table({{"ARM"},
               {"TICKS", Align::kRight},
               {"RECOMPUTED", Align::kRight},
               {"EQUAL", Align::kRight},
               {"DIFFERING", Align::kRight},
               {"NOT VERIFIABLE", Align::kRight}});
  std::string lines;
  std::uint64_t recorded = 0;
  std::uint64_t recomputed = 0;
  bool differs = false;
  for (const replay::ArmVerification& arm : verified.arms) {
    arms.push_back(json_of(arm));
    std::uint64_t unverified = 0;
    for (const auto& [reason, count] : arm.unverified) unverified += count;
    table.add({arm.arm, std::to_string(arm.recorded), std::to_string(arm.recomputed()), std::to_string(arm.equal),
               std::to_string(arm.differing), std::to_string(unverified)});
    lines += lines_of(arm);
    recorded += arm.recorded;
    recomputed += arm.recomputed();
    differs = differs || arm.differs();
  }
  if (recorded == 0) {
    verified.notes.emplace_back(
        "no tick of a planner is recorded: no arm was commanded, or a version without ticks recorded the cell");
    lines += verified.notes.back() + "\n";
  }
  print(settings, {{"arms", std::move(arms)}, {"findings", notes_json(verified.notes)}},
        table.text(Palette::for_stream(stdout)) + lines);
  return differs || recomputed == 0 ? ExitCode::kNegative : ExitCode::kDone;
}

void add_time(CLI::App& command, ReplayOptions& options, const char* description) {
  add_number(
      command, "--at", [&options](double at) { options.at = at; }, description,
      config::Bounds{0.0, kLatestInstant, "s"});
}

}  // namespace

void add_replay(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("replay", "Serves the page of a recording, with a time line, until Ctrl-C");
  auto options = std::make_shared<ReplayOptions>();
  add_recording_files(*command, options->files);
  command->add_option("--listen", options->listen, "IPv4 address of the page (127.0.0.1: this host alone)")
      ->type_name("ADDRESS");
  add_whole_number(
      *command, "--port", [options](std::uint64_t port) { options->port = port; },
      "port of the page, 0 to 65535; 0: a free one (0)", 0, 65535);
  add_time(*command, *options, "show this time first, since the begin of the recording [s] (0)");
  command->add_flag("--verify", options->verify,
                    "serve no page: recompute each recorded tick of the planners, and compare set-points bit by bit");
  command->add_option("--arm", options->arms, "with --verify: of these arms only (all)")
      ->type_name("ARM...")
      ->expected(1, 256);
  command->footer(
      "The address of the page is the first line of the output. All pages of one replay show the same time. The cell "
      "file and its robots come from the recording. A damaged recording is shown as far as its CRCs prove it. --verify "
      "ends with exit "
      "code 0 if it has recomputed a tick and nothing differs, and with 1 otherwise.");
  command->callback([&session, options] {
    if (!options->arms.empty() && !options->verify) throw Failure(ExitCode::kUsage, "--arm needs --verify");
    session.action = [&session, options] {
      return options->verify ? run_verify(session.settings, *options) : run_replay(*options);
    };
  });
}

void add_explain(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("explain", "Says what bound an arm at one time of a recording");
  auto options = std::make_shared<ReplayOptions>();
  add_recording_files(*command, options->files);
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
