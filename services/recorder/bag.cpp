#include "services/recorder/bag.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include <nlohmann/json.hpp>

#include "services/recorder/cdr_columns.hpp"
#include "services/recorder/current_messages.hpp"
#include "services/recorder/recording.hpp"

namespace hecaton::services::recorder {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kTopicPrefix = "hecaton/";
constexpr std::string_view kTypePrefix = "hecaton::msg::";

std::string metadata(const McapChannel& channel, const char* key) {
  const auto found = channel.metadata.find(key);
  return found == channel.metadata.end() ? std::string() : found->second;
}

/// The message also stands in the file before, or is older.
bool is_repeated(const McapChannel& channel) {
  return metadata(channel, "repeated") == "true";
}

/// Reads what Recorder::report() writes; leaves out what it does not understand.
void take_report(ByteSpan text, BagInfo& info) {
  const Json json = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!json.is_object()) return;
  if (const auto cell = json.find("cell"); cell != json.end() && cell->is_string()) info.cell = *cell;
  const auto topics = json.find("topics");
  if (topics == json.end() || !topics->is_object()) return;
  info.has_losses = true;
  for (const auto& topic : topics->items()) {
    const auto count = [&figures = topic.value()](const char* key) {
      const auto found = figures.find(key);
      return found != figures.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0U;
    };
    info.losses[topic.key()] = {count("received"), count("missing"), count("lost"), count("overflowed"),
                                count("refused")};
  }
}

/// Reads what Recorder::report_clocks() writes; leaves out what it does not understand.
void take_clocks(const McapMessage& message, BagInfo& info) {
  constexpr std::int64_t kMost = 4'000'000'000'000'000'000;  // [ns] of an offset
  const Json json = Json::parse(message.data.begin(), message.data.end(), nullptr, false);
  const auto hosts = json.is_object() ? json.find("hosts") : json.end();
  if (hosts == json.end() || !hosts->is_object()) return;
  for (const auto& host : hosts->items()) {
    const Json& clock = host.value();
    const auto number = [&clock](const char* key) -> std::optional<std::int64_t> {
      const auto found = clock.is_object() ? clock.find(key) : clock.end();
      return found != clock.end() && found->is_number_integer() ? std::optional(found->get<std::int64_t>())
                                                                : std::nullopt;
    };
    const auto offset = number("log_minus_publish_ns");
    const auto heartbeats = number("heartbeats");
    if (!offset || !heartbeats || *heartbeats < 0 || *offset > kMost || *offset < -kMost) continue;
    info.clocks[host.key()].note(*offset, static_cast<std::uint64_t>(*heartbeats), message.log_time);
  }
}

/// The rule of the messages of a channel; null: they are none of Hecaton's.
const bus::TopicRule* rule_of(const McapChannel& channel) {
  if (channel.encoding != "cdr" || !channel.schema || !channel.topic.starts_with(kTopicPrefix)) return nullptr;
  const std::string_view name = channel.schema->name;
  return name.starts_with(kTypePrefix) ? bus::topic_rule(name.substr(kTypePrefix.size())) : nullptr;
}

struct CloseFile {
  void operator()(std::FILE* file) const { static_cast<void>(std::fclose(file)); }
};

/// The CSV file of one topic.
struct Sheet {
  explicit Sheet(const bus::TopicRule& rule) : columns(rule) {}
  CdrColumns columns;
  std::unique_ptr<std::FILE, CloseFile> file;
};

class Export {
 public:
  Export(const std::vector<std::string>& paths, const std::string& folder) : paths_(paths), folder_(folder) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw RecordingError(folder + " cannot be made: " + error.message() + "; name another folder");
  }

  ExportReport run() {
    try {
      return write_all();
    } catch (...) {
      // Half a table looks like a whole one, and would refuse the next try.
      for (const std::string& file : made_) static_cast<void>(std::remove(file.c_str()));
      throw;
    }
  }

 private:
  ExportReport write_all() {
    // The longest sequences decide how many columns there are.
    for (const std::string& path : paths_) {
      report_.files.push_back(read_mcap(path, {[this](const McapMessage& message) { measure(message); }, {}}));
    }
    for (auto& [topic, sheet] : sheets_) begin(topic, *sheet);
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      report_.files[i] =
          read_mcap(paths_[i], {[this](const McapMessage& message) { put(message); }, {}}, report_.files[i].bytes);
    }
    for (auto& [topic, sheet] : sheets_) {
      if (std::fclose(sheet->file.release()) != 0) fail_to_write(report_.topics[topic].file);
    }
    report_.notes = current_.notes();
    return std::move(report_);
  }

  [[noreturn]] static void fail(const std::string& file, const std::string& what) {
    throw RecordingError(file + " " + what + "; name another folder");
  }

  /// With the reason in errno.
  [[noreturn]] static void fail_to_write(const std::string& file) {
    const bool full = errno == ENOSPC || errno == EFBIG || errno == EDQUOT;
    throw RecordingError(file + " cannot be written: " + (full ? "the disk is full" : std::strerror(errno)) +
                         "; make room or name another folder; no file of this export is kept");
  }

  static void write(const ExportedTopic& exported, Sheet& sheet, const std::vector<std::string>& cells) {
    const std::string line = csv_line(cells);
    if (std::fwrite(line.data(), 1, line.size(), sheet.file.get()) != line.size()) fail_to_write(exported.file);
  }

  void measure(const McapMessage& message) {
    const bus::TopicRule* rule = rule_of(*message.channel);
    if (rule == nullptr || is_repeated(*message.channel)) return;
    auto& sheet = sheets_[message.channel->topic];
    if (!sheet) sheet = std::make_unique<Sheet>(*rule);
    const CurrentMessage current = current_.of(message);
    if (current.refusal.empty()) static_cast<void>(sheet->columns.measure(current.data));
  }

  void begin(const std::string& topic, Sheet& sheet) {
    ExportedTopic& exported = report_.topics[topic];
    std::string name = topic.substr(kTopicPrefix.size());
    std::replace(name.begin(), name.end(), '/', '_');
    exported.file = (folder_ / (name + ".csv")).string();
    sheet.file.reset(std::fopen(exported.file.c_str(), "wbx"));
    if (!sheet.file && errno == EEXIST) fail(exported.file, "exists already");
    if (!sheet.file) fail(exported.file, std::string("cannot be written: ") + std::strerror(errno));
    made_.push_back(exported.file);
    std::vector<std::string> header{"log_time_ns", "publish_time_ns", "writer_node", "writer_guid"};
    const std::vector<std::string> fields = sheet.columns.header();
    header.insert(header.end(), fields.begin(), fields.end());
    write(exported, sheet, header);
  }

  void put(const McapMessage& message) {
    if (rule_of(*message.channel) == nullptr || is_repeated(*message.channel)) return;
    const McapChannel& channel = *message.channel;
    Sheet& sheet = *sheets_.at(channel.topic);
    ExportedTopic& exported = report_.topics.at(channel.topic);
    CurrentMessage current = current_.of(message);
    if (current.refusal.empty()) current.refusal = sheet.columns.measure(current.data).value_or("");
    if (!current.refusal.empty()) {
      ++exported.skipped;
      exported.reason = std::move(current.refusal);
      return;
    }
    std::vector<std::string> cells{std::to_string(message.log_time), std::to_string(message.publish_time),
                                   metadata(channel, "node"), metadata(channel, "writer")};
    std::vector<std::string> fields = sheet.columns.row(current.data);
    std::move(fields.begin(), fields.end(), std::back_inserter(cells));
    write(exported, sheet, cells);
    ++exported.rows;
  }

  const std::vector<std::string>& paths_;
  std::filesystem::path folder_;
  std::map<std::string, std::unique_ptr<Sheet>> sheets_;
  CurrentMessages current_;
  std::vector<std::string> made_;  ///< files, to be removed when the export fails
  ExportReport report_;
};

}  // namespace

double BagInfo::duration() const {
  return static_cast<double>(last - first) * 1e-9;
}

BagInfo bag_info(const std::string& path) {
  BagInfo info;
  const auto take_message = [&info](const McapMessage& message) {
    const McapChannel& channel = *message.channel;
    if (channel.topic == Recording::kReport) take_report(message.data, info);
    if (channel.topic == Recording::kClocks) take_clocks(message, info);
    if (is_repeated(channel)) return;
    TopicFigures& topic = info.topics[channel.topic];
    if (topic.messages++ == 0) {
      topic.first = topic.last = message.log_time;
      topic.schema = channel.schema ? channel.schema->name : "";
      topic.encoding = channel.encoding;
    }
    topic.first = std::min(topic.first, message.log_time);
    topic.last = std::max(topic.last, message.log_time);
    topic.bytes += message.data.size();
    if (const auto node = channel.metadata.find("node"); node != channel.metadata.end())
      topic.nodes.insert(node->second);
  };
  const auto take_attachment = [&info](const McapAttachment& attachment) {
    info.simulated = info.simulated || attachment.name == Recording::kSimulation;
    info.attachments.push_back({attachment.name, attachment.media_type, attachment.data.size()});
  };
  info.file = read_mcap(path, {take_message, take_attachment});
  bool any = false;
  for (const auto& [name, topic] : info.topics) {
    info.first = any ? std::min(info.first, topic.first) : topic.first;
    info.last = any ? std::max(info.last, topic.last) : topic.last;
    any = true;
  }
  return info;
}

ExportReport export_csv(const std::vector<std::string>& paths, const std::string& folder) {
  return Export(paths, folder).run();
}

}  // namespace hecaton::services::recorder
