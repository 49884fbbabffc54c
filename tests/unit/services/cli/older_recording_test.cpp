/// Recordings of other versions of the messages: those of tests/data/recordings, which former versions of Hecaton have
/// made, and recordings of this version whose messages and structures are changed to what an older one could have had.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <idl/common.h>

#include "services/command_line/document.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/mcap_writer.hpp"
#include "services/recorder/message_conversion.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

using test::TemporaryFolder;

/// A CSV file: rows of values by column. Cells in quotes may have commas, and no line ends.
using Rows = std::vector<std::map<std::string, std::string>>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

Rows rows_in(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> columns = cells_of(line);
  Rows rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = cells_of(line);
    EXPECT_EQ(cells.size(), columns.size()) << path;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) row[columns[i]] = cells[i];
  }
  return rows;
}

struct Exported {
  Ran ran;
  Json files;
  std::map<std::string, Rows> tables;  ///< by file

  [[nodiscard]] std::uint64_t skipped() const {
    std::uint64_t all = 0;
    for (const Json& file : files) all += file.at("skipped").get<std::uint64_t>();
    return all;
  }
};

Exported exported(const std::string& path) {
  const TemporaryFolder folder;
  const std::string tables = folder.path("csv");
  Exported result{run_line({"bag", "export", path, "--csv", "-o", tables, "--output", "json"}), {}, {}};
  if (result.ran.out.empty()) return result;
  result.files = Json::parse(result.ran.out).at("files");
  for (const auto& entry : std::filesystem::directory_iterator(tables)) {
    result.tables[entry.path().filename().string()] = rows_in(entry.path());
  }
  return result;
}

struct Verified {
  Ran ran;
  Json arms;

  [[nodiscard]] std::uint64_t sum(const char* key) const {
    std::uint64_t all = 0;
    for (const Json& arm : arms) all += arm.at(key).get<std::uint64_t>();
    return all;
  }
  [[nodiscard]] std::string reasons() const {
    std::string all;
    for (const Json& arm : arms) {
      for (const auto& [reason, count] : arm.at("not_verifiable").items()) all += reason + "\n";
    }
    return all;
  }
};

Verified verified(const std::string& path) {
  const Ran ran = run_line({"replay", path, "--verify", "-o", "json"});
  return {ran, ran.out.empty() ? Json::array() : Json::parse(ran.out).at("arms")};
}

std::filesystem::path recordings() {
  return std::filesystem::path(HECATON_SOURCE_DIR) / "tests/data/recordings";
}

// tests/older_recordings.py has made each of them with the Hecaton of its version.
TEST(FormerRecordings, StayReadable) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(recordings())) {
    if (entry.path().extension() != ".mcap") continue;
    ++found;
    const std::string path = entry.path().string();
    SCOPED_TRACE(path);
    std::ifstream stream(std::filesystem::path(entry.path()).replace_extension("json"));
    const Json expected = Json::parse(stream);
    const Ran info = run_line({"bag", "info", path, "-o", "json"});
    ASSERT_EQ(info.code, ExitCode::kDone) << info.err;
    EXPECT_EQ(Json::parse(info.out).at("messages"), expected.at("messages"));

    const Exported all = exported(path);
    EXPECT_EQ(all.ran.code, ExitCode::kDone);
    EXPECT_EQ(all.skipped(), 0U) << all.ran.err;
    for (const auto& [topic, rows] : expected.at("rows").items()) {
      EXPECT_EQ(all.tables.at(topic + ".csv").size(), rows.get<std::size_t>()) << topic;
    }
    for (const auto& [arm, q] : expected.at("q").items()) {
      const Rows& states = all.tables.at("ArmState.csv");
      const auto last = std::find_if(states.rbegin(), states.rend(),
                                     [&, &name = arm](const auto& row) { return row.at("arm") == name; });
      ASSERT_NE(last, states.rend());
      for (std::size_t joint = 0; joint < q.size(); ++joint) {
        EXPECT_EQ(last->at("q[" + std::to_string(joint) + "]"), q[joint].get<std::string>()) << arm;
      }
      const Ran explained = run_line({"explain", path, "--arm", arm, "--at", expected.at("at").dump()});
      EXPECT_EQ(explained.code, ExitCode::kDone) << explained.err;
      EXPECT_NE(explained.out.find(arm), std::string::npos) << explained.out;
    }
    // Whether ticks of a former version can be recomputed is not promised; that none is called different is.
    const Verified ticks = verified(path);
    EXPECT_EQ(ticks.sum("ticks"), expected.at("rows").at("PlannerTick").get<std::uint64_t>());
    EXPECT_EQ(ticks.sum("differing") + ticks.sum("differing_memories"), 0U) << ticks.ran.out;
  }
  EXPECT_GT(found, 0);
}

TEST(FormerRecordings, IncludeThisVersion) {
  const auto path = recordings() / ("version-" + std::to_string(msg::SCHEMA_VERSION) + ".mcap");
  EXPECT_TRUE(std::filesystem::exists(path)) << "tests/older_recordings.py makes it";
}

/// Changes the text that describes a type of messages; an empty type: of all types.
struct Edit {
  std::string type;
  std::string from;
  std::string to;
};

const std::string kVersion = "SCHEMA_VERSION = " + std::to_string(msg::SCHEMA_VERSION) + ";";
constexpr std::uint32_t kOlder = msg::SCHEMA_VERSION - 1;
const Edit kOlderVersion{"", kVersion, "SCHEMA_VERSION = " + std::to_string(kOlder) + ";"};

std::string edited(std::string text, const std::string& type, const std::vector<Edit>& edits) {
  for (const Edit& edit : edits) {
    if (!edit.type.empty() && edit.type != type) continue;
    const std::size_t at = text.find(edit.from);
    EXPECT_NE(at, std::string::npos) << edit.from << " is not in the text of " << type;
    if (at != std::string::npos) text.replace(at, edit.from.size(), edit.to);
  }
  return text;
}

/// Copies the messages of the cell as a program would have written them whose idl/ has these edits. `converts`: false:
/// the texts alone are changed, and the version of each message.
void make_older(const std::string& from, const std::string& to, const std::vector<Edit>& edits, bool converts = true) {
  using namespace recorder;
  struct Channel {
    std::uint16_t number = 0;
    std::unique_ptr<IdlTypes> today;
    std::unique_ptr<IdlTypes> older;
    std::unique_ptr<MessageConversion> conversion;
  };
  McapWriter writer(to, "hecaton");
  std::map<std::shared_ptr<const McapChannel>, Channel> channels;
  McapVisitor visitor;
  visitor.attachment = [&](const McapAttachment& file) {
    writer.attach(file.name, file.media_type, 0, {reinterpret_cast<const char*>(file.data.data()), file.data.size()});
  };
  visitor.message = [&](const McapMessage& message) {
    const bool described = message.channel->schema != nullptr;
    const auto [place, first] = channels.try_emplace(message.channel);
    Channel& channel = place->second;
    if (first) {
      std::uint16_t schema = 0;
      if (described) {
        const McapSchema& known = *message.channel->schema;
        const std::string type = known.name.substr(known.name.rfind(':') + 1);
        const std::string text = edited(known.data, type, edits);
        schema = writer.add_schema(known.name, known.encoding, text);
        if (converts) {
          channel.today = std::make_unique<IdlTypes>(known.data);
          channel.older = std::make_unique<IdlTypes>(text);
          channel.conversion = std::make_unique<MessageConversion>(
              *channel.today->structure(type), *channel.older->structure(type), std::size_t{1} << 24U);
        }
      }
      channel.number =
          writer.add_channel(schema, message.channel->topic, message.channel->encoding, message.channel->metadata);
    }
    Bytes bytes(message.data.begin(), message.data.end());
    if (described && !converts) bytes[4] = static_cast<std::uint8_t>(kOlder);
    const ByteSpan data = channel.conversion ? channel.conversion->convert(message.data) : ByteSpan(bytes);
    writer.write({channel.number, message.sequence, message.log_time, message.publish_time, data});
  };
  EXPECT_TRUE(read_mcap(from, visitor).whole());
  writer.close();
}

class OlderRecording : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    path_ = folder_->path("today.mcap");
    const Ran ran = run_line({"simulate", std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml", "--tasks",
                              "3", "--seed", "3", "--record", path_, "-o", "json"});
    ASSERT_TRUE(std::filesystem::exists(path_)) << ran.err;
    today_ = exported(path_);
    ASSERT_EQ(today_.ran.code, ExitCode::kDone);
    ASSERT_FALSE(today_.tables.empty());
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string older(const std::vector<Edit>& edits, bool converts = true) {
    std::string path = folder_->path("older.mcap");
    std::filesystem::remove(path);
    make_older(path_, path, edits, converts);
    return path;
  }

  static std::optional<TemporaryFolder> folder_;
  static std::string path_;
  static Exported today_;
};
std::optional<TemporaryFolder> OlderRecording::folder_;
std::string OlderRecording::path_;
Exported OlderRecording::today_;

/// A field was added since, one removed, some moved, the key among them, and the labels of an enumeration have other
/// numbers.
const std::vector<Edit> kChanges{kOlderVersion,
                                 {"ArmState", "  double tracking_delay; ", "  // double tracking_delay; "},
                                 {"ArmState", "  @key string arm; ", "  double removed;  // @key string arm; "},
                                 {"ArmState", "  Cause cause; ", "  @key string arm; Cause cause; "},
                                 {"ArmState", "  CAUSE_EMERGENCY_STOP, ", "  // CAUSE_EMERGENCY_STOP, "},
                                 {"GoalStatus", "  CAUSE_EMERGENCY_STOP, ", "  // CAUSE_EMERGENCY_STOP, "}};

TEST_F(OlderRecording, HasTheValuesOfToday) {
  const std::string path = older(kChanges);
  const Exported all = exported(path);
  EXPECT_EQ(all.ran.code, ExitCode::kDone);
  EXPECT_EQ(all.skipped(), 0U);
  for (const char* note :
       {"messages of version ", "fields that they lack have their defaults: ArmState.tracking_delay\n",
        "fields that this program does not know are left out: ArmState.removed\n"}) {
    EXPECT_NE(all.ran.err.find(note), std::string::npos) << all.ran.err;
  }
  ASSERT_EQ(all.tables.size(), today_.tables.size());
  for (const auto& [file, rows] : today_.tables) {
    Rows expected = rows;
    if (file == "ArmState.csv") {
      for (auto& row : expected) row.at("tracking_delay") = "0";
    }
    EXPECT_TRUE(all.tables.at(file) == expected) << file;
  }
  std::set<std::string> causes;
  for (const auto& row : today_.tables.at("ArmState.csv")) causes.insert(row.at("cause.kind"));
  EXPECT_GT(causes.size(), 1U) << "else the labels prove nothing; message_conversion_test moves all of them";
}

TEST_F(OlderRecording, IsExplainedAsTodays) {
  const std::string path = older(kChanges);
  for (const char* at : {"0.5", "1.2"}) {
    for (const char* arm : {"north", "west", "east"}) {
      const Ran before = run_line({"explain", path_, "--arm", arm, "--at", at});
      const Ran after = run_line({"explain", path, "--arm", arm, "--at", at});
      EXPECT_EQ(after.code, ExitCode::kDone) << after.err;
      EXPECT_EQ(after.out, before.out);
    }
  }
}

TEST_F(OlderRecording, IsRecomputedIfItsTicksHaveAllInputs) {
  const Verified before = verified(path_);
  const Verified after = verified(older(kChanges));
  EXPECT_EQ(after.ran.code, ExitCode::kDone);
  EXPECT_EQ(after.arms, before.arms);
  EXPECT_EQ(after.sum("equal"), after.sum("ticks"));
  EXPECT_GT(after.sum("ticks"), 0U);
  EXPECT_NE(after.ran.err.find("messages of version " + std::to_string(kOlder)), std::string::npos) << after.ran.err;
}

TEST_F(OlderRecording, IsNotRecomputedIfItsTicksLackAnInput) {
  const Verified before = verified(path_);
  const std::string version = "version " + std::to_string(kOlder);
  const std::vector<std::pair<Edit, std::string>> cases{
      {{"PlannerTick", "  boolean foreign; ", "  // boolean foreign; "},
       version + " lacks TickArm.foreign of a tick; verify"},
      {{"PlannerTick", "  boolean foreign; ", "  boolean foreign; boolean other; "},
       version + " has TickArm.other in addition of a tick; verify"}};
  for (const auto& [edit, reason] : cases) {
    const Verified after = verified(older({kOlderVersion, edit}));
    EXPECT_EQ(after.ran.code, ExitCode::kNegative);
    EXPECT_EQ(after.sum("ticks"), before.sum("ticks"));
    EXPECT_EQ(after.sum("recomputed") + after.sum("differing"), 0U);
    EXPECT_NE(after.reasons().find(reason), std::string::npos) << after.reasons();
  }
}

TEST_F(OlderRecording, LeavesOutATopicThatCannotBeConverted) {
  const std::string path = older({kOlderVersion, {"Heartbeat", "  NodeState state; ", "  double state; "}}, false);
  const std::string reason =
      "hecaton/Heartbeat: field state is double in the recording, and enumeration NodeState in this program, which is "
      "no wider form of it; use the Hecaton that recorded it";
  const Exported all = exported(path);
  const bool has_heartbeats = today_.tables.count("Heartbeat.csv") > 0;
  ASSERT_TRUE(has_heartbeats);
  EXPECT_EQ(all.skipped(), today_.tables.at("Heartbeat.csv").size());
  EXPECT_NE(all.ran.err.find("messages of hecaton/Heartbeat have no row: " + reason), std::string::npos) << all.ran.err;
  EXPECT_EQ(all.tables.at("ArmState.csv"), today_.tables.at("ArmState.csv"));
  const Ran explained = run_line({"explain", path, "--arm", "north", "--at", "0.5"});
  EXPECT_EQ(explained.code, ExitCode::kDone);
  EXPECT_NE(explained.err.find("messages are left out: " + reason), std::string::npos) << explained.err;
}

TEST_F(OlderRecording, IsRefusedIfNoMessageCanBeConverted) {
  const std::string path = older({kOlderVersion, {"", "module hecaton {", "modul hecaton {"}}, false);
  const Ran explained = run_line({"explain", path, "--arm", "north", "--at", "0.5"});
  EXPECT_EQ(explained.code, ExitCode::kBadInput);
  EXPECT_NE(explained.err.find(": its messages have version " + std::to_string(kOlder) +
                               ", and their structure in the file cannot be read: line "),
            std::string::npos)
      << explained.err;
  EXPECT_NE(
      explained.err.find(
          ": a structure, enumeration, constant or typedef is expected, and 'modul' stands there; use the Hecaton that "
          "recorded it"),
      std::string::npos)
      << explained.err;
  EXPECT_EQ(run_line({"bag", "info", path}).code, ExitCode::kDone);
  const Verified ticks = verified(path);
  EXPECT_EQ(ticks.ran.code, ExitCode::kNegative);
  EXPECT_NE(ticks.ran.err.find("are not verified: hecaton/PlannerTick: its messages have version"), std::string::npos)
      << ticks.ran.err;
}

}  // namespace
}  // namespace hecaton::services::cli
