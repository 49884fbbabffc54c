/// hecaton simulate --record FILE.mcap: the recording has the topics of a live cell, and its readers work on it.

#include <algorithm>
#include <bit>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/planner.h>
#include <idl/world.h>

#include "services/bus/recorded_sample.hpp"
#include "services/command_line/document.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/mcap_writer.hpp"
#include "services/runtime/cause.hpp"
#include "tests/cell/cli/process.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

using recorder::McapMessage;
using test::TemporaryFolder;

std::string cell_file(const std::string& name) {
  return std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + name + ".yaml";
}

std::string content_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Ran simulate(const std::string& cell, const std::vector<std::string>& more) {
  std::vector<std::string> words{"simulate", cell_file(cell), "-o", "json"};
  words.insert(words.end(), more.begin(), more.end());
  return run_line(words);
}

template <class T>
struct Timed {
  double at = 0.0;  ///< [s]
  T value;
};

/// The messages of one type, in the order of the file.
template <class T>
std::vector<Timed<T>> messages_in(const std::string& path) {
  std::vector<Timed<T>> found;
  recorder::McapVisitor visitor;
  visitor.message = [&](const McapMessage& message) {
    if (message.channel->topic != bus::Topic<T>::kInfo.name) return;
    auto decoded = bus::decode_recorded<T>(message.data);
    ASSERT_TRUE(decoded.value);
    found.push_back({static_cast<double>(message.log_time) * 1e-9, std::move(*decoded.value)});
  };
  EXPECT_TRUE(recorder::read_mcap(path, visitor).whole());
  return found;
}

/// Four episodes of three arms.
class SimulatedRecording : public testing::Test {
 protected:
  static constexpr int kEpisodes = 4;
  static constexpr int kArms = 3;

  static void SetUpTestSuite() {
    folder_.emplace();
    path_ = folder_->path("run.mcap");
    report_ = simulate("three_puma", {"--tasks", "12", "--seed", "5", "--record", path_}).out;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  [[nodiscard]] static std::string explain(const std::string& arm, double at) {
    const Ran ran = run_line({"explain", path_, "--arm", arm, "--at", std::to_string(at)});
    EXPECT_EQ(ran.code, ExitCode::kDone) << ran.err;
    return ran.out;
  }

  static std::optional<TemporaryFolder> folder_;
  static std::string path_;
  static std::string report_;
};
std::optional<TemporaryFolder> SimulatedRecording::folder_;
std::string SimulatedRecording::path_;
std::string SimulatedRecording::report_;

TEST_F(SimulatedRecording, ChangesNoReport) {
  EXPECT_EQ(report_, simulate("three_puma", {"--tasks", "12", "--seed", "5"}).out);
}

TEST_F(SimulatedRecording, DoesNotDependOnTheNumberOfThreads) {
  const std::string path = folder_->path("threads.mcap");
  static_cast<void>(simulate("three_puma", {"--tasks", "12", "--seed", "5", "--threads", "3", "--record", path}));
  EXPECT_EQ(content_of(path), content_of(path_));
}

TEST_F(SimulatedRecording, HasTheTopicsOfALiveCell) {
  const Ran ran = run_line({"bag", "info", path_, "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json info = Json::parse(ran.out);
  std::set<std::string> topics;
  for (const Json& topic : info.at("topics")) topics.insert(topic.at("topic"));
  for (const char* topic :
       {"ArmState", "ArmCommand", "ObstacleShapes", "ObstacleStates", "ContactReport", "Goal", "GoalStatus",
        "CoupledPlan", "CoupledPlanProgress", "Heartbeat", "CellMode", "PlannerTick", "PlannedMotion"}) {
    EXPECT_TRUE(topics.contains(std::string("hecaton/") + topic)) << topic;
  }
  EXPECT_EQ(info.at("cell"), "three_puma");
  EXPECT_EQ(info.at("simulated"), true);
  EXPECT_EQ(info.at("start"), nullptr);
  EXPECT_NEAR(info.at("duration_s").get<double>(), Json::parse(report_).at("duration_s").get<double>(),
              0.05 * kEpisodes);
}

// What a planner has read as its own state is what its driver has published then.
TEST_F(SimulatedRecording, HasTheStateOfEachArmInEachPeriod) {
  std::map<std::pair<std::string, std::int64_t>, msg::ArmState> states;
  for (const auto& [at, state] : messages_in<msg::ArmState>(path_)) {
    states[{state.arm(), std::llround(at * 1e9)}] = state;
  }
  std::size_t ticks = 0;
  for (const auto& [at, tick] : messages_in<msg::PlannerTick>(path_)) {
    const auto state = states.find({tick.arm(), std::llround(at * 1e9)});
    ASSERT_NE(state, states.end()) << tick.arm() << " at " << at;
    ASSERT_EQ(tick.own().q(), state->second.q());
    ASSERT_EQ(tick.own().qd(), state->second.qd());
    ++ticks;
  }
  EXPECT_EQ(states.size(), ticks + kEpisodes * kArms) << "and the last state of each episode";
}

TEST_F(SimulatedRecording, IsExportedAsABagOfRos2) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  HECATON_NEED_FILES({page + "/node_modules/@mcap/core", node});
  const std::string bag = folder_->path("bag");
  const Ran exported = run_line({"bag", "export", path_, "--ros2", "-o", bag, "--output", "json"});
  ASSERT_EQ(exported.code, ExitCode::kDone) << exported.err;
  std::map<std::string, int> counts;
  const Json report = Json::parse(exported.out);
  for (const Json& finding : report.at("findings")) {
    EXPECT_NE(exported.err.find(finding.at("sentence").get<std::string>()), std::string::npos) << exported.err;
  }
  for (const Json& topic : report.at("topics")) counts[topic.at("topic")] = topic.at("messages");
  for (const char* once : {"/robot_description", "/tf_static", "/north/robot_description"}) {
    EXPECT_EQ(counts.at(once), 1) << once;
  }

  // Libraries of others decode each message, and find the positions of the newest states.
  test::Process other({node, page + "/test/bag.mjs", bag + "/bag_0.mcap", "/joint_states", "header", "position"});
  ASSERT_EQ(other.wait(), 0) << other.err();
  std::istringstream lines(other.out());
  std::string line;
  std::getline(lines, line);
  const Json contents = Json::parse(line);
  for (const auto& [topic, count] : counts) {
    EXPECT_EQ(contents.at("topics").value(topic, 0), count) << topic;
  }
  std::map<std::string, std::map<std::int64_t, std::vector<double>>> states;  // by arm and time [ns]
  for (const auto& [at, state] : messages_in<msg::ArmState>(path_)) {
    states[state.arm()][std::llround(at * 1e9)] = state.q();
  }
  int compared = 0;
  while (std::getline(lines, line)) {
    const Json message = Json::parse(line);
    const Json& stamp = message.at("header").at("stamp");
    const auto at = stamp.at("sec").get<std::int64_t>() * 1'000'000'000 +
                    (stamp.contains("nanosec") ? stamp.at("nanosec") : stamp.at("nsec")).get<std::int64_t>();
    std::vector<double> expected;
    for (const char* arm : {"north", "west", "east"}) {
      const auto after = states.at(arm).upper_bound(at);
      ASSERT_NE(after, states.at(arm).begin()) << line;
      const std::vector<double>& q = std::prev(after)->second;
      expected.insert(expected.end(), q.begin(), q.end());
    }
    ASSERT_EQ(message.at("position").get<std::vector<double>>(), expected) << at;
    ++compared;
  }
  EXPECT_EQ(compared, counts.at("/joint_states"));
  EXPECT_GT(compared, 100);

  const std::string before = content_of(bag + "/metadata.yaml");
  EXPECT_NE(before.find("storage_identifier: mcap"), std::string::npos);
  const Ran again = run_line({"bag", "export", path_, "--ros2", "-o", bag});
  EXPECT_EQ(again.code, ExitCode::kBadInput);
  EXPECT_EQ(again.err, "hecaton: " + bag + " exists already: name a folder that does not exist\n");
  EXPECT_EQ(content_of(bag + "/metadata.yaml"), before);
  EXPECT_EQ(run_line({"bag", "export", path_, "--ros2", "--csv", "-o", bag}).code, ExitCode::kUsage);
}

TEST_F(SimulatedRecording, WithoutItsEndIsExportedWithThatFinding) {
  const std::string cut = folder_->path("cut.mcap");
  std::filesystem::copy_file(path_, cut);
  std::filesystem::resize_file(cut, std::filesystem::file_size(cut) - 20);  // of its footer
  const Ran exported = run_line({"bag", "export", cut, "--ros2", "-o", folder_->path("cut_bag"), "--output", "json"});
  EXPECT_EQ(exported.code, ExitCode::kNegative) << exported.err;
  const Json findings = Json::parse(exported.out).at("findings");
  EXPECT_TRUE(std::any_of(findings.begin(), findings.end(), [](const Json& finding) {
    return finding.at("sentence").get<std::string>().find("has no end") != std::string::npos;
  })) << findings;
}

TEST_F(SimulatedRecording, TellsTheGoalsAsTheReport) {
  std::map<std::string, std::map<std::string, msg::GoalState>> last;  // by goal and arm
  double before = 0.0;
  for (const auto& [at, status] : messages_in<msg::GoalStatus>(path_)) {
    EXPECT_GE(at, before);
    before = at;
    last[status.goal()][status.arm()] = status.state();
  }
  ASSERT_EQ(last.size(), kEpisodes);
  int reached = 0;
  for (const auto& [goal, arms] : last) {
    EXPECT_EQ(arms.size(), kArms) << goal;
    for (const auto& [arm, state] : arms) {
      EXPECT_TRUE(is_final(state)) << goal << " " << arm;
      if (state == msg::GoalState::GOAL_REACHED) ++reached;
    }
  }
  EXPECT_EQ(reached, Json::parse(report_).at("reached").get<int>());
}

// Time goes on from episode to episode, and each begins with a goal of its number.
TEST_F(SimulatedRecording, PutsEpisodesOneBehindTheOther) {
  std::map<std::string, double> begins;
  for (const auto& [at, goal] : messages_in<msg::Goal>(path_)) begins.try_emplace(goal.goal(), at);
  ASSERT_EQ(begins.size(), kEpisodes);
  EXPECT_EQ(begins.at("episode-1"), 0.0);
  for (int i = 2; i <= kEpisodes; ++i) {
    const double begin = begins.at("episode-" + std::to_string(i));
    EXPECT_GT(begin, begins.at("episode-" + std::to_string(i - 1)) + 0.5);
    EXPECT_NE(explain("west", begin + 0.2).find("Goal episode-" + std::to_string(i) + " is active"), std::string::npos);
    EXPECT_NE(explain("west", begin - 0.011).find("Goal episode-" + std::to_string(i - 1) + " is "), std::string::npos);
  }
}

TEST_F(SimulatedRecording, IsExplained) {
  const std::string text = explain("north", 1.0);
  EXPECT_NE(text.find("The order for north is run"), std::string::npos) << text;
  EXPECT_NE(text.find("planner/north is running"), std::string::npos) << text;
  EXPECT_EQ(text.find("never"), std::string::npos) << text;
}

// The same planner code writes the statuses of a live cell.
TEST_F(SimulatedRecording, NamesWhatBindsAnArmThatIsHeldBack) {
  for (const auto& [at, status] : messages_in<msg::GoalStatus>(path_)) {
    if (status.blocked_duration() < 0.3 || !status.has_binding() || is_final(status.state())) continue;
    const std::string text = explain(status.arm(), at);
    EXPECT_NE(text.find(status.binding_own() + " and " + status.binding_other() + " bound its motion"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("last moved freely to its goal"), std::string::npos) << text;
    return;
  }
  FAIL() << "no arm was obstructed: choose another seed";
}

// Old states make a planner wait, and it says so.
TEST(SimulatedRecordings, TellStaleInputs) {
  const TemporaryFolder folder;
  const std::string path = folder.path("stale.mcap");
  static_cast<void>(simulate("three_puma", {"--tasks", "3", "--age", "400ms", "--record", path}));
  const Ran ran = run_line({"explain", path, "--arm", "west", "--at", "2"});
  EXPECT_NE(ran.out.find("[arm_state_old, "), std::string::npos) << ran.out << ran.err;
  EXPECT_NE(ran.out.find("planner/west is degraded"), std::string::npos) << ran.out;
}

// Each episode of such a cell has obstacles of its own, under the same names.
TEST(SimulatedRecordings, ReplaceTheObstaclesOfTheEpisodeBefore) {
  const TemporaryFolder folder;
  const std::string path = folder.path("clutter.mcap");
  static_cast<void>(simulate("planar_2r", {"--tasks", "3", "--record", path}));
  std::map<std::string, std::set<std::vector<std::uint8_t>>> shapes;
  recorder::McapVisitor visitor;
  visitor.message = [&](const McapMessage& message) {
    if (message.channel->topic == bus::Topic<msg::ObstacleShapes>::kInfo.name) {
      shapes[bus::decode_recorded<msg::ObstacleShapes>(message.data).value->name()].emplace(message.data.begin(),
                                                                                            message.data.end());
    } else if (message.channel->topic == bus::Topic<msg::ObstacleStates>::kInfo.name) {
      const auto states = bus::decode_recorded<msg::ObstacleStates>(message.data);
      ASSERT_EQ(states.value->states().size(), shapes.size());
      for (const msg::ObstacleState& state : states.value->states()) EXPECT_TRUE(shapes.contains(state.name()));
    }
  };
  EXPECT_TRUE(recorder::read_mcap(path, visitor).whole());
  EXPECT_FALSE(shapes.empty());
  for (const auto& [name, different] : shapes) EXPECT_EQ(different.size(), 3U) << name;
}

TEST(BagInfo, PrintsWhenTheRecordingBegins) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  recorder::McapWriter writer(path, "hecaton");
  const std::uint16_t channel = writer.add_channel(0, "topic", "json", {});
  const std::vector<std::uint8_t> data{'1'};
  for (const std::uint64_t time : {1795874720'123'456'789U, 1795874722'123'456'789U}) {
    writer.write({.channel = channel, .log_time = time, .publish_time = time, .data = data});
  }
  writer.close();
  const Json info = Json::parse(run_line({"bag", "info", path, "-o", "json"}).out);
  EXPECT_EQ(info.at("start"), "2026-11-28T14:05:20.123Z");
  EXPECT_EQ(info.at("simulated"), false);
  EXPECT_NE(run_line({"bag", "info", path}).out.find(" s from 2026-11-28T14:05:20.123Z, 2 messages"),
            std::string::npos);
}

}  // namespace
}  // namespace hecaton::services::cli
