/// hecaton record and hecaton bag on a live cell of three arms. A second reader of the cell, and libraries of others,
/// say what the recording must contain.

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include <idl/arm.h>
#include <idl/health.h>

#include "services/bus/endpoint.hpp"
#include "services/recorder/bag.hpp"
#include "services/recorder/cdr_columns.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/process_info.hpp"
#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using namespace services::recorder;

/// Measured positions by arm and sequence number.
using States = std::map<std::pair<std::string, std::uint64_t>, std::vector<double>>;

/// Reads the states of the cell as every other node does.
class SecondReader {
 public:
  explicit SecondReader(const std::string& domain)
      : file_(config::load_cell_file(kThreePuma)),
        participant_(services::make_participant(file_, options(domain), services::Role::kViewer, "second reader")),
        reader_(participant_, nullptr, {.deadline = {}, .conflate = false, .queue = 1U << 20U}) {}

  [[nodiscard]] bool finds_the_drivers() { return reader_.wait_matched(3, kPatience); }
  States take() {
    States states;
    for (const auto& sample : reader_.take()) {
      states[{sample.value.arm(), sample.value.sequence_number()}] = sample.value.q();
    }
    return states;
  }

 private:
  static services::ServiceOptions options(const std::string& domain) {
    services::ServiceOptions options;
    options.domain = std::stoi(domain);
    return options;
  }
  config::CellFile file_;
  bus::Participant participant_;
  bus::Reader<msg::ArmState> reader_;
};

/// Of a CSV file without quoted cells.
std::vector<std::vector<std::string>> rows_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line, '\n');) {
    line.pop_back();  // '\r'
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

/// The states of an exported file of ArmState.
States exported_states(const std::string& path) {
  const auto rows = rows_of(path);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(rows[0].begin(), rows[0].end(), name) - rows[0].begin());
  };
  const std::size_t arm = column("arm");
  const std::size_t number = column("sequence_number");
  const std::size_t q = column("q[0]");
  States states;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    std::vector<double>& values = states[{rows[i][arm], std::stoull(rows[i][number])}];
    for (std::size_t k = 0; k < 6; ++k) values.push_back(std::stod(rows[i][q + k]));
  }
  return states;
}

class RecordedCell : public LiveCell {
 protected:
  /// Some goals, one after the other.
  void move_arms() const {
    for (const char* pose : {"ready", "home"}) {
      for (const char* arm : {"north", "west", "east"}) {
        EXPECT_EQ(run({"goal", arm, "--named", pose, "--wait"}).code, 0) << arm;
      }
    }
  }
  TemporaryFolder folder_;
  std::string path_ = folder_.path("run.mcap");
};

TEST_F(RecordedCell, HasWhatASecondReaderSaw) {
  const auto recorder = start({"record", kThreePuma, "-o", path_});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  SecondReader second(domain());
  ASSERT_TRUE(second.finds_the_drivers());
  // Which of the two readers hears of a driver first is left to discovery: both do before the first goal has ended.
  EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait"}).code, 0);
  second.take();
  move_arms();
  const States seen = second.take();
  recorder->signal(SIGINT);
  ASSERT_EQ(recorder->wait(), 0) << recorder->err();

  const BagInfo info = bag_info(path_);
  EXPECT_TRUE(info.file.whole());
  EXPECT_EQ(info.cell, "three_puma");
  for (const char* type : {"ArmState", "ArmCommand", "Heartbeat", "CellMode", "Goal", "GoalStatus", "ObstacleStates",
                           "ObstacleShapes", "ContactReport", "Reachability", "ProcessEvent"}) {
    EXPECT_TRUE(info.topics.contains("hecaton/" + std::string(type))) << type;
  }
  EXPECT_EQ(info.topics.at("hecaton/ArmState").nodes,
            (std::set<std::string>{"driver/east", "driver/north", "driver/west"}));
  EXPECT_TRUE(info.topics.at("hecaton/CellMode").nodes.contains("supervisor"));
  // All nodes share the clock of this machine.
  ASSERT_EQ(info.clocks.size(), 1U);
  const ClockFigures& clock = info.clocks.begin()->second;
  EXPECT_GT(clock.samples, 100U);
  EXPECT_GT(clock.least, -100'000'000);
  EXPECT_LT(clock.least, 100'000'000);
  // The cell file, its robots, and nothing else.
  bool has_cell_file = false;
  for (const BagFile& file : info.attachments) has_cell_file |= file.name.ends_with("/three_puma.yaml");
  EXPECT_TRUE(has_cell_file);
  EXPECT_EQ(std::count_if(info.attachments.begin(), info.attachments.end(),
                          [](const BagFile& file) { return file.name.ends_with(".urdf"); }),
            1);

  const Ran export_run = run({"bag", "export", path_, "--csv", "-o", folder_.path("csv"), "--output", "json"});
  ASSERT_EQ(export_run.code, 0) << export_run.err;
  const Json exported = Json::parse(export_run.out);
  EXPECT_EQ(exported.at("files").size(), info.topics.size() - 2 - info.topics.count("recorder/withdrawn"));
  const States recorded = exported_states(folder_.path("csv/ArmState.csv"));
  ASSERT_GT(seen.size(), 1000U);
  std::size_t missing = 0;
  for (const auto& [key, q] : seen) {
    const auto found = recorded.find(key);
    if (found == recorded.end()) {
      ++missing;
    } else {
      EXPECT_EQ(found->second, q) << key.first << " " << key.second;  // to the last bit
    }
  }
  // What the recording lacks it has counted.
  EXPECT_LE(missing, info.losses.at("hecaton/ArmState").missing);
  EXPECT_EQ(info.losses.at("hecaton/ArmState").refused, 0U);
}

TEST_F(RecordedCell, IsReadByLibrariesOfOthers) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  HECATON_NEED_FILES({page + "/node_modules/@mcap/core", node});
  const auto recorder = start({"record", kThreePuma, "-o", path_, "--output", "json"});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  move_arms();
  recorder->signal(SIGTERM);
  ASSERT_EQ(recorder->wait(), 0) << recorder->err();
  const Json result = Json::parse(recorder->out());
  EXPECT_EQ(result.at("files"), Json::array({path_}));

  Process other({node, page + "/test/bag.mjs", path_, "hecaton/ArmState", "arm", "sequence_number", "q"});
  ASSERT_EQ(other.wait(), 0) << other.err();
  std::istringstream lines(other.out());
  std::string line;
  std::getline(lines, line);
  const Json contents = Json::parse(line);
  const BagInfo info = bag_info(path_);
  for (const auto& [name, topic] : info.topics) EXPECT_EQ(contents.at("topics").at(name), topic.messages) << name;
  EXPECT_EQ(contents.at("topics").size(), info.topics.size());
  EXPECT_EQ(contents.at("attachments").size(), info.attachments.size());
  EXPECT_EQ(contents.at("metadata"), Json::array({"hecaton"}));

  ASSERT_EQ(run({"bag", "export", path_, "--csv", "-o", folder_.path("csv")}).code, 0);
  States decoded;
  while (std::getline(lines, line)) {
    const Json state = Json::parse(line);
    decoded[{state.at("arm").get<std::string>(), std::stoull(state.at("sequence_number").get<std::string>())}] =
        state.at("q").get<std::vector<double>>();
  }
  EXPECT_EQ(decoded, exported_states(folder_.path("csv/ArmState.csv")));
  EXPECT_EQ(decoded.size(), info.topics.at("hecaton/ArmState").messages);
}

TEST_F(RecordedCell, HasTheTopicsOfRos2ForLibrariesOfOthers) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  HECATON_NEED_FILES({page + "/node_modules/@mcap/core", node});
  const auto recorder = start({"record", kThreePuma, "-o", path_, "--ros2", "--split-time", "2s", "--output", "json"});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  move_arms();
  recorder->signal(SIGTERM);
  ASSERT_EQ(recorder->wait(), 0) << recorder->err();
  const std::vector<std::string> files = Json::parse(recorder->out()).at("files");
  ASSERT_GE(files.size(), 2U);

  const auto read = [&](const std::string& file, const std::vector<std::string>& topic_and_fields) {
    std::vector<std::string> words{node, page + "/test/bag.mjs", file};
    words.insert(words.end(), topic_and_fields.begin(), topic_and_fields.end());
    Process other(words);
    EXPECT_EQ(other.wait(), 0) << other.err();
    std::istringstream lines(other.out());
    std::vector<Json> all;
    for (std::string line; std::getline(lines, line);) all.push_back(Json::parse(line));
    return all;
  };
  std::map<std::string, std::set<std::vector<double>>> measured;  // by arm
  std::set<std::vector<double>> shown;
  std::size_t messages = 0;
  for (const std::string& file : files) {
    const std::vector<Json> told =
        read(file, {"hecaton/ArmState", "arm", "q", "--", "/joint_states", "name", "position"});
    const auto is_state = [](const Json& message) { return message.at("topic") == "hecaton/ArmState"; };
    for (std::size_t i = 1; i < told.size(); ++i) {
      if (is_state(told[i])) measured[told[i].at("arm")].insert(told[i].at("q"));
    }
    // Readers of each file find the robots, and the transforms that never change.
    for (const char* latched : {"/robot_description", "/north/robot_description", "/tf_static"}) {
      EXPECT_EQ(told[0].at("topics").value(latched, 0), 1) << latched << " in " << file;
    }
    for (std::size_t i = 1; i < told.size(); ++i) {
      if (is_state(told[i])) continue;
      const std::vector<std::string> names = told[i].at("name");
      const std::vector<double> positions = told[i].at("position");
      ASSERT_EQ(names.size(), positions.size());
      ASSERT_EQ(positions.size() % 6, 0U);
      for (std::size_t at = 0; at < names.size(); at += 6) {
        const std::string arm = names[at].substr(0, names[at].find('_'));
        const auto first = positions.begin() + static_cast<std::ptrdiff_t>(at);
        const std::vector<double> q(first, first + 6);
        EXPECT_TRUE(measured.at(arm).contains(q)) << arm << ": its driver has not measured these positions";
        shown.insert(q);
      }
      ++messages;
    }
  }
  EXPECT_GT(messages, 50U);
  EXPECT_GT(shown.size(), 50U) << "arms that move";

  // The topics of ROS 2 hide nothing of the cell: it replays as any other recording.
  const Ran info = run_hecaton({"bag", "info", files[0], "-o", "json"});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_EQ(run({"bag", "export", files[0], "--csv", "-o", folder_.path("csv")}).code, 0);
  const Ran verified = run_hecaton({"replay", files[0], "--verify"});
  EXPECT_EQ(verified.code, 0) << verified.out << verified.err;
}

TEST_F(RecordedCell, ReadsWhatAKilledRecorderHasWritten) {
  const auto recorder = start({"record", kThreePuma, "-o", path_});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait"}).code, 0);
  // The recording grows while it is read.
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!bag_info(path_).topics.contains("hecaton/ArmState") && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(50ms);
  }
  recorder->signal(SIGKILL);
  EXPECT_EQ(recorder->wait(), 128 + SIGKILL);
  const Ran info = run_hecaton({"bag", "info", path_, "-o", "json"});
  EXPECT_EQ(info.code, 1);
  EXPECT_NE(info.err.find(path_), std::string::npos) << info.err;
  const Json json = Json::parse(info.out);
  EXPECT_FALSE(json.at("whole").get<bool>());
  EXPECT_GT(json.at("messages").get<int>(), 100);
}

TEST_F(RecordedCell, GoesOnWhenTheDiskOfTheRecorderIsFull) {
  // 1 MB is full within seconds.
  const auto recorder = std::make_unique<Process>(std::vector<std::string>{
      "/bin/sh", "-c", "trap '' XFSZ; ulimit -f 2000; exec \"$0\" record \"$1\" -o \"$2\" --domain " + domain(),
      std::string(HECATON_BIN_DIR) + "/hecaton", kThreePuma, path_});
  EXPECT_EQ(recorder->wait(), 1) << recorder->err();
  EXPECT_NE(recorder->err().find("the disk is full"), std::string::npos) << recorder->err();
  EXPECT_TRUE(bag_info(path_).file.damages.empty());
  EXPECT_GT(bag_info(path_).file.messages, 100U);
  EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait"}).code, 0);
}

TEST_F(RecordedCell, SavesItsLastFilesByOrderAndAfterAStop) {
  const auto recorder =
      start({"record", kThreePuma, "-o", path_, "--keep", "1s", "--after-fault", "0s", "--output", "json"});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  recorder->signal(SIGUSR1);
  ASSERT_TRUE(recorder->wait_for_message("saved what is kept: a person ordered it")) << recorder->err();
  const Ran ordered = run({"record", kThreePuma, "--save", "--output", "json"});
  ASSERT_EQ(ordered.code, 0) << ordered.err;
  const Json replies = Json::parse(ordered.out);
  ASSERT_EQ(replies.size(), 1U) << replies;
  EXPECT_EQ(replies[0].at("host"), services::machine_name());
  EXPECT_TRUE(std::filesystem::exists(replies[0].at("file").get<std::string>())) << replies;
  EXPECT_EQ(run({"stop", "north"}).code, 0);
  ASSERT_TRUE(recorder->wait_for_message("saved what is kept: a person ordered a stop of north")) << recorder->err();
  // A second stop is one, too, while the first lasts.
  EXPECT_EQ(run({"stop"}).code, 0);
  ASSERT_TRUE(recorder->wait_for_message("saved what is kept: a person ordered a stop of the cell")) << recorder->err();
  recorder->signal(SIGINT);
  ASSERT_EQ(recorder->wait(), 0) << recorder->err();
  EXPECT_EQ(run({"resume"}).code, 0);
  // No agent of this cell runs a recorder.
  const Ran none = run({"record", kThreePuma, "--save"});
  EXPECT_EQ(none.code, 5);
  EXPECT_NE(none.err.find("the key record"), std::string::npos) << none.err;
}

/// A cell whose agent starts a recorder. Where its folder is to be, a file stands at first.
class CellWithRecorder : public LiveCell {
 protected:
  CellWithRecorder() {
    std::filesystem::create_directory_symlink(std::string(HECATON_LIVE_CELLS) + "/urdf", folder_.path("urdf"));
    std::ifstream file(kThreePuma);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    folder_.write("cell.yaml",
                  text + "\nrecord: {folder: recordings, keep: 10s, after_fault: 2s, split_time: 2s, ros2: true}\n");
    folder_.write("recordings", "in the way");
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path("cell.yaml"); }
  [[nodiscard]] std::vector<std::string> up_options() const override { return {"--log-dir", folder_.path("logs")}; }

  /// Asks for the faults until one of the recorder is there, or none is.
  [[nodiscard]] bool await_fault(bool there) const {
    for (const auto until = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < until;) {
      const Json faults = json({"faults"});
      const bool open = std::any_of(faults.begin(), faults.end(), [](const Json& fault) {
        return fault.at("subject") == "recorder" && fault.at("kind") == "node_failed" && !fault.at("cleared");
      });
      if (open == there) return true;
    }
    return false;
  }
  TemporaryFolder folder_;
};

TEST_F(CellWithRecorder, GoesOnWhileTheDiskRefusesAndSavesAFault) {
  EXPECT_TRUE(await_fault(true));
  const Ran refused = run({"record", cell_file(), "--save"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("the cell is not recorded: "), std::string::npos) << refused.err;
  EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait"}).code, 0) << "the fault holds no arm";
  std::filesystem::remove(folder_.path("recordings"));
  EXPECT_TRUE(await_fault(false));

  const Ran saved = run({"record", cell_file(), "--save", "--output", "json"});
  ASSERT_EQ(saved.code, 0) << saved.err;
  const Json replies = Json::parse(saved.out);
  ASSERT_EQ(replies.size(), 1U) << replies;
  EXPECT_EQ(replies[0].at("host"), "localhost");
  const std::string newest = replies[0].at("file");
  EXPECT_TRUE(std::filesystem::exists(newest)) << newest;
  ASSERT_EQ(kill(processes().at("driver/west"), SIGKILL), 0);
  EXPECT_EQ(run({"goal", "north", "--named", "home", "--wait"}).code, 0);
  up_->signal(SIGINT);
  EXPECT_EQ(up_->wait(), 0) << up_->err();
  up_.reset();

  // `ros2: true`: for programs that know no message of the cell.
  const BagInfo with_ros2 = bag_info(newest);
  for (const char* topic : {"/joint_states", "/tf", "/robot_description"}) {
    const auto found = with_ros2.topics.find(topic);
    ASSERT_NE(found, with_ros2.topics.end()) << topic;
    EXPECT_GT(found->second.messages, 0U) << topic;
  }
  std::uint64_t faults = 0;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path("recordings"))) {
    const BagInfo info = bag_info(entry.path());
    EXPECT_TRUE(info.file.whole()) << entry.path();
    ++files;
    const auto found = info.topics.find("hecaton/Fault");
    if (found != info.topics.end()) faults += found->second.messages;
    EXPECT_FALSE(info.clocks.empty()) << entry.path();
    const std::string csv = folder_.path("csv-" + entry.path().stem().string());
    for (const auto& [name, topic] : export_csv({entry.path()}, csv).topics) {
      EXPECT_EQ(topic.skipped, 0U) << name << ": " << topic.reason;
    }
  }
  EXPECT_GT(faults, 0U);
  EXPECT_GT(files, 1U) << "another one begins each 2 s";
  const auto logs = std::filesystem::directory_iterator(folder_.path("logs"));
  EXPECT_TRUE(std::any_of(begin(logs), end(logs), [](const auto& log) {
    std::ifstream file(log.path());
    return std::string(std::istreambuf_iterator<char>(file), {}).find("because=\"a person ordered it\"") !=
           std::string::npos;
  })) << "the order to save";
}

/// three_puma with a standby for each planner, as on two hosts.
class CellWithStandbys : public LiveCell {
 protected:
  CellWithStandbys() {
    std::filesystem::create_directory_symlink(std::string(HECATON_LIVE_CELLS) + "/urdf", folder_.path("urdf"));
    std::ifstream file(kThreePuma);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto replace = [&text](const std::string& from, const std::string& to) {
      const std::size_t at = text.find(from);
      ASSERT_NE(at, std::string::npos) << from;
      text.replace(at, from.size(), to);
    };
    replace("supervision:\n",
            "hosts: {here: 127.0.0.1, there: 127.0.0.1}\nworld: {host: here}\nsupervision:\n  host: here\n");
    for (const std::string arm : {"north", "west", "east"}) {
      replace("- name: " + arm + "\n", "- name: " + arm + "\n    host: here\n    standby_host: there\n");
    }
    folder_.write("cell.yaml", text);
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path("cell.yaml"); }

  /// The node that commands the arm.
  [[nodiscard]] std::string planner_of(const std::string& arm) const {
    return entry(json({"status"}).at("arms"), "name", arm).at("planner").get<std::string>();
  }
  TemporaryFolder folder_;
};

TEST_F(CellWithStandbys, IsRecomputedToTheLastBitAfterAFailover) {
  const std::string path = folder_.path("run.mcap");
  const auto recorder = start({"record", cell_file(), "-o", path});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  const auto to = [&](const char* pose) {
    std::vector<std::unique_ptr<Process>> goals;
    for (const char* arm : {"north", "west", "east"}) {
      goals.push_back(start({"goal", arm, "--named", pose, "--wait"}));
    }
    for (const auto& goal : goals) EXPECT_EQ(goal->wait(), 0) << goal->err();
  };
  to("ready");
  const std::string before = planner_of("north");
  ASSERT_EQ(kill(processes().at(before), SIGKILL), 0);
  for (const auto until = std::chrono::steady_clock::now() + kPatience;
       planner_of("north") == before && std::chrono::steady_clock::now() < until;) {
  }
  to("home");
  recorder->signal(SIGINT);
  ASSERT_EQ(recorder->wait(), 0) << recorder->err();
  EXPECT_EQ(bag_info(path).topics.at("hecaton/PlannerTick").nodes.count(before), 1U);
  EXPECT_GE(bag_info(path).topics.at("hecaton/PlannerTick").nodes.size(), 4U) << "the standby of north commanded";

  const Ran verified = run_hecaton({"replay", path, "--verify", "-o", "json"});
  EXPECT_EQ(verified.code, 0) << verified.out << verified.err;
  const Json result = Json::parse(verified.out);
  ASSERT_EQ(result.at("arms").size(), 3U);
  for (const Json& arm : result.at("arms")) {
    EXPECT_EQ(arm.at("differing"), 0) << arm;
    EXPECT_EQ(arm.at("differing_memories"), 0) << arm;
    EXPECT_EQ(arm.at("differing_commands"), 0) << arm;
    EXPECT_GT(arm.at("recomputed").get<int>(), 100) << arm;
    EXPECT_GT(arm.at("commands").get<int>(), 100) << arm;
    std::printf("%s\n", arm.dump().c_str());
  }
}

TEST(Record, SaysWhatItNeeds) {
  const TemporaryFolder folder;
  const std::string file = folder.path("a.mcap");
  const FreeDomain free;
  const std::string domain = std::to_string(free.number());
  const auto refused = [&](std::vector<std::string> words, int code, const std::string& part) {
    const Ran ran = run_hecaton(std::move(words));
    EXPECT_EQ(ran.code, code) << ran.err;
    EXPECT_NE(ran.err.find(part), std::string::npos) << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  };
  refused({"record"}, 2, "cell file");
  refused({"record", kThreePuma}, 2, "-o FILE.mcap");
  refused({"record", "missing.yaml", "-o", file}, 3, "missing.yaml");
  refused({"record", kThreePuma, "-o", file, "--after-fault", "1s"}, 2, "--keep");
  refused({"record", kThreePuma, "-o", file, "--save"}, 2, "--save");
  refused({"record", kThreePuma, "-o", file, "--split-size", "5"}, 3, "--split-size");
  refused({"record", kThreePuma, "-o", file, "--keep", "-1min"}, 3, "--keep");
  refused({"record", kThreePuma, "-o", folder.path("none/a.mcap"), "--domain", domain}, 3, "none/a.mcap");
  refused({"record", kThreePuma, "-o", folder.path("run"), "--domain", domain}, 3,
          "run' must be a file that ends in .mcap");
  const std::string there = folder.write("there.mcap", "precious");
  refused({"record", kThreePuma, "-o", there, "--domain", domain}, 3, "exists already");
  refused({"bag", "info", there}, 3, "there.mcap");
  refused({"bag", "info", folder.path("missing.mcap")}, 3, "missing.mcap");
  refused({"bag", "export", there, "-o", folder.path("csv")}, 2, "--csv");
  refused({"bag", "export", there, "--csv"}, 2, "-o DIR");
  // No cell: nothing to keep.
  const Ran nothing = run_hecaton({"record", kThreePuma, "-o", file, "--domain", domain, "--duration", "1s"});
  EXPECT_EQ(nothing.code, 5) << nothing.err;
  EXPECT_NE(nothing.err.find("domain " + domain), std::string::npos) << nothing.err;
  EXPECT_TRUE(nothing.out.empty()) << nothing.out;
  EXPECT_FALSE(std::filesystem::exists(file)) << "the next try would be refused";
}

}  // namespace
}  // namespace hecaton::test
