/// hecaton record: records all topics of a running cell, or orders its recorders to save.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/recorder/recorder.hpp"
#include "services/recorder/recorder_service.hpp"
#include "services/recorder/save_orders.hpp"
#include "services/recorder/save_signal.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kLongestRecord = 1e7;  // [s], four months

struct RecordOptions {
  std::string cell;
  std::optional<std::string> file;
  std::optional<std::string> split_size;
  double duration = 0.0;      ///< [s]; 0: until a signal
  double split_time = 0.0;    ///< [s]; 0: never
  double keep = 0.0;          ///< [s]; 0: all
  double after_fault = -1.0;  ///< after faults and stops that is saved, too [s]; negative: only orders save
  bool ros2 = false;          ///< with the topics of hecaton-ros2
  bool save = false;          ///< order the recorder of the cell to save, and record nothing
};

/// The bytes of "500MB". Throws Failure.
std::uint64_t split_bytes(const std::string& text) {
  const auto bytes = config::parse_size(text);
  if (bytes && *bytes >= 1e5 && *bytes <= 1e15) return static_cast<std::uint64_t>(*bytes);
  throw Failure(ExitCode::kBadInput, "--split-size '" + config::printable(text) + "' must be a number with its unit (" +
                                         std::string(config::kSizeUnits) + ") from 100kB to 1000000GB");
}

std::chrono::nanoseconds seconds(double value) {
  return nanoseconds(value);
}

recorder::RecordingOptions recording_of(const RecordOptions& options) {
  if (!options.file) throw Failure(ExitCode::kUsage, "record needs the file to write: -o FILE.mcap");
  constexpr std::string_view kEnding = ".mcap";
  if (!options.file->ends_with(kEnding) || options.file->size() == kEnding.size()) {
    throw Failure(ExitCode::kBadInput, "-o '" + config::printable_path(*options.file) +
                                           "' must be a file that ends in .mcap, such as run.mcap");
  }
  recorder::RecordingOptions recording;
  recording.path = *options.file;
  if (options.split_size) recording.split_bytes = split_bytes(*options.split_size);
  recording.split_time = seconds(options.split_time);
  recording.keep = seconds(options.keep);
  recording.ros2 = options.ros2;
  return recording;
}

/// Each topic with losses, and their sum.
struct Losses {
  Json topics = Json::object();
  std::string text;
  bool any = false;
};

Losses losses_of(const std::vector<recorder::TopicLosses>& all) {
  Losses losses;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const recorder::TopicLosses& topic = all[i];
    if (!topic.any()) continue;
    const std::string name(bus::kTopics[i].type);
    losses.any = true;
    losses.topics[name] = topic.fields();
    losses.text += "  " + name + ": " + topic.text() + "\n";
  }
  return losses;
}

void print_result(const Settings& settings, const recorder::Recorder& recorder) {
  const recorder::Recording& recording = recorder.recording();
  const Losses losses = losses_of(recorder.losses());
  const double duration = std::chrono::duration<double>(recorder.duration()).count();
  const Json json{{"files", recording.files()},
                  {"messages", recording.messages()},
                  {"bytes", recording.bytes()},
                  {"duration_s", duration},
                  {"losses", losses.topics}};
  std::string table = "recorded " + std::to_string(recording.messages()) + " messages in " + duration_text(duration) +
                      ", " + bytes_text(static_cast<double>(recording.bytes())) + "\n";
  for (const std::string& file : recording.files()) table += "  " + file + "\n";
  table += losses.any ? "not recorded:\n" + losses.text : "nothing was lost\n";
  print(settings, json, table);
}

/// Events and orders after which the files that --keep would remove are saved.
class Saving {
 public:
  Saving(const config::CellFile& file, const ServiceOptions& service, const RecordOptions& options)
      : after_(seconds(std::max(0.0, options.after_fault))),
        participant_(make_participant(file, service, Role::kViewer, recorder_node())),
        orders_(participant_, machine_name()) {
    if (options.after_fault >= 0.0) events_.emplace(participant_);
  }
  void take(recorder::Recorder& recorder) {
    std::string event;
    if (events_) {
      event = events_->take();
    } else if (recorder::SaveSignal::take()) {
      event = recorder::kOrdered;
    }
    const bool ordered = orders_.take();
    if (ordered) event = recorder::kOrdered;
    if (event.empty()) return;
    recorder.save(after_);
    std::fprintf(stderr, "saved what is kept: %s\n", event.c_str());
    if (ordered) orders_.reply(std::filesystem::absolute(recorder.recording().files().back()).string(), "");
  }

 private:
  std::chrono::nanoseconds after_;
  bus::Participant participant_;
  recorder::SaveOrders orders_;
  std::optional<recorder::SavingEvents> events_;  ///< none: only orders save
};

ExitCode record(const Settings& settings, const RecordOptions& options) {
  const recorder::SaveSignal save;
  const std::string cell = options.cell.empty() ? settings.cell_file : options.cell;
  if (cell.empty()) throw Failure(ExitCode::kUsage, "record needs the cell file, as CELL, --cell or HECATON_CELL");
  const recorder::RecordingOptions recording = recording_of(options);
  const config::CellFile file = config::load_cell_file(cell);
  ServiceOptions service;
  service.domain = settings.domain;
  const int domain = choose_domain(service, file.network.domain);
  const ShutdownSignal shutdown(ShutdownSignal::Second::kEndsProcess);
  bus::Mailbox mailbox;
  bus::Participant participant = make_participant(file, service, Role::kViewer, recorder_node(), &mailbox);
  PeriodicLoop loop(recorder::Recorder::kPeriod, shutdown);
  recorder::Recorder recorder(file, participant, mailbox, recording);
  std::optional<Saving> saving;
  if (recording.keep.count() > 0) saving.emplace(file, service, options);
  std::fprintf(stderr, "recording cell %s, domain %d, into %s; Ctrl-C ends it\n", file.cell.name.c_str(), domain,
               recorder.recording().files().back().c_str());
  try {
    while (loop.next()) {
      if (saving) saving->take(recorder);
      recorder.take();
      if (options.duration > 0.0 && recorder.duration() >= seconds(options.duration)) break;
    }
    recorder.close();
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kNegative, error.what());
  }
  if (recorder.recording().messages() == 0) {
    recorder.remove_files();  // else the next try would be refused, because its file exists
    throw Failure(ExitCode::kUnreachable, "nothing was received, and no recording is kept: no cell " + file.cell.name +
                                              " runs in domain " + std::to_string(domain) +
                                              "; start it, or give its --domain");
  }
  print_result(settings, recorder);
  return ExitCode::kDone;
}

/// Orders the recorders of the cell, on whatever hosts.
ExitCode save(const Settings& given, const RecordOptions& options) {
  Settings settings = given;
  if (!options.cell.empty()) settings.cell_file = options.cell;
  Json json = Json::array();
  std::string table;
  for (const SavedRecording& saved : Cell(connect(settings)).save_recordings(answer_limit(settings))) {
    json.push_back({{"host", saved.host}, {"file", saved.file}});
    table += "the recorder on host " + saved.host + " saves what it keeps, up to " + saved.file + "\n";
  }
  print(settings, json, table);
  return ExitCode::kDone;
}

}  // namespace

void add_record(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("record", "Records all topics of a running cell into a file, until Ctrl-C");
  auto options = std::make_shared<RecordOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML) (--cell or HECATON_CELL)");
  CLI::Option* file =
      command->add_option("-o,--file", options->file, "the recording to write (.mcap); an existing file stays")
          ->type_name("FILE");
  add_duration(*command, "--duration", options->duration, "end after this time (Ctrl-C)", 0.1, kLongestRecord);
  command
      ->add_option("--split-size", options->split_size,
                   "begin another file above this size without attachments, such as 500MB (one file)")
      ->type_name("SIZE");
  add_duration(*command, "--split-time", options->split_time, "begin another file after this time (one file)", 1.0,
               kLongestRecord);
  CLI::Option* keep =
      add_duration(*command, "--keep", options->keep,
                   "keep only the last files: those that ended within this time (all)", 1.0, kLongestRecord);
  add_duration(*command, "--after-fault", options->after_fault,
               "after a fault or a stop, save what is kept and this time after it (nothing is saved)", 0.0,
               kLongestRecord)
      ->needs(keep);
  command->add_flag("--ros2", options->ros2,
                    "with the topics of ROS 2 that hecaton-ros2 would send, for other programs");
  command
      ->add_flag("--save", options->save,
                 "order the recorders of the cell, on any host, to save what they keep; record nothing")
      ->excludes(file);
  command->footer(
      "With --split-size, --split-time or --keep the files are FILE-0001.mcap and so on. --keep removes only files of "
      "this recording, and none that is saved; --save of another process and the signal SIGUSR1 save all that are "
      "there. A recording that ends "
      "without Ctrl-C lacks a second at most.");
  command->callback([&session, options] {
    session.action = options->save ? on_cell([&session, options] { return save(session.settings, *options); })
                                   : [&session, options] { return record(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
