/// The state of a recorded cell at any time: recordings with known messages, whole, split, cut and damaged.

#include "services/replay/replay.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/replay/explain.hpp"
#include "services/runtime/cause.hpp"
#include "services/view/state_json.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/replay/tape.hpp"

namespace hecaton::services::replay {
namespace {

using namespace std::chrono_literals;
using test::TemporaryFolder;
using Time = bus::Clock::time_point;
using view::Json;

msg::CellMode cell_mode(msg::Mode mode) {
  msg::CellMode message;
  message.term(1);
  message.node("supervisor");
  message.mode(mode);
  if (mode != msg::Mode::MODE_RUN) message.cause(make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, "", "a person"));
  return message;
}

msg::GoalStatus goal_status(const std::string& id, msg::GoalState state, std::int64_t stamp) {
  msg::GoalStatus status;
  status.arm("north");
  status.goal(id);
  status.term(1);
  status.stamp_ns(stamp);
  status.node("planner/north");
  status.state(state);
  return status;
}

msg::Fault fault(const std::string& id, bool cleared) {
  msg::Fault message;
  message.id(id);
  message.term(1);
  message.sequence_number(cleared ? 2 : 1);
  message.severity(msg::Severity::SEVERITY_ERROR);
  message.cause(make_cause(msg::CauseKind::CAUSE_NODE_SILENT, "driver/west", "driver/west is silent"));
  message.cleared(cleared);
  return message;
}

msg::ObstacleShapes crate(const std::string& name) {
  msg::ObstacleShapes shapes;
  shapes.name(name);
  shapes.obstacle().name(name);
  shapes.obstacle().shapes().resize(1);
  return shapes;
}

/// 20 s: states of two arms at 100 Hz, until west falls silent at 12 s; a hold, a goal, a fault and a crate.
void write_story(Tape& tape) {
  for (int i = 0; i < 2000; ++i) {
    const auto at = i * 10ms;
    const auto number = static_cast<std::uint64_t>(i + 1);
    if (i % 4 == 0) tape.write(cell_mode(at < 5s || at >= 8s ? msg::Mode::MODE_RUN : msg::Mode::MODE_HOLD), at, 3);
    if (at == 2s) tape.write(goal_status("g1", msg::GoalState::GOAL_ACTIVE, 1), at, 4);
    if (at == 4s) tape.write(goal_status("g1", msg::GoalState::GOAL_REACHED, 2), at, 4);
    if (at == 13s) tape.write(fault("f1", false), at, 3);
    if (at == 15s) tape.write(fault("f1", true), at, 3);
    if (at == 3s) tape.write(crate("crate"), at, 5);
    if (at == 9s) tape.withdraw<msg::ObstacleShapes>("crate", at);
    tape.write(arm_state("north", number), at + 1us, 1);
    if (at < 12s) tape.write(arm_state("west", number), at + 2us, 2);
  }
}

std::uint64_t number_of(const RecordedCell& cell, const std::string& arm) {
  const auto* state = cell.state().state(arm);
  return state == nullptr ? 0 : state->value.sequence_number();
}

/// What the messages of write_story() say at a time.
void expect_story(const RecordedCell& cell, bus::Clock::duration at) {
  SCOPED_TRACE(std::chrono::duration<double>(at).count());
  const auto numbers = [](bus::Clock::duration time, bus::Clock::duration first) {
    return time < first ? 0U : static_cast<std::uint64_t>((time - first) / 10ms) + 1;
  };
  EXPECT_EQ(number_of(cell, "north"), std::min<std::uint64_t>(2000, numbers(at, 1us)));
  EXPECT_EQ(number_of(cell, "west"), std::min<std::uint64_t>(1200, numbers(at, 2us)));
  EXPECT_EQ(cell.state().mode().order("north"), at < 5s || at >= 8s ? msg::Mode::MODE_RUN : msg::Mode::MODE_HOLD);
  const auto* goal = cell.state().goal("north");
  ASSERT_EQ(goal == nullptr, at < 2s);
  if (goal != nullptr) {
    EXPECT_EQ(goal->value.state(), at < 4s ? msg::GoalState::GOAL_ACTIVE : msg::GoalState::GOAL_REACHED);
  }
  EXPECT_EQ(cell.state().obstacles().contains("crate"), at >= 3s && at < 9s);
  const auto& faults = cell.state().faults().all();
  ASSERT_EQ(faults.contains("f1"), at >= 13s);
  if (at >= 13s) {
    EXPECT_EQ(faults.at("f1").cleared(), at >= 15s);
  }
}

class Story : public testing::Test {
 protected:
  void SetUp() override {
    Tape tape({.path = path_});
    write_story(tape);
    ASSERT_EQ(tape.close(), std::vector<std::string>{path_});
  }
  TemporaryFolder folder_;
  std::string path_ = folder_.path("run.mcap");
};

TEST_F(Story, ShowsWhatTheMessagesUntilATimeSay) {
  const RecordingIndex index = index_recording({path_}, cell_file());
  EXPECT_EQ(index.begin, kBegan);
  EXPECT_EQ(index.end, kBegan + 19990ms + 1us);
  EXPECT_TRUE(index.notes.empty());
  RecordedCell cell(index);
  expect_story(cell, 0s);
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    const auto at = std::chrono::microseconds(random() % 19'990'000);
    cell.move_to(kBegan + at);
    EXPECT_EQ(cell.now(), kBegan + at);
    expect_story(cell, at);
  }
  cell.move_to(kBegan + 1h);
  expect_story(cell, 20s);
  EXPECT_EQ(cell.now(), index.end);
  cell.move_to(kBegan - 1h);
  expect_story(cell, 0s);
}

/// A feed at the time of a cell.
class Still : public CellFeed {
 public:
  explicit Still(const RecordedCell& cell) : cell_(cell) {}
  [[nodiscard]] const CellState& state() const override { return cell_.state(); }
  [[nodiscard]] Time now() const override { return cell_.now(); }
  [[nodiscard]] std::chrono::milliseconds unix_time() const override { return {}; }
  [[nodiscard]] double rate() const override { return 0.0; }
  [[nodiscard]] std::uint64_t leaps() const override { return 0; }
  [[nodiscard]] std::string text() const {
    return view::status_json(*this, {}).dump() + view::frame_json(*this, {}).dump() +
           view::obstacles_json(state()).dump();
  }

 private:
  const RecordedCell& cell_;
};

TEST_F(Story, ShowsTheSameAfterASeekAsWhenPlayed) {
  const RecordingIndex index = index_recording({path_}, cell_file());
  RecordedCell played(index);
  RecordedCell sought(index);
  std::mt19937_64 random(2);
  for (auto at = 0ms; at < 20s; at += 7ms) {
    played.move_to(kBegan + at);
    if (at.count() % 5 != 0) continue;
    sought.move_to(kBegan + std::chrono::milliseconds(random() % 20'000));
    sought.move_to(kBegan + at);
    ASSERT_EQ(Still(sought).text(), Still(played).text()) << at.count() << " ms";
  }
}

TEST_F(Story, MarksWhatHappened) {
  const RecordingIndex index = index_recording({path_}, cell_file());
  std::vector<std::string> marks;
  for (const Mark& mark : index.marks) {
    marks.push_back(std::to_string((mark.at - kBegan) / 1s) + " " + mark.subject + ": " + mark.text);
  }
  EXPECT_EQ(marks,
            (std::vector<std::string>{"0 : run", "2 north: goal g1 begun", "4 north: goal g1 reached",
                                      "5 : hold: a person", "8 : run", "13 driver/west: driver/west is silent"}));
  EXPECT_EQ(index.marks.back().until, kBegan + 15s);
}

TEST(Marks, LeaveOutWhatEndedBeforeTheRecording) {
  MarkFinder finder;
  const auto sample = [](const auto& message) {
    bus::Sample<std::decay_t<decltype(message)>> made;
    made.value = message;
    return made;
  };
  finder.take(sample(goal_status("old", msg::GoalState::GOAL_REACHED, 1)));
  finder.take(sample(goal_status("bad", msg::GoalState::GOAL_REJECTED, 1)));
  finder.take(sample(goal_status("bad", msg::GoalState::GOAL_REJECTED, 2)));
  finder.take(sample(fault("old", true)));
  const std::vector<Mark> marks = finder.take_marks();
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks[0].text, "goal bad rejected");
}

TEST_F(Story, StepsFromStateToStateOfAnArm) {
  const RecordingIndex index = index_recording({path_}, cell_file());
  RecordedCell cell(index);
  cell.move_to(kBegan + 7s);
  const std::uint64_t begin = number_of(cell, "north");
  for (std::uint64_t i = 1; i <= 250; ++i) {
    const auto next = cell.next_state("north");
    ASSERT_TRUE(next);
    cell.move_to(*next);
    ASSERT_EQ(number_of(cell, "north"), begin + i);
  }
  for (std::uint64_t i = 1; i <= 700; ++i) {
    const auto previous = cell.previous_state("north");
    ASSERT_TRUE(previous);
    cell.move_to(*previous);
    ASSERT_EQ(number_of(cell, "north"), begin + 250 - i);
  }
  cell.move_to(kBegan + 12s);
  EXPECT_FALSE(cell.next_state("west")) << "it is silent";
  EXPECT_EQ(cell.next_state(""), kBegan + 12s + 1us) << "of any arm";
  cell.move_to(index.begin);
  EXPECT_FALSE(cell.previous_state("north"));
  cell.move_to(index.end);
  EXPECT_FALSE(cell.next_state("north"));
}

/// States each 2 ms, and ticks of the planner of `north` each 10 ms between 100 ms and 300 ms.
TEST(Steps, GoFromTickToTickWhereTicksAreRecorded) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  for (int ms = 0; ms < 1500; ms += 2) {
    tape.write(arm_state("north", static_cast<std::uint64_t>(ms)), std::chrono::milliseconds(ms));
    if (ms >= 100 && ms <= 300 && ms % 10 == 0) {
      msg::PlannerTick tick;
      tick.arm("north");
      tick.sequence_number(static_cast<std::uint64_t>(ms));
      tape.write(tick, std::chrono::milliseconds(ms) + 300us);
    }
    tape.write(arm_state("west", static_cast<std::uint64_t>(ms)), std::chrono::milliseconds(ms) + 500us);
  }
  const RecordingIndex index = index_recording(tape.close(), cell_file());
  RecordedCell cell(index);
  Replay replay(cell);
  const auto step = [&](double from, int by, const std::string& arm) {
    replay.command(Json{{"op", "seek"}, {"at", from}}.dump());
    replay.command(Json{{"op", "step"}, {"by", by}, {"arm", arm}}.dump());
    return replay.playback_json().at("at").get<double>();
  };
  EXPECT_NEAR(step(200.3, 1, "north"), 210.3, 1e-6);
  EXPECT_NEAR(step(201.0, 1, "north"), 210.3, 1e-6);
  EXPECT_NEAR(step(201.0, -1, "north"), 200.3, 1e-6);
  EXPECT_NEAR(step(201.0, 1, ""), 210.3, 1e-6) << "a tick of any arm";
  EXPECT_NEAR(step(201.0, 1, "west"), 202.5, 1e-6) << "its planner has no ticks";
  EXPECT_NEAR(step(201.0, -1, "west"), 200.5, 1e-6);
  EXPECT_NEAR(step(401.0, 1, "north"), 402.0, 1e-6) << "behind the last tick";
  EXPECT_NEAR(step(1401.0, -1, "north"), 1400.0, 1e-6) << "the last tick is more than 1 s before";
}

TEST_F(Story, IsPlayedUntilTheLastWholeRecordOfACutFile) {
  const std::uint64_t size = std::filesystem::file_size(path_);
  std::mt19937_64 random(3);
  for (int i = 0; i < 20; ++i) {
    const std::string cut = folder_.path("cut.mcap");
    std::filesystem::copy_file(path_, cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(cut, size / 4 + random() % (size / 4));
    const RecordingIndex index = index_recording({cut}, cell_file());
    ASSERT_EQ(index.notes.size(), 1U);
    EXPECT_EQ(index.notes[0], cut + " has no end: its recorder was killed, had no room on the disk, or still writes");
    EXPECT_LT(index.end, kBegan + 19s);
    RecordedCell cell(index);
    cell.move_to(index.end - 1us);  // the last message may have one of the same time behind it
    expect_story(cell, index.end - 1us - kBegan);
    cell.move_to(index.begin + (index.end - index.begin) / 2);
    expect_story(cell, (index.end - index.begin) / 2);
  }
}

TEST_F(Story, LeavesOutDamagedChunksAndSaysSo) {
  const RecordingIndex whole = index_recording({path_}, cell_file());
  const auto chunk = std::find_if(whole.chunks.begin(), whole.chunks.end(),
                                  [](const RecordedChunk& one) { return one.before >= kBegan + 6s; });
  ASSERT_NE(chunk, whole.chunks.end());
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(chunk->at + 100));
  file.write("damage", 6);
  file.close();
  const RecordingIndex index = index_recording({path_}, cell_file());
  ASSERT_FALSE(index.notes.empty());
  EXPECT_NE(index.notes[0].find("is damaged"), std::string::npos) << index.notes[0];
  RecordedCell cell(index);
  cell.move_to(kBegan + 5500ms);
  expect_story(cell, 5500ms);
  cell.move_to(index.end);
  expect_story(cell, 20s);
}

TEST_F(Story, RefusesAFileThatChangedMeanwhile) {
  const RecordingIndex index = index_recording({path_}, cell_file());
  RecordedCell cell(index);
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  EXPECT_NE(error_of([&] { cell.move_to(index.end); }).find("has changed since it was opened"), std::string::npos);
}

TEST(SplitRecording, IsPlayedAsOne) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap"), .split_time = 4s});
  write_story(tape);
  const std::vector<std::string> files = tape.close();
  ASSERT_EQ(files.size(), 5U);
  const RecordingIndex index = index_recording(files, cell_file());
  EXPECT_TRUE(index.notes.empty()) << index.notes[0];
  RecordedCell cell(index);
  std::mt19937_64 random(4);
  for (int i = 0; i < 100; ++i) {
    const auto at = std::chrono::microseconds(random() % 19'990'000);
    cell.move_to(kBegan + at);
    expect_story(cell, at);
  }

  // A part alone begins with the kept state of the cell.
  const RecordingIndex second = index_recording({files[1]}, cell_file());
  RecordedCell alone(second);
  EXPECT_TRUE(alone.state().obstacles().contains("crate"));
  EXPECT_EQ(alone.state().goal("north")->value.goal(), "g1");

  // With a part missing, nothing of the time before the gap is shown after it.
  const RecordingIndex gap = index_recording({files[0], files[3]}, cell_file());
  ASSERT_EQ(gap.notes.size(), 1U);
  EXPECT_EQ(gap.notes[0], "nothing was recorded for 8 s before " + files[3]);
  RecordedCell gapped(gap);
  for (int round = 0; round < 2; ++round) {
    gapped.move_to(kBegan + 10s);
    EXPECT_TRUE(gapped.state().obstacles().contains("crate")) << "the last known state, with its age";
    EXPECT_EQ(number_of(gapped, "west"), 400U);
    gapped.move_to(kBegan + 14s);
    EXPECT_FALSE(gapped.state().obstacles().contains("crate"));
    EXPECT_EQ(number_of(gapped, "west"), 0U);
  }

  EXPECT_EQ(error_of([&] {
              static_cast<void>(index_recording({files[1], files[0]}, cell_file()));
            }),
            files[0] + " begins before " + files[1] + " ends; name the files of one recording, in their order");
}

TEST(LongRecording, HasABoundedNumberOfCheckpoints) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  constexpr int kSeconds = 600;  // a chunk each
  for (int i = 0; i < kSeconds; ++i) {
    for (int k = 0; k < 3; ++k)
      tape.write(arm_state("north", static_cast<std::uint64_t>(3 * i + k)), i * 1s + k * 100ms);
    if (i % 10 == 0) tape.write(crate("crate" + std::to_string(i)), i * 1s + 300ms);
  }
  const RecordingIndex index = index_recording(tape.close(), cell_file());
  EXPECT_GT(index.chunks.size(), 500U);
  EXPECT_LE(index.checkpoints.size(), RecordingIndex::kMostCheckpoints);
  EXPECT_GE(index.checkpoints.size(), RecordingIndex::kMostCheckpoints / 2);
  RecordedCell cell(index);
  std::mt19937_64 random(5);
  for (int i = 0; i < 100; ++i) {
    const auto second = random() % kSeconds;
    cell.move_to(kBegan + std::chrono::seconds(second) + 350ms);
    ASSERT_EQ(number_of(cell, "north"), 3 * second + 2);
    ASSERT_EQ(cell.state().obstacles().size(), second / 10 + 1);
  }
}

TEST_F(Story, FollowsTheCommandsOfAPage) {
  const RecordingIndex index = index_recording({path_}, cell_file());
  RecordedCell cell(index);
  Replay replay(cell);
  const auto at = [&] { return replay.playback_json().at("at").get<double>(); };
  EXPECT_EQ(replay.rate(), 0.0);
  replay.advance(1s);
  EXPECT_EQ(at(), 0.0) << "it is paused first";
  for (const char* malformed :
       {"", "seek", "[]", "{}", R"({"op":"seek"})", R"({"op":"seek","at":"1"})", R"({"op":7})", R"({"op":"speed"})"}) {
    replay.command(malformed);
  }
  EXPECT_EQ(at(), 0.0);
  replay.command(R"({"op":"seek","at":5000.5})");
  EXPECT_EQ(at(), 5000.5);
  EXPECT_EQ(replay.leaps(), 1U);
  EXPECT_EQ(replay.unix_time(), 1'700'000'005'000ms);
  replay.command(R"({"op":"speed","value":2})");
  replay.command(R"({"op":"play"})");
  EXPECT_EQ(replay.rate(), 2.0);
  replay.advance(100ms);
  EXPECT_NEAR(at(), 5200.5, 1e-6);
  EXPECT_EQ(replay.leaps(), 1U) << "time ran on";
  replay.command(R"({"op":"step","by":1,"arm":"north"})");
  EXPECT_EQ(replay.rate(), 0.0) << "a step pauses";
  EXPECT_NEAR(at(), 5210.001, 1e-6);
  replay.command(R"({"op":"step","by":-1,"arm":"north"})");
  EXPECT_NEAR(at(), 5200.001, 1e-6);
  replay.command(R"({"op":"speed","value":1e9})");
  replay.command(R"({"op":"seek","at":1e300})");
  replay.command(R"({"op":"play"})");
  EXPECT_EQ(replay.rate(), Replay::kFastest);
  EXPECT_EQ(at(), 0.0) << "play at the end begins again";
  for (int i = 0; i < 21; ++i) replay.advance(100ms);
  EXPECT_EQ(replay.rate(), 0.0) << "it ends";
  EXPECT_EQ(replay.now(), index.end);
  const Json recording = replay.recording_json();
  EXPECT_EQ(recording.at("files"), Json({"run.mcap"}));
  EXPECT_EQ(recording.at("begin"), 1'700'000'000'000);
  EXPECT_EQ(recording.at("marks").size(), 6U);
}

TEST(OtherVersion, IsNamedIfTheFileDoesNotDescribeIt) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  msg::ArmState old = arm_state("north", 1);
  old.schema(msg::SCHEMA_VERSION - 1);
  tape.write(old, 0s);
  const std::string error = error_of([&] { static_cast<void>(index_recording(tape.close(), cell_file())); });
  EXPECT_NE(error.find("hecaton/ArmState: its messages have version " + std::to_string(msg::SCHEMA_VERSION - 1) +
                       ", and their structure in the file has version " + std::to_string(msg::SCHEMA_VERSION)),
            std::string::npos)
      << error;
}

TEST(Explain, SaysWhatBindsAnArm) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  msg::GoalStatus goal = goal_status("g1", msg::GoalState::GOAL_BLOCKED, 1);
  goal.cause(make_cause(msg::CauseKind::CAUSE_GIVING_WAY, "west", "gives way to west"));
  goal.has_binding(true);
  goal.binding_own("north/wrist");
  goal.binding_other("west/forearm");
  goal.binding_distance(0.031);
  goal.blocked_duration(2.5);
  msg::ArmState north = arm_state("north", 1);
  north.qd(std::vector<double>(6, 0.0));
  msg::Heartbeat planner;
  planner.node("planner/north");
  planner.state(msg::NodeState::NODE_RUNNING);
  planner.oldest_input("ArmState/west");
  planner.oldest_input_age(0.012);
  tape.write(cell_mode(msg::Mode::MODE_RUN), 0s, 3);
  tape.write(goal, 1ms, 4);
  tape.write(planner, 2ms, 4);
  tape.write(north, 5ms, 1);
  tape.write(cell_mode(msg::Mode::MODE_RUN), 9ms, 3);
  const RecordingIndex index = index_recording(tape.close(), cell_file());
  RecordedCell cell(index);
  cell.move_to(index.end);
  std::string text;
  for (const std::string& sentence : explain(cell.state(), "north", cell.now())) text += sentence + "\n";
  for (const char* part :
       {"The order for north is run, by supervisor in term 1.", "north stands; its drive is running.",
        "gives way to west", "[giving_way, west]", "Goal g1 is blocked",
        "north/wrist and west/forearm bound its motion: they are 31 mm apart, and 30 mm are the security distance.",
        "north last moved freely to its goal 2.5 s ago.", "north 4.0 ms, west never, east never",
        "planner/north is running; its oldest input is ArmState/west, 12 ms, as it said 7.0 ms before."}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
  }
}

TEST(Explain, SaysForHowLongNoSupervisorWasHeard) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  tape.write(cell_mode(msg::Mode::MODE_RUN), 0s, 3);
  for (int i = 1; i <= 13; ++i) tape.write(arm_state("north", static_cast<std::uint64_t>(i)), i * 250ms, 1);
  const RecordingIndex index = index_recording(tape.close(), cell_file());
  RecordedCell cell(index);
  const auto order_at = [&](bus::Clock::duration at) {
    cell.move_to(index.begin + at);
    return explain(cell.state(), "north", cell.now()).front();
  };
  EXPECT_EQ(order_at(900ms), "The order for north is run, by supervisor in term 1.");
  EXPECT_EQ(order_at(3200ms),
            "The order for north is run, by supervisor in term 1. No supervisor was heard for 3.2 s.");
}

TEST(Explain, SaysThatAnInputWasNeverReceived) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  msg::Heartbeat planner;
  planner.node("planner/north");
  planner.oldest_input("ArmState/west");
  planner.oldest_input_age(-1.0);
  tape.write(cell_mode(msg::Mode::MODE_RUN), 0s, 3);
  tape.write(planner, 2ms, 4);
  const RecordingIndex index = index_recording(tape.close(), cell_file());
  RecordedCell cell(index);
  cell.move_to(index.end);
  std::string text;
  for (const std::string& sentence : explain(cell.state(), "north", cell.now())) text += sentence + "\n";
  EXPECT_NE(text.find("its oldest input is ArmState/west, which it has never received, as"), std::string::npos) << text;
}

TEST(Explain, NamesThePairThatBoundAnArmTheLongest) {
  const TemporaryFolder folder;
  Tape tape({.path = folder.path("run.mcap")});
  msg::GoalStatus goal = goal_status("g1", msg::GoalState::GOAL_ACTIVE, 1);
  goal.binding_own("north/wrist");
  tape.write(cell_mode(msg::Mode::MODE_RUN), 0s, 3);
  // For the first second a post binds the arm, for the next three west does, and then nothing.
  for (int i = 0; i < 50; ++i) {
    goal.stamp_ns(i + 1);
    goal.elapsed(0.1 * i);
    goal.has_binding(i < 40);
    goal.binding_other(i < 10 ? "post" : "west/forearm");
    goal.distance_to_goal(i == 5 ? 0.25 : 0.75);
    tape.write(goal, i * 100ms, 4);
  }
  goal = goal_status("g2", msg::GoalState::GOAL_ACTIVE, 51);
  goal.elapsed(0.1);
  tape.write(goal, 5s, 4);
  const RecordingIndex index = index_recording(tape.close(), cell_file());
  RecordedCell cell(index);
  const auto at = index.begin + 4950ms;
  const LongestBinding longest = longest_binding(cell, "north", at);
  EXPECT_EQ(cell.now(), at);
  EXPECT_EQ(longest.own, "north/wrist");
  EXPECT_EQ(longest.other, "west/forearm");
  EXPECT_NEAR(longest.bound, 3.0, 0.2);
  EXPECT_NEAR(longest.window, 4.9, 0.05);
  std::string text;
  for (const std::string& sentence : explain(cell.state(), "north", at, longest)) text += sentence + "\n";
  EXPECT_NE(text.find("In the last 4.9 s north/wrist and west/forearm bound its motion longer than any other pair: for "
                      "3.0 s."),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("s ago, with 0.25 rad or m to go; then north/wrist and post bound its motion."),
            std::string::npos)
      << text;
  EXPECT_NEAR(longest.nearest_ago, 4.45, 0.1);
  EXPECT_EQ(longest_binding(cell, "north", index.end).bound, 0.0) << "a new goal";
}

}  // namespace
}  // namespace hecaton::services::replay
