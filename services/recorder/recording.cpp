#include "services/recorder/recording.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include <nlohmann/json.hpp>

#include "services/recorder/message_schema.hpp"

namespace hecaton::services::recorder {
namespace {

using namespace std::chrono_literals;

constexpr const char* kLibrary = "hecaton";

std::uint64_t nanoseconds_of(std::chrono::nanoseconds time) {
  return static_cast<std::uint64_t>(time.count());
}

/// "run-0001.mcap"
std::string numbered(const std::string& path, int number) {
  const std::filesystem::path file(path);
  std::array<char, 16> digits{};
  std::snprintf(digits.data(), digits.size(), "-%04d", number);
  return (file.parent_path() / (file.stem().string() + digits.data() + file.extension().string())).string();
}

const char* yes(bool value) {
  return value ? "true" : "false";
}

/// Quality of service and identity of a writer's topic, as texts.
StringMap channel_metadata(const bus::TopicInfo& topic, const bus::EndpointId& writer, const std::string& node,
                           bool repeated) {
  const auto milliseconds = [](std::chrono::milliseconds time) { return std::to_string(time.count()) + "ms"; };
  return {{"writer", writer.text()},
          {"node", node},
          {"repeated", yes(repeated)},
          {"reliable", yes(topic.qos.reliable)},
          {"transient_local", yes(topic.qos.transient_local)},
          {"depth", std::to_string(topic.qos.depth)},
          {"deadline", milliseconds(topic.qos.deadline)},
          {"writers", std::string(topic.writers)},
          {"readers", std::string(topic.readers)}};
}

}  // namespace

Recording::Recording(RecordingOptions options, std::vector<AttachedFile> attachments, std::uint64_t now)
    : options_(std::move(options)), attachments_(std::move(attachments)) {
  if (options_.keep.count() > 0 && options_.split_time.count() == 0) {
    options_.split_time = std::clamp<std::chrono::nanoseconds>(options_.keep / 10, 1s, 60s);
  }
  for (const std::string& path : options_.former) {
    std::error_code error;
    const std::uint64_t bytes = std::filesystem::file_size(path, error);
    if (!error) segments_.push_back({path, identity_of(path), 0, bytes, true});
  }
  begin_file(now);
}

void Recording::begin_file(std::uint64_t now) {
  ++number_;
  file_ = std::make_unique<McapWriter>(options_.is_row() ? numbered(options_.path, number_) : options_.path, kLibrary);
  began_ = flushed_ = now;
  schemas_.clear();
  channels_.clear();
  json_channels_.clear();
  made_schemas_.clear();
  for (Made& made : made_) made.channel = 0;
  try {
    for (const AttachedFile& attached : attachments_) {
      file_->attach(attached.name, attached.media_type, now, attached.text);
    }
    attached_bytes_ = file_->size();
    if (report_) write_json(kReport, *report_, now);
    for (const auto& [key, recorded] : latched_) write_to_file(recorded, true);
    for (Made& made : made_) {
      if (!made.last.empty()) write_made_to_file(made, made.last, now);
    }
  } catch (const RecordingError&) {
    file_->discard();  // nothing of the cell is in it yet
    throw;
  }
}

void Recording::end_file() {
  if (report_) file_->add_metadata("hecaton", {{"report", *report_}});
  file_->close();
  closed_bytes_ += file_->size();
}

void Recording::write(RecordedSample recorded) {
  const bus::RawSample& sample = recorded.sample;
  const bus::TopicInfo& topic = bus::kTopics[sample.topic];
  if (sample.withdrawn) {
    const nlohmann::ordered_json json{
        {"topic", topic.name}, {"key", sample.key}, {"writer", sample.writer.text()}, {"node", recorded.node}};
    write_json(kWithdrawn, json.dump(), recorded.log_time);
    latched_.erase({sample.topic, sample.key});
    return;
  }
  write_to_file(recorded, false);
  ++messages_;
  if (options_.is_row() && topic.qos.transient_local) {
    latched_.insert_or_assign({sample.topic, sample.key}, std::move(recorded));
  }
}

void Recording::write_to_file(const RecordedSample& recorded, bool repeated) {
  const bus::RawSample& sample = recorded.sample;
  OutgoingMessage message;
  message.channel = channel_of(recorded, repeated);
  message.sequence = static_cast<std::uint32_t>(sample.number);
  message.log_time = recorded.log_time;
  message.publish_time = sample.written_ns > 0 ? static_cast<std::uint64_t>(sample.written_ns) : recorded.log_time;
  message.data = sample.bytes;
  file_->write(message);
}

std::uint16_t Recording::channel_of(const RecordedSample& recorded, bool repeated) {
  const std::size_t index = recorded.sample.topic;
  ChannelKey key(index, recorded.sample.writer, repeated);
  std::string node = recorded.node;
  if (const auto known = channels_.find(key); known != channels_.end()) return known->second;
  if (channels_.size() >= kMostChannels) {
    std::get<1>(key) = {};
    node.clear();
    if (const auto known = channels_.find(key); known != channels_.end()) return known->second;
  }
  const bus::TopicInfo& topic = bus::kTopics[index];
  auto schema = schemas_.find(index);
  if (schema == schemas_.end()) {
    const std::string type(topic.type);
    schema = schemas_.emplace(index, file_->add_schema("hecaton::msg::" + type, "omgidl", message_schema(type))).first;
  }
  const std::uint16_t channel = file_->add_channel(schema->second, std::string(topic.name), "cdr",
                                                   channel_metadata(topic, std::get<1>(key), node, repeated));
  channels_.emplace(key, channel);
  return channel;
}

void Recording::write_json(std::string_view topic, const std::string& json, std::uint64_t now) {
  auto channel = json_channels_.find(topic);
  if (channel == json_channels_.end()) {
    channel = json_channels_.emplace(topic, file_->add_channel(0, std::string(topic), "json", {})).first;
  }
  OutgoingMessage message;
  message.channel = channel->second;
  message.log_time = message.publish_time = now;
  message.data = {reinterpret_cast<const std::uint8_t*>(json.data()), json.size()};
  file_->write(message);
}

void Recording::set_made_topics(std::vector<MadeTopic> topics) {
  for (MadeTopic& topic : topics) made_.push_back({std::move(topic), 0, 0, {}});
}

void Recording::write_made(std::size_t topic, ByteSpan cdr, std::uint64_t now) {
  Made& made = made_.at(topic);
  ++made.written;
  write_made_to_file(made, cdr, now);
  if (made.about.latched && options_.is_row()) made.last.assign(cdr.begin(), cdr.end());
}

void Recording::write_made_to_file(Made& made, ByteSpan cdr, std::uint64_t now) {
  if (made.channel == 0) {
    const auto [schema, first] = made_schemas_.try_emplace(made.about.type, std::uint16_t{0});
    if (first) schema->second = file_->add_schema(made.about.type, "ros2msg", made.about.definition);
    made.channel = file_->add_channel(schema->second, made.about.name, "cdr", made.about.metadata);
  }
  file_->write({made.channel, made.written, now, now, cdr});
}

void Recording::report(const std::string& json, std::uint64_t now) {
  report_ = json;
  write_json(kReport, json, now);
}

void Recording::keep_up(std::uint64_t now) {
  if (now - flushed_ >= nanoseconds_of(kFlush)) {
    file_->flush();
    flushed_ = now;
  }
  const bool large = options_.split_bytes > 0 && file_->size() - attached_bytes_ >= options_.split_bytes;
  const bool old = options_.split_time.count() > 0 && now - began_ >= nanoseconds_of(options_.split_time);
  if (large || old) {
    end_file();
    segments_.push_back({file_->path(), file_->identity(), now, file_->size(), began_ <= saved_until_});
    begin_file(now);
  }
  if (options_.keep.count() > 0) remove_old(now);
  if (options_.most_bytes > 0) remove_excess();
}

void Recording::save(std::uint64_t until) {
  for (Segment& segment : segments_) segment.saved = true;
  saved_until_ = std::max(saved_until_, until);
}

void Recording::remove_old(std::uint64_t now) {
  std::erase_if(segments_, [&](const Segment& segment) {
    if (segment.saved || now - segment.ended <= nanoseconds_of(options_.keep)) return false;
    remove(segment);
    return true;
  });
}

void Recording::remove_excess() {
  std::uint64_t bytes = file_->size();
  for (const Segment& segment : segments_) bytes += segment.bytes;
  for (; bytes > options_.most_bytes && !segments_.empty(); segments_.pop_front()) {
    bytes -= segments_.front().bytes;
    remove(segments_.front());
  }
}

void Recording::remove(const Segment& segment) {
  // Another file may have its name by now.
  if (identity_of(segment.path) != segment.identity) return;
  std::error_code error;
  std::filesystem::remove(segment.path, error);
  if (error) throw RecordingError(segment.path + " cannot be removed: " + error.message() + "; allow its removal");
}

void Recording::remove_files() {
  for (; !segments_.empty(); segments_.pop_front()) remove(segments_.front());
}

void Recording::close() {
  if (!file_) return;
  end_file();
  segments_.push_back({file_->path(), file_->identity(), began_, file_->size(), true});
  file_.reset();
}

std::vector<std::string> Recording::files() const {
  std::vector<std::string> paths;
  for (const Segment& segment : segments_) paths.push_back(segment.path);
  if (file_) paths.push_back(file_->path());
  return paths;
}

namespace {

/// Begins as the files that McapWriter makes: magic bytes, then a header with no profile and our name.
bool is_own(const std::filesystem::path& path) {
  const std::string_view magic("\x89MCAP0\r\n", 8);
  constexpr std::size_t kHeader = 8 + 1 + 8 + 4;  // magic, opcode, length, empty profile
  const std::string library = std::string("\x07\0\0\0", 4) + kLibrary;
  std::string begin(kHeader + library.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return file && begin.starts_with(magic) && begin.ends_with(library);
}

}  // namespace

std::vector<std::string> former_files(const std::string& row, const std::string& cell) {
  const std::regex form("-([0-9]{8}T[0-9]{6}Z)-([0-9]{4,9})\\.mcap");
  std::map<std::pair<std::string, int>, std::string> files;  // by row and number
  std::error_code error;
  std::filesystem::directory_iterator entries(std::filesystem::path(row).parent_path(), error);
  if (error) return {};
  for (const auto& entry : entries) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    const std::string rest = name.starts_with(cell) ? name.substr(cell.size()) : std::string();
    if (!std::regex_match(rest, parts, form)) continue;
    if (entry.symlink_status(error).type() != std::filesystem::file_type::regular || !is_own(entry.path())) continue;
    files[{parts[1], std::stoi(parts[2])}] = entry.path().string();
  }
  std::vector<std::string> paths;
  for (const auto& [key, path] : files) paths.push_back(path);
  return paths;
}

}  // namespace hecaton::services::recorder
