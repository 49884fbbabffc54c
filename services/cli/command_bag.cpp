/// hecaton bag info|export: what a recording contains, and its messages as CSV or as a bag of ROS 2.

#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/cli/opened_recording.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/recorder/bag.hpp"
#include "services/replay/ros2_bag.hpp"

namespace hecaton::services::cli {
namespace {

struct BagOptions {
  std::vector<std::string> files;
  std::optional<std::string> folder;
  bool csv = false;
  bool ros2 = false;
};

/// Why the file is not whole, as sentences; empty: it is.
std::vector<std::string> damages_of(const recorder::McapReport& file) {
  std::vector<std::string> sentences = file.damages;
  if (file.cut) {
    sentences.insert(sentences.begin(),
                     "the recording has no end: its recorder was killed, had no room on the disk, or still writes");
  }
  return sentences;
}

/// After all that can be read was printed. Throws Failure (negative) when the file is not whole.
ExitCode judge(const std::string& path, const recorder::McapReport& file) {
  const std::vector<std::string> damages = damages_of(file);
  if (damages.empty()) return ExitCode::kDone;
  std::string more;
  if (damages.size() > 1) more = " (and " + std::to_string(damages.size() - 1) + " more)";
  throw Failure(ExitCode::kNegative, path + ": " + damages.front() + more + "; the " + std::to_string(file.messages) +
                                         " messages that its CRCs prove were read");
}

/// Messages a second, on average over the recording.
double rate_of(const recorder::TopicFigures& topic, const recorder::BagInfo& info) {
  return info.duration() > 0.0 ? static_cast<double>(topic.messages) / info.duration() : 0.0;
}

/// "12 kB", "34.5 MB"
std::string size_text(std::uint64_t bytes) {
  constexpr double kMegabytes = 1e7;
  const auto size = static_cast<double>(bytes);
  return size < kMegabytes ? decimal_text(size * 1e-3, 0) + " kB" : bytes_text(size);
}

/// "2026-11-28T14:05:20.123Z"
std::string utc_text(std::uint64_t nanoseconds) {
  const auto seconds = static_cast<std::time_t>(nanoseconds / 1'000'000'000U);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> date{};
  std::strftime(date.data(), date.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  std::array<char, 8> milliseconds{};
  std::snprintf(milliseconds.data(), milliseconds.size(), ".%03uZ",
                static_cast<unsigned>(nanoseconds / 1'000'000U % 1'000U));
  return std::string(date.data()) + milliseconds.data();
}

Json info_json(const recorder::BagInfo& info) {
  Json topics = Json::array();
  for (const auto& [name, topic] : info.topics) {
    topics.push_back({{"topic", name},
                      {"schema", topic.schema},
                      {"encoding", topic.encoding},
                      {"messages", topic.messages},
                      {"bytes", topic.bytes},
                      {"rate_hz", rate_of(topic, info)},
                      {"first_ns", topic.first},
                      {"last_ns", topic.last},
                      {"writers", topic.nodes}});
  }
  Json losses = Json::object();
  for (const auto& [name, topic] : info.losses) losses[name] = topic.fields();
  Json clocks = Json::object();
  for (const auto& [host, clock] : info.clocks) {
    clocks[host] = {{"log_minus_publish_ns", clock.last},
                    {"least_ns", clock.least},
                    {"most_ns", clock.most},
                    {"seconds", clock.seconds},
                    {"heartbeats", clock.samples},
                    {"steps", clock.steps},
                    {"largest_step_ns", clock.largest_step},
                    {"largest_step_at_ns", clock.stepped_at}};
  }
  Json attachments = Json::array();
  for (const recorder::BagFile& file : info.attachments) {
    attachments.push_back({{"name", file.name}, {"media_type", file.media_type}, {"bytes", file.bytes}});
  }
  return {{"cell", info.cell ? Json(*info.cell) : Json(nullptr)},
          {"bytes", info.file.bytes},
          {"messages", info.file.messages},
          {"start", info.simulated ? Json(nullptr) : Json(utc_text(info.first))},
          {"duration_s", info.duration()},
          {"simulated", info.simulated},
          {"first_ns", info.first},
          {"last_ns", info.last},
          {"whole", info.file.whole()},
          {"damages", damages_of(info.file)},
          {"losses", info.has_losses ? losses : Json(nullptr)},
          {"clocks", clocks},
          {"attachments", attachments},
          {"topics", topics}};
}

std::string losses_text(const recorder::BagInfo& info) {
  if (!info.has_losses) return "losses: unknown, the recording has no report\n";
  std::string text;
  for (const auto& [name, topic] : info.losses) {
    if (topic.any()) text += "  " + name + ": " + topic.text() + "\n";
  }
  return text.empty() ? "losses: none\n" : "losses:\n" + text;
}

/// "0.31 ms", "-60.000 s"
std::string offset_text(std::int64_t nanoseconds) {
  const double milliseconds = static_cast<double>(nanoseconds) * 1e-6;
  const bool long_one = milliseconds >= 1e3 || milliseconds <= -1e3;
  return long_one ? decimal_text(milliseconds * 1e-3, 3) + " s" : decimal_text(milliseconds, 2) + " ms";
}

/// A sentence for each host.
std::string clocks_text(const recorder::BagInfo& info) {
  std::string text;
  for (const auto& [host, clock] : info.clocks) {
    text += "clock of " + host + ": behind the recorder's by at most " + offset_text(clock.last) + " at the end, " +
            offset_text(clock.least) + " to " + offset_text(clock.most) + " before";
    if (clock.steps > 0) {
      text += "; " + std::to_string(clock.steps) + " steps, the largest by " + offset_text(-clock.largest_step) +
              " at " + utc_text(clock.stepped_at);
    }
    text += "\n";
  }
  return text;
}

std::string info_text(const recorder::BagInfo& info) {
  const std::string when = info.simulated ? " of virtual time" : " from " + utc_text(info.first);
  std::string text = "cell " + info.cell.value_or("unknown") + ", " + duration_text(info.duration()) + when + ", " +
                     std::to_string(info.file.messages) + " messages, " + size_text(info.file.bytes) + "\n";
  Table table({{"topic"}, {"messages", Align::kRight}, {"rate", Align::kRight}, {"size", Align::kRight}, {"writers"}});
  for (const auto& [name, topic] : info.topics) {
    std::string nodes;
    for (const std::string& node : topic.nodes) nodes += (nodes.empty() ? "" : ", ") + node;
    table.add({name, std::to_string(topic.messages), decimal_text(rate_of(topic, info), 1) + "/s",
               size_text(topic.bytes), nodes});
  }
  text += table.text(Palette::for_stream(stdout)) + losses_text(info) + clocks_text(info);
  for (const recorder::BagFile& file : info.attachments) {
    text += "attached: " + file.name + ", " + size_text(file.bytes) + "\n";
  }
  return text;
}

ExitCode show_info(const Settings& settings, const BagOptions& options) {
  try {
    const recorder::BagInfo info = recorder::bag_info(options.files.front());
    print(settings, info_json(info), info_text(info));
    return judge(options.files.front(), info.file);
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
}

ExitCode export_ros2(const Settings& settings, const BagOptions& options) {
  const auto recording = open_recording(options.files);
  std::vector<replay::Ros2BagTopic> topics;
  try {
    Progress progress;
    topics = replay::export_ros2_bag(recording->index, recording->files.cell, *options.folder, [&](double share) {
      progress.show("writing " + *options.folder, share * 100.0, 100.0, "%");
    });
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
  Json json = Json::array();
  Table table({{"topic"}, {"type"}, {"messages", Align::kRight}});
  for (const replay::Ros2BagTopic& topic : topics) {
    json.push_back({{"topic", topic.name}, {"type", topic.type}, {"messages", topic.messages}});
    table.add({topic.name, topic.type, std::to_string(topic.messages)});
  }
  print(settings, {{"folder", *options.folder}, {"topics", json}, {"findings", notes_json(recording->index.notes)}},
        table.text(Palette::for_stream(stdout)));
  return recording->index.whole ? ExitCode::kDone : ExitCode::kNegative;  // its notes are printed
}

ExitCode export_bag(const Settings& settings, const BagOptions& options) {
  if (options.csv == options.ros2) throw Failure(ExitCode::kUsage, "bag export needs one format: --csv or --ros2");
  if (!options.folder) throw Failure(ExitCode::kUsage, "bag export needs the folder to write into: -o DIR");
  if (options.ros2) return export_ros2(settings, options);
  try {
    const recorder::ExportReport report = recorder::export_csv(options.files, *options.folder);
    Json files = Json::array();
    Table table({{"file"}, {"rows", Align::kRight}});
    std::vector<std::string> notes;
    for (const auto& [name, topic] : report.topics) {
      files.push_back({{"file", topic.file}, {"topic", name}, {"rows", topic.rows}, {"skipped", topic.skipped}});
      table.add({topic.file, std::to_string(topic.rows)});
      if (topic.skipped == 0) continue;
      notes.push_back(std::to_string(topic.skipped) + " messages of " + name + " have no row: " + topic.reason);
    }
    notes.insert(notes.end(), report.notes.begin(), report.notes.end());
    for (const std::string& note : notes) std::fprintf(stderr, "hecaton: %s\n", note.c_str());
    for (std::size_t i = 0; i < options.files.size(); ++i) {
      for (const std::string& damage : damages_of(report.files[i])) notes.push_back(options.files[i] + ": " + damage);
    }
    print(settings, {{"files", files}, {"findings", notes_json(notes)}}, table.text(Palette::for_stream(stdout)));
    for (std::size_t i = 0; i < options.files.size(); ++i) judge(options.files[i], report.files[i]);
    return ExitCode::kDone;
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
}

}  // namespace

void add_bag(CLI::App& app, Session& session) {
  CLI::App* bag = app.add_subcommand("bag", "Shows or converts a recording");
  bag->require_subcommand(1);
  auto options = std::make_shared<BagOptions>();
  CLI::App* info = bag->add_subcommand("info", "Shows topics, rates, losses, clocks and attached files");
  info->add_option("FILE", options->files, "recording (.mcap)")->required()->expected(1);
  info->footer("Exit code 1: the recording has no end or is damaged; what its CRCs prove is shown.");
  info->callback(
      [&session, options] { session.action = [&session, options] { return show_info(session.settings, *options); }; });
  CLI::App* exporter = bag->add_subcommand("export", "Writes CSV files, or a bag of ROS 2");
  add_recording_files(*exporter, options->files);
  exporter
      ->add_option("-o,--folder", options->folder,
                   "folder of the files; existing files stay, and a bag needs a new folder")
      ->type_name("DIR");
  exporter->add_flag("--csv", options->csv, "comma-separated values (RFC 4180), one row a message");
  exporter->add_flag("--ros2", options->ros2, "the topics of hecaton-ros2, for 'ros2 bag play' and Foxglove");
  exporter->footer(
      "Exit code 1: a recording has no end or is damaged; what its CRCs prove is written. "
      "In CSV the first columns are the times of arrival and of writing [ns since 1970] and the writer. Then come the "
      "fields "
      "of the message; an enumerator is its number, counted from 0.");
  exporter->callback(
      [&session, options] { session.action = [&session, options] { return export_bag(session.settings, *options); }; });
}

}  // namespace hecaton::services::cli
