/// Recordings that are cut at random places, or in which random bits are flipped: no reader crashes, no value is wrong,
/// and each reader reports what is missing.
///
/// HECATON_DAMAGES=1000 damages the recording so often (200). HECATON_RECORDING=FILE.mcap takes this recording instead
/// of one of a simulation. HECATON_SEED=7 damages it at other places (1).

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "planner/local/random.hpp"
#include "services/command_line/document.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

using test::TemporaryFolder;

std::string content_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string content(std::filesystem::file_size(path), '\0');
  stream.read(content.data(), static_cast<std::streamsize>(content.size()));
  return content;
}

std::string variable(const char* name, const std::string& otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : value;
}

/// All that a reader passes on, in its order.
struct Contents {
  explicit Contents(const std::string& path) {
    recorder::McapVisitor visitor;
    visitor.message = [this](const recorder::McapMessage& message) {
      const auto [channel, first] = channels.try_emplace(message.channel);
      if (first) channel->second = digest_of(*message.channel);
      std::string text = channel->second + "|" + std::to_string(message.sequence) + "|" +
                         std::to_string(message.log_time) + "|" + std::to_string(message.publish_time) + "|";
      text.append(message.data.begin(), message.data.end());
      messages.push_back(std::hash<std::string>()(text));
    };
    visitor.attachment = [this](const recorder::McapAttachment& file) {
      attachments.push_back(file.name + "|" + file.media_type + "|" + std::string(file.data.begin(), file.data.end()));
    };
    report = recorder::read_mcap(path, visitor);
  }

  /// Topic, schema and metadata.
  static std::string digest_of(const recorder::McapChannel& channel) {
    std::string text = channel.topic + "|" + channel.encoding + "|" + (channel.schema ? channel.schema->data : "");
    for (const auto& [key, value] : channel.metadata) text += "|" + key + "=" + value;
    return std::to_string(std::hash<std::string>()(text));
  }

  std::map<std::shared_ptr<const recorder::McapChannel>, std::string> channels;
  std::vector<std::size_t> messages;
  std::vector<std::string> attachments;
  recorder::McapReport report;
};

/// Each of `some` is in `all`, in the same order.
template <class T>
bool is_part(const std::vector<T>& some, const std::vector<T>& all) {
  auto from = all.begin();
  for (const T& one : some) {
    from = std::find(from, all.end(), one);
    if (from == all.end()) return false;
    ++from;
  }
  return true;
}

/// A digest of each row of a CSV file: of "column=value" of all its cells that are not empty. A cell in quotes may have
/// commas and line ends.
std::vector<std::size_t> rows_of(const std::string& path) {
  const std::string text = content_of(path);
  std::vector<std::string_view> columns;
  std::vector<std::size_t> rows;
  std::string row;
  std::size_t column = 0;
  bool quoted = false;
  bool titles = true;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted || (c != ',' && c != '\n')) continue;
    const std::size_t end = c == '\n' && i > begin && text[i - 1] == '\r' ? i - 1 : i;
    const std::string_view cell = std::string_view(text).substr(begin, end - begin);
    begin = i + 1;
    if (titles) {
      columns.push_back(cell);
    } else if (!cell.empty()) {
      row.append(columns.at(column)).append("=").append(cell).append(";");
    }
    ++column;
    if (c == ',') continue;
    if (!titles) rows.push_back(std::hash<std::string>()(row));
    titles = false;
    row.clear();
    column = 0;
  }
  return rows;
}

/// By file.
std::map<std::string, std::vector<std::size_t>> tables_of(const std::string& folder) {
  std::map<std::string, std::vector<std::size_t>> tables;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    tables[entry.path().filename().string()] = rows_of(entry.path().string());
  }
  return tables;
}

class DamagedRecording : public testing::Test {
 protected:
  static constexpr int kDamages = 200;

  void SetUp() override {
    original_ = variable("HECATON_RECORDING", "");
    if (original_.empty()) {
      original_ = folder_.path("original.mcap");
      const Ran ran = run_line({"simulate", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml",
                                "--tasks", "3", "--seed", "3", "--record", original_, "-o", "json"});
      ASSERT_TRUE(std::filesystem::exists(original_)) << ran.err;
    }
    bytes_ = content_of(original_);
    contents_.emplace(original_);
    ASSERT_TRUE(contents_->report.whole());
    ASSERT_EQ(run_line({"bag", "export", original_, "--csv", "-o", folder_.path("whole")}).code, ExitCode::kDone);
    tables_ = tables_of(folder_.path("whole"));
  }

  /// Runs all readers on the damaged file.
  void check(const std::string& bytes) {
    const std::string path = folder_.path("damaged.mcap");
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
    std::optional<Contents> left;
    try {
      left.emplace(path);
    } catch (const recorder::RecordingError&) {  // its first bytes are not those of a recording
    }
    if (left) check_contents(*left);
    const bool whole = left && left->report.whole();
    check_info(path, left, whole);
    check_export(path, left.has_value(), whole);
    check_verification(path);
  }

  void check_contents(const Contents& left) {
    EXPECT_TRUE(is_part(left.messages, contents_->messages)) << "a message differs";
    EXPECT_TRUE(is_part(left.attachments, contents_->attachments)) << "an attachment differs";
    const bool all =
        left.messages.size() == contents_->messages.size() && left.attachments.size() == contents_->attachments.size();
    EXPECT_TRUE(all || !left.report.whole()) << "a loss is not told";
    lost_ += contents_->messages.size() - std::min(contents_->messages.size(), left.messages.size());
    if (!left.report.whole()) ++told_;
  }

  static void check_info(const std::string& path, const std::optional<Contents>& left, bool whole) {
    const Ran info = run_line({"bag", "info", path, "-o", "json"});
    if (!left) {
      EXPECT_EQ(info.code, ExitCode::kBadInput);
      return;
    }
    EXPECT_EQ(info.code, whole ? ExitCode::kDone : ExitCode::kNegative);
    EXPECT_EQ(Json::parse(info.out).at("messages"), left->messages.size());
  }

  void check_export(const std::string& path, bool is_recording, bool whole) {
    const std::string folder = folder_.path("damaged");
    const Ran ran = run_line({"bag", "export", path, "--csv", "-o", folder, "--output", "json"});
    EXPECT_EQ(ran.code, !is_recording ? ExitCode::kBadInput : whole ? ExitCode::kDone : ExitCode::kNegative) << ran.err;
    if (is_recording && !whole && !ran.out.empty()) {
      EXPECT_FALSE(Json::parse(ran.out).at("findings").empty()) << "the damage is not told";
    }
    if (!std::filesystem::exists(folder)) return;
    for (const auto& [file, rows] : tables_of(folder)) {
      EXPECT_TRUE(is_part(rows, tables_[file])) << file << " has a row that the whole recording does not have";
    }
    std::filesystem::remove_all(folder);
  }

  /// No recomputed tick differs. A recording without its cell file is refused.
  void check_verification(const std::string& path) {
    const Ran ran = run_line({"replay", path, "--verify", "-o", "json"});
    EXPECT_TRUE(ran.code == ExitCode::kDone || ran.code == ExitCode::kNegative || ran.code == ExitCode::kBadInput);
    if (ran.out.empty()) return;
    const Json verified = Json::parse(ran.out);
    for (const Json& arm : verified.at("arms")) {
      EXPECT_EQ(arm.at("differing"), 0U) << ran.out;
      EXPECT_EQ(arm.at("differing_memories"), 0U) << ran.out;
      recomputed_ += arm.at("recomputed").get<std::uint64_t>();
    }
  }

  TemporaryFolder folder_;
  std::string original_;
  std::string bytes_;
  std::optional<Contents> contents_;
  std::map<std::string, std::vector<std::size_t>> tables_;
  // Of all damages.
  int told_ = 0;
  std::uint64_t lost_ = 0;        ///< messages
  std::uint64_t recomputed_ = 0;  ///< ticks
};

TEST_F(DamagedRecording, GivesNoWrongValue) {
  const int damages = std::stoi(variable("HECATON_DAMAGES", std::to_string(kDamages)));
  planner::Random random(std::stoull(variable("HECATON_SEED", "1")));
  const auto place = [&] { return static_cast<std::size_t>(random.next() % bytes_.size()); };
  int cuts = 0;
  for (int i = 0; i < damages && !HasFailure(); ++i) {
    std::string damaged = bytes_;
    std::ostringstream what;
    const bool is_cut = i % 2 == 0;
    if (is_cut) {
      ++cuts;
      damaged.resize(place());
      what << "cut at byte " << damaged.size();
    } else {
      const std::size_t at = place();
      const auto bit = static_cast<unsigned>(random.next() % 8U);
      damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ (1U << bit));
      what << "bit " << bit << " of byte " << at << " flipped";
    }
    SCOPED_TRACE(what.str() + " of " + std::to_string(bytes_.size()));
    const int told_before = told_;
    check(damaged);
    if (is_cut) {
      EXPECT_GT(told_, told_before);
    }
  }
  std::printf(
      "%d cuts and %d flipped bits of %s (%zu messages, %zu bytes): %d told, %llu messages left out, %llu ticks "
      "recomputed, none wrong\n",
      cuts, damages - cuts, original_.c_str(), contents_->messages.size(), bytes_.size(), told_,
      static_cast<unsigned long long>(lost_), static_cast<unsigned long long>(recomputed_));
  EXPECT_GT(recomputed_, 0U);
}

}  // namespace
}  // namespace hecaton::services::cli
