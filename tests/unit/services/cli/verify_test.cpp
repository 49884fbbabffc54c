/// hecaton simulate --record FILE.mcap, then hecaton replay FILE --verify: ticks are recomputed bit by bit, and each
/// bit that was changed in the file is found.

#include <cmath>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>

#include <gtest/gtest.h>
#include <idl/planner.h>

#include "services/bus/recorded_sample.hpp"
#include "services/command_line/document.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/mcap_writer.hpp"
#include "services/tick_log/program.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

using test::TemporaryFolder;

std::string verified_cell(const std::string& name) {
  return std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + name + ".yaml";
}

/// Simulates tasks of a cell and records all ticks.
Json simulate_to(const std::string& path, const std::string& cell, const std::vector<std::string>& more) {
  std::vector<std::string> words{"simulate", verified_cell(cell), "--record", path, "-o", "json"};
  words.insert(words.end(), more.begin(), more.end());
  const Ran ran = run_line(words);
  EXPECT_TRUE(std::filesystem::exists(path)) << ran.err;
  return Json::parse(ran.out);
}

struct Verified {
  ExitCode code{};
  Json arms;
  Json findings;
  std::string err;

  [[nodiscard]] std::uint64_t sum(const char* key) const {
    std::uint64_t all = 0;
    for (const Json& arm : arms) all += arm.at(key).get<std::uint64_t>();
    return all;
  }
};

Verified verify(const std::string& path, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"replay", path, "--verify", "-o", "json"};
  words.insert(words.end(), more.begin(), more.end());
  const Ran ran = run_line(words);
  if (ran.out.empty()) return {ran.code, Json::array(), Json::array(), ran.err};
  const Json json = Json::parse(ran.out);
  return {ran.code, json.at("arms"), json.at("findings"), ran.err};
}

/// Every tick is equal, and none is left out. Returns how many memories of planners were compared.
std::uint64_t expect_all_equal(const std::string& path, std::uint64_t ticks) {
  const Verified verified = verify(path);
  EXPECT_EQ(verified.code, ExitCode::kDone) << verified.arms.dump(2) << verified.err;
  EXPECT_EQ(verified.sum("ticks"), ticks);
  EXPECT_EQ(verified.sum("equal"), ticks) << verified.arms.dump(2);
  EXPECT_EQ(verified.sum("differing") + verified.sum("differing_memories") + verified.sum("missing"), 0U);
  for (const Json& arm : verified.arms) EXPECT_TRUE(arm.at("not_verifiable").empty()) << arm;
  return verified.sum("memories");
}

/// The ticks that stand in a copy in place of one.
using Replacement = std::function<std::vector<msg::PlannerTick>(const msg::PlannerTick&)>;

/// Copies the messages of the cell. `keep_writers`: else the channels have no metadata.
void rewrite(const std::string& from, const std::string& to, const Replacement& replace, bool keep_writers = true) {
  using namespace recorder;
  McapWriter writer(to, "hecaton");
  std::map<const McapChannel*, std::uint16_t> channels;
  McapVisitor visitor;
  visitor.attachment = [&](const McapAttachment& file) {
    writer.attach(file.name, file.media_type, 0, {reinterpret_cast<const char*>(file.data.data()), file.data.size()});
  };
  visitor.message = [&](const McapMessage& message) {
    if (!message.channel->schema) return;
    const auto [channel, first] = channels.try_emplace(message.channel.get());
    if (first) {
      const McapSchema& schema = *message.channel->schema;
      channel->second =
          writer.add_channel(writer.add_schema(schema.name, schema.encoding, schema.data), message.channel->topic,
                             "cdr", keep_writers ? message.channel->metadata : recorder::StringMap());
    }
    const auto copy = [&](recorder::ByteSpan bytes) {
      writer.write({channel->second, message.sequence, message.log_time, message.publish_time, bytes});
    };
    if (message.channel->topic != bus::Topic<msg::PlannerTick>::kInfo.name) return copy(message.data);
    auto tick = bus::decode_recorded<msg::PlannerTick>(message.data);
    ASSERT_TRUE(tick.value);
    for (const msg::PlannerTick& written : replace(*tick.value)) {
      const std::vector<std::uint8_t> bytes = bus::encode_recorded(written);
      ASSERT_FALSE(bytes.empty());
      copy(bytes);
    }
  };
  EXPECT_TRUE(read_mcap(from, visitor).whole());
  writer.close();
}

/// 9 tasks in a narrow cell, on old and lost states: rollouts, boundary following, routes.
class DenseRecording : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_.emplace();
    path_ = folder_->path("dense.mcap");
    report_ = simulate_to(path_, "three_puma_dense",
                          {"--tasks", "9", "--seed", "7", "--age", "20ms", "--jitter", "10ms", "--loss", "0.05"});
  }
  static void TearDownTestSuite() { folder_.reset(); }

  /// `change` may change a tick; false: it leaves the tick out.
  [[nodiscard]] static std::string changed(const std::function<bool(msg::PlannerTick&)>& change) {
    std::string path = folder_->path("changed.mcap");
    std::filesystem::remove(path);
    rewrite(path_, path, [&](msg::PlannerTick tick) {
      return change(tick) ? std::vector{std::move(tick)} : std::vector<msg::PlannerTick>();
    });
    return path;
  }

  static std::optional<TemporaryFolder> folder_;
  static std::string path_;
  static Json report_;
};
std::optional<TemporaryFolder> DenseRecording::folder_;
std::string DenseRecording::path_;
Json DenseRecording::report_;

TEST_F(DenseRecording, IsRecomputedToTheLastBit) {
  EXPECT_GT(report_["rollouts"]["answers"].get<int>(), 0);
  EXPECT_GT(report_["subspaces_drawn"].get<int>(), 0);
  static_cast<void>(expect_all_equal(path_, report_["ticks"].get<std::uint64_t>()));
}

// In a long recording writers share a channel. While one planner takes over from another, both send.
TEST_F(DenseRecording, TellsTwoPlannersOfAnArmInOneChannelApart) {
  constexpr std::size_t kBehind = 70;  // ticks
  std::map<std::string, std::deque<msg::PlannerTick>> waiting;
  const std::string path = folder_->path("shared.mcap");
  rewrite(
      path_, path,
      [&](const msg::PlannerTick& tick) {
        std::vector<msg::PlannerTick> both{tick};
        auto& others = waiting[tick.arm()];
        others.push_back(tick);
        others.back().node(tick.node() + "@standby");
        if (others.size() > kBehind) {
          both.push_back(std::move(others.front()));
          others.pop_front();
        }
        return both;
      },
      false);
  const Verified verified = verify(path);
  EXPECT_EQ(verified.code, ExitCode::kDone) << verified.arms.dump(2) << verified.err;
  EXPECT_EQ(verified.sum("missing"), 0U);
  EXPECT_EQ(verified.sum("equal"), verified.sum("ticks")) << verified.arms.dump(2);
  EXPECT_EQ(verified.sum("ticks"), 2 * report_["ticks"].get<std::uint64_t>() - waiting.size() * kBehind);
}

TEST_F(DenseRecording, FindsOneBitOfASetPoint) {
  constexpr std::uint64_t kTick = 40;
  bool done = false;
  const Verified verified = verify(changed([&](msg::PlannerTick& tick) {
    if (!done && tick.arm() == "west" && tick.sequence_number() == kTick) {
      tick.qd()[2] = std::nextafter(tick.qd()[2], 1.0);
      done = true;
    }
    return true;
  }));
  ASSERT_TRUE(done);
  EXPECT_EQ(verified.code, ExitCode::kNegative);
  EXPECT_EQ(verified.sum("differing"), 1U);
  for (const Json& arm : verified.arms) {
    if (arm.at("arm") != "west") continue;
    const Json& first = arm.at("first_difference");
    EXPECT_EQ(first.at("tick"), kTick);
    EXPECT_EQ(first.at("velocity"), true);
    EXPECT_NE(first.at("recorded"), first.at("recomputed"));
    EXPECT_NEAR(first.at("time_s").get<double>(), 0.39, 1e-9);
  }
}

TEST_F(DenseRecording, FindsAnInputThatWasChanged) {
  bool done = false;
  const Verified verified = verify(changed([&](msg::PlannerTick& tick) {
    if (!done && tick.arm() == "north" && tick.changes_goal()) {
      tick.q_goal()[0] += 1e-3;
      done = true;
    }
    return true;
  }));
  ASSERT_TRUE(done);
  EXPECT_EQ(verified.code, ExitCode::kNegative);
  EXPECT_GT(verified.sum("differing"), 0U);
}

TEST_F(DenseRecording, CountsTicksAfterAGapUntilTheNextSnapshot) {
  std::uint64_t left_out = 0;
  const Verified verified = verify(changed([&](msg::PlannerTick& tick) {
    const bool keeps = tick.arm() != "east" || tick.sequence_number() != 100 || left_out > 0;
    if (!keeps) ++left_out;
    return keeps;
  }));
  ASSERT_EQ(left_out, 1U);
  EXPECT_EQ(verified.code, ExitCode::kDone) << "nothing that was compared differs";
  EXPECT_EQ(verified.sum("missing"), 1U);
  std::uint64_t unverified = 0;
  for (const Json& arm : verified.arms) {
    for (const auto& [reason, count] : arm.at("not_verifiable").items()) {
      EXPECT_NE(reason.find("missing"), std::string::npos);
      EXPECT_EQ(arm.at("arm"), "east");
      unverified += count.get<std::uint64_t>();
    }
  }
  EXPECT_GT(unverified, 0U);
  EXPECT_LE(unverified, 500U) << "a snapshot each 5 s";
  EXPECT_EQ(verified.sum("recomputed") + unverified + 1, report_["ticks"].get<std::uint64_t>());
}

TEST_F(DenseRecording, ClaimsNothingWithoutASnapshot) {
  const Verified verified = verify(changed([](msg::PlannerTick& tick) { return !tick.snapshot(); }));
  EXPECT_EQ(verified.code, ExitCode::kNegative);
  EXPECT_EQ(verified.sum("recomputed"), 0U);
  EXPECT_GT(verified.sum("ticks"), 0U);
}

TEST_F(DenseRecording, TellsAnotherProgramAndABrokenMemory) {
  const std::string same_layout = "0.0.1 memory " + std::to_string(kPlannerMemory) + " abacus";
  const Verified other = verify(changed([&](msg::PlannerTick& tick) {
    if (tick.snapshot()) tick.program(same_layout);
    return true;
  }));
  EXPECT_EQ(other.code, ExitCode::kDone);
  EXPECT_NE(other.err.find("recorded by program " + same_layout), std::string::npos) << other.err;
  ASSERT_EQ(other.findings.size(), 1U) << other.findings;
  EXPECT_EQ(other.findings[0].at("severity"), "note");
  EXPECT_NE(other.err.find(other.findings[0].at("sentence").get<std::string>()), std::string::npos) << other.err;
  // From before programs named their layout. A planner that has just been built would have no memory to load.
  const Verified old = verify(changed([](msg::PlannerTick& tick) {
    if (tick.snapshot()) {
      tick.program("0.0.1 abacus");
      tick.memory(std::vector<std::uint32_t>(100));
    }
    return true;
  }));
  EXPECT_EQ(old.sum("differing"), 0U);
  std::string reasons;
  for (const Json& arm : old.arms) {
    for (const auto& [reason, count] : arm.at("not_verifiable").items()) reasons += reason + "\n";
  }
  EXPECT_NE(reasons.find("has layout 1, of program 0.0.1 abacus, and this program, " + program_text()),
            std::string::npos)
      << reasons;
  const Verified broken = verify(changed([](msg::PlannerTick& tick) {
    if (tick.snapshot()) tick.memory(std::vector<std::uint32_t>(100, 0xFFFFFFFFU));
    return true;
  }));
  EXPECT_EQ(broken.code, ExitCode::kNegative);
  EXPECT_EQ(broken.sum("recomputed"), 0U);
}

TEST_F(DenseRecording, VerifiesNamedArmsAndRefusesOthers) {
  const Verified west = verify(path_, {"--arm", "west"});
  EXPECT_EQ(west.code, ExitCode::kDone);
  ASSERT_EQ(west.arms.size(), 1U);
  EXPECT_EQ(west.arms[0].at("arm"), "west");
  EXPECT_EQ(run_line({"replay", path_, "--verify", "--arm", "south"}).code, ExitCode::kBadInput);
  EXPECT_EQ(run_line({"replay", path_, "--arm", "west"}).code, ExitCode::kUsage);
}

TEST(Verify, RecomputesAHundredThousandTicks) {
  const TemporaryFolder folder;
  const std::string path = folder.path("long.mcap");
  const Json report = simulate_to(
      path, "three_puma_dense",
      {"--tasks", "500", "--seed", "3", "--age", "20ms", "--jitter", "10ms", "--loss", "0.05", "--threads", "2"});
  EXPECT_GT(report["ticks"].get<int>(), 100'000);
  EXPECT_GT(expect_all_equal(path, report["ticks"].get<std::uint64_t>()), 0U);
}

// Each method keeps a memory of its own kind; carried objects, coupled plans and sensors are inputs.
TEST(Verify, RecomputesEachMethodAndKindOfInput) {
  const TemporaryFolder folder;
  struct Case {
    const char* cell;
    std::vector<std::string> options;
  };
  const std::vector<Case> cases{
      {"corridor_three", {"--tasks", "3", "--seed", "2"}},
      {"two_puma_carry", {"--tasks", "4", "--seed", "1", "--no-routes"}},
      {"puma_potential", {"--tasks", "3", "--seed", "1"}},
      {"scorbot_2a", {"--tasks", "4", "--seed", "1"}},
      {"three_puma", {"--tasks", "6", "--method", "local", "--speed", "0.7", "--rollouts", "2"}},
      {"puma_sensed", {"--tasks", "1", "--seed", "1"}}};
  int number = 0;
  for (const Case& one : cases) {
    SCOPED_TRACE(one.cell);
    const std::string path = folder.path(std::to_string(++number) + ".mcap");
    const Json report = simulate_to(path, one.cell, one.options);
    const std::uint64_t memories = expect_all_equal(path, report["ticks"].get<std::uint64_t>());
    // Of planners that ran longer than the time between two snapshots.
    EXPECT_TRUE(memories > 0 || std::string(one.cell) != "corridor_three");
  }
}

}  // namespace
}  // namespace hecaton::services::cli
