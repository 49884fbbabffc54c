/// Trajectories of a ROS 2 client in a cell on two hosts of this machine, where each planner has a standby.

#include <csignal>
#include <map>

#include <nlohmann/json.hpp>

#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

using Json = nlohmann::json;

/// Inserts `text` behind the first `after`.
void insert_behind(std::string& in, const std::string& after, const std::string& text) {
  const std::size_t at = in.find(after);
  if (at == std::string::npos) throw std::runtime_error("three_puma.yaml has no " + after);
  in.insert(at + after.size(), text);
}

class Ros2Failover : public testing::Test {
 protected:
  Ros2Failover() {
    std::filesystem::create_directory_symlink(std::string(HECATON_LIVE_CELLS) + "/urdf", folder_.path() / "urdf");
    std::ifstream file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    insert_behind(text, "name: three_puma", "_failover");
    insert_behind(text, "network:\n",
                  "  interface: 127.0.0.1\nhosts: {alpha: 127.0.0.1, beta: 127.0.0.2}\nworld: {host: alpha}\n");
    const std::size_t domain = text.find("  domain: 42\n");
    text.erase(domain, std::string("  domain: 42\n").size());
    insert_behind(text, "supervision:\n", "  host: alpha\n  failover_timeout: 100ms\n");
    for (const char* arm : {"north", "west", "east"}) {
      insert_behind(text, std::string("  - name: ") + arm + "\n", "    host: alpha\n    standby_host: beta\n");
    }
    text += "\nros2: {domain: " + std::to_string(ros_domain_.number()) +
            ", namespace: /cell, control: true, host: alpha}\n";
    cell_file_ = folder_.write("cell.yaml", text);
    for (const char* host : {"alpha", "beta"}) {
      agents_.push_back(std::make_unique<Process>(std::vector<std::string>{kBin + "hecaton-agent", cell_file_, "--host",
                                                                           host, "--domain", domain_, "--clean",
                                                                           "--log-dir", folder_.path(host)}));
    }
  }
  ~Ros2Failover() override {
    for (const auto& agent : agents_) agent->signal(SIGINT);
    for (const auto& agent : agents_) EXPECT_EQ(agent->wait(), 0) << agent->err();
  }

  /// What `hecaton status` says.
  [[nodiscard]] Json status() const {
    Process asked({kBin + "hecaton", "--cell", cell_file_, "--domain", domain_, "-o", "json", "status"});
    if (asked.wait() != 0) throw std::runtime_error(asked.err());
    return Json::parse(asked.out());
  }
  static Json arm_of(const Json& status, const std::string& name) {
    for (const Json& arm : status.at("arms")) {
      if (arm.at("name") == name) return arm;
    }
    throw std::runtime_error("the status has no arm " + name);
  }
  static pid_t pid_of(const Json& status, const std::string& name) {
    for (const Json& node : status.at("nodes")) {
      if (node.at("node") == name) return node.at("pid").get<pid_t>();
    }
    throw std::runtime_error("the status has no node " + name);
  }
  /// The status, once each arm runs and has a standby.
  [[nodiscard]] Json await_standbys() const {
    const auto until = std::chrono::steady_clock::now() + kLong;
    while (true) {
      const Json seen = status();
      const auto ready = [](const Json& arm) {
        return arm.at("standby") != "" && arm.at("state").at("mode") == "running";
      };
      const Json& arms = seen.at("arms");
      if (arms.size() == 3 && std::all_of(arms.begin(), arms.end(), ready)) return seen;
      if (std::chrono::steady_clock::now() > until) throw std::runtime_error("no standbys: " + seen.dump());
    }
  }

  inline static const std::string kBin = std::string(HECATON_BIN_DIR) + "/";
  TemporaryFolder folder_;
  std::string cell_file_;
  FreeDomain cell_domain_;
  FreeDomain ros_domain_;
  std::string domain_ = std::to_string(cell_domain_.number());
  std::vector<std::unique_ptr<Process>> agents_;
};

TEST_F(Ros2Failover, EndsTheTrajectoryOfAKilledPlannerOnceAndAsPlanned) {
  constexpr double kDuration = 8.0;
  const std::vector<double> step{0.4, 0.2, -0.2, 0.3, 0.0, 0.2};
  ConnectOptions options;
  options.cell_file = cell_file_;
  options.domain = cell_domain_.number();
  const Cell cell = Cell::connect(options, kLong);
  RosPeer peer(ros_domain_.number());
  const std::vector<std::string> arms{"north", "west", "east"};
  std::map<std::string, std::unique_ptr<ActionClient>> clients;
  std::map<std::string, std::vector<double>> ends;
  std::map<std::string, ActionClient::Id> ids;
  std::map<std::string, rtps::SampleIdentity> asked;
  for (const std::string& arm : arms) {
    clients[arm] = std::make_unique<ActionClient>(peer, arm);
    ASSERT_TRUE(clients[arm]->wait_available()) << arm;
  }
  const Json before = await_standbys();
  JointStates states(peer, "rt/cell/west/joint_states", {true, false, 1000});
  // Every answer on the topic, to all clients.
  PeerReader<control_msgs::action::FollowJointTrajectory_GetResult_ResponsePubSubType> answers(
      peer, "rr/cell/west/follow_joint_trajectory/_action/get_resultReply");
  ASSERT_TRUE(states.wait_matched() && answers.wait_matched());
  for (const std::string& arm : arms) {
    const auto start = cell.arm(arm).state(kLong).q;
    ends[arm] = start;
    for (std::size_t j = 0; j < start.size(); ++j) ends[arm][j] += step[j];
    const auto id = clients[arm]->send(clients[arm]->smooth(start, ends[arm], kDuration));
    ASSERT_TRUE(id) << arm;
    ids[arm] = *id;
    asked[arm] = clients[arm]->ask_result(*id);
  }
  const auto comes_to = [&](std::int32_t seconds) {
    return clients["west"]->feedback.next([&](const auto& message) {
      return message.goal_id().uuid() == ids["west"] && message.feedback().desired().time_from_start().sec() >= seconds;
    });
  };
  ASSERT_TRUE(comes_to(3));
  const std::string killed = arm_of(before, "west").at("planner");
  ASSERT_EQ(kill(pid_of(before, killed), SIGKILL), 0);
  ASSERT_TRUE(comes_to(5)) << "the standby follows it";
  const std::string successor = arm_of(status(), "west").at("planner");
  EXPECT_NE(successor, killed);
  for (const std::string& arm : arms) {
    const auto result = clients[arm]->await_result(asked[arm]);
    ASSERT_TRUE(result) << arm;
    EXPECT_EQ(result->status(), kSucceeded) << arm << ": " << result->result().error_string();
    EXPECT_EQ(result->result().error_code(), 0) << arm;
    const auto q = cell.arm(arm).state(kLong).q;
    for (std::size_t j = 0; j < q.size(); ++j) EXPECT_NEAR(q[j], ends[arm][j], 0.02) << arm << " " << j;
  }
  // A second request is answered after all answers to the first.
  const auto again = clients["west"]->ask_result(ids["west"]);
  int first_answers = 0;
  ASSERT_TRUE(answers.await([&](const auto& sample) {
    if (sample.related == asked["west"]) ++first_answers;
    return sample.related == again;
  }));
  EXPECT_EQ(first_answers, 1);
  // It goes on from where it is: no joint goes back.
  std::vector<double> farthest;
  for (const auto& sample : states.take()) {
    const std::vector<double>& q = sample.value.position();
    if (farthest.empty()) farthest = q;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double way = (step[j] < 0.0 ? -1.0 : 1.0) * (q[j] - farthest[j]);
      EXPECT_GT(way, -0.03) << "joint " << j;
      if (way > 0.0) farthest[j] = q[j];
    }
  }
  EXPECT_FALSE(farthest.empty());
  const CellStatus status = cell.status(kLong);
  ASSERT_TRUE(status.contacts);
  EXPECT_EQ(status.contacts->contacts, 0U);
}

}  // namespace
}  // namespace hecaton::test
