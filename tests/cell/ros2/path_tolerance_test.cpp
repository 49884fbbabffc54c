/// Trajectories with and without path tolerances, and something that comes into their way while an arm follows them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <future>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

using Trajectory = control_msgs::action::FollowJointTrajectory_Goal;
using Markers = PeerReader<visualization_msgs::msg::MarkerArrayPubSubType>;

constexpr std::chrono::seconds kLongest{150};  // of a trajectory that goes around or waits

/// A trajectory on a straight line of the joint space, and how an arm follows it.
class Following {
 public:
  /// `tolerance`: of each joint; 0: none.
  Following(RosPeer& peer, const std::string& arm, std::vector<double> from, std::vector<double> to, double seconds,
            std::vector<double> tolerance)
      : arm_(arm),
        from_(std::move(from)),
        to_(std::move(to)),
        tolerance_(std::move(tolerance)),
        client_(peer, arm),
        states_(peer, "rt/cell/" + arm + "/joint_states"),
        goal_(client_.smooth(from_, to_, seconds)) {
    for (std::size_t j = 0; j < tolerance_.size(); ++j) {
      auto& entry = goal_.path_tolerance().emplace_back();
      entry.name(arm + "_joint" + std::to_string(j + 1));
      entry.position(tolerance_[j]);
    }
  }

  [[nodiscard]] Trajectory& goal() { return goal_; }

  /// Sends the trajectory.
  void begin() {
    ASSERT_TRUE(client_.wait_available()) << arm_;
    const auto seconds_of = [](const auto& time) { return std::chrono::seconds(time.sec()); };
    const auto tolerance = seconds_of(goal_.goal_time_tolerance());
    if (tolerance > 0s) {
      const auto duration = seconds_of(goal_.trajectory().points().back().time_from_start());
      ends_ = std::chrono::steady_clock::now() + duration + tolerance;
    }
    const auto id = client_.send(goal_);
    ASSERT_TRUE(id) << arm_;
    id_ = *id;
    result_ = std::async(std::launch::async,
                         [this, asked = client_.ask_result(*id)] { return client_.await_result(asked, kLongest); });
  }
  /// Waits until the arm is `share` of the way to the end.
  void wait_for_share(double share) {
    while (!over() && share_ < share) look();
    ASSERT_GE(share_, share) << arm_;
  }
  /// Watches the arm for some time, or until the trajectory ends.
  void watch(std::chrono::seconds time) {
    const auto until = std::chrono::steady_clock::now() + time;
    while (!over() && std::chrono::steady_clock::now() < until) look();
  }
  [[nodiscard]] bool over() const { return result_.wait_for(0s) == std::future_status::ready; }
  /// Watches the arm until the trajectory ends.
  Result end() {
    while (!over()) look();
    auto result = result_.get();
    EXPECT_TRUE(result) << arm_ << ": no result";
    return result.value_or(Result{});
  }

  /// The largest distance from the path so far, of the joint with the largest share of its tolerance.
  [[nodiscard]] double largest_share() const { return largest_share_; }
  [[nodiscard]] double worst_at() const { return worst_at_; }                  ///< share of the way, of the largest one
  [[nodiscard]] double largest_distance() const { return largest_distance_; }  ///< [rad]
  [[nodiscard]] double distance() const { return distance_; }                  ///< of the last measured position [rad]
  [[nodiscard]] double share() const { return share_; }                        ///< of the way, as last measured

 private:
  void look() {
    const auto state = states_.next([](const auto& message) { return !message.position().empty(); }, 5s);
    ASSERT_TRUE(state) << arm_ << ": no joint states";
    const std::vector<double>& q = state->position();
    constexpr int kParts = 1000;
    double least_share = std::numeric_limits<double>::infinity();
    double least_distance = least_share;
    for (int i = 0; i <= kParts; ++i) {
      double of_tolerance = 0.0;
      double distance = 0.0;
      for (std::size_t j = 0; j < q.size(); ++j) {
        const double off = std::abs(from_[j] + (to_[j] - from_[j]) * i / kParts - q[j]);
        distance = std::max(distance, off);
        if (j < tolerance_.size() && tolerance_[j] > 0.0) of_tolerance = std::max(of_tolerance, off / tolerance_[j]);
      }
      least_share = std::min(least_share, of_tolerance);
      if (distance >= least_distance) continue;
      least_distance = distance;
      share_ = static_cast<double>(i) / kParts;
    }
    distance_ = least_distance;
    // From its end on the arm gives way to others, and the result comes later.
    constexpr double kThere = 0.01;
    arrived_ = arrived_ || (share_ == 1.0 && least_distance < kThere);
    if (arrived_ || std::chrono::steady_clock::now() > ends_) return;
    if (least_share > largest_share_) worst_at_ = share_;
    largest_distance_ = std::max(largest_distance_, least_distance);
    largest_share_ = std::max(largest_share_, least_share);
  }

  std::string arm_;
  std::vector<double> from_;
  std::vector<double> to_;
  std::vector<double> tolerance_;
  ActionClient client_;
  JointStates states_;
  Trajectory goal_;
  ActionClient::Id id_{};
  std::future<std::optional<Result>> result_;
  double largest_share_ = 0.0;
  double largest_distance_ = 0.0;
  double distance_ = 0.0;
  double share_ = 0.0;
  double worst_at_ = 0.0;
  bool arrived_ = false;
  std::chrono::steady_clock::time_point ends_ = std::chrono::steady_clock::time_point::max();  ///< not before
};

/// The arm `north` sweeps its first joint, far from the other arms, and a stone appears on the way of its tool.
class StoneOnTheWay : public Ros2Cell {
 protected:
  static constexpr double kBegin = 1.3;  // of joint 1 [rad]
  static constexpr double kEnd = 2.6;
  static constexpr double kDuration = 6.0;  // [s]
  static constexpr double kLarge = 0.12;    // stone that stops the arm on its path [m]

  void SetUp() override {
    static_cast<void>(home(cell_, "north"));
    ASSERT_TRUE(
        cell_.arm("north").go_to({kBegin, -1.0, 2.4, 0.0, 0.6, 0.0}).wait(kLong));  // the tool 0.7 m from the axis
    from_ = cell_.arm("north").state(kLong).q;
    contacts_ = cell_.status(kLong).contacts->contacts;
  }
  void TearDown() override {
    for (const ObstacleState& obstacle : cell_.world().obstacles(kLong)) {
      if (obstacle.name == "stone") remove_stone();
    }
    EXPECT_TRUE(cell_.arm("north").go_to("home").wait(kLong));
    EXPECT_EQ(cell_.status(kLong).contacts->contacts, contacts_);
    Ros2Cell::TearDown();
  }
  [[nodiscard]] Following follow(std::vector<double> tolerance) {
    std::vector<double> to = from_;
    to[0] = kEnd;
    return {*peer_, "north", from_, to, kDuration, std::move(tolerance)};
  }
  /// Where the tool is at a position of joint 1 on the way.
  [[nodiscard]] Pose tool_at(double joint1) const {
    std::vector<double> q = from_;
    q[0] = joint1;
    return Ros2Cell::tool_at("north", q);
  }
  void add_stone(double radius = 0.04) {
    cell_.world().add("stone", Sphere{radius}, tool_at(0.5 * (kBegin + kEnd)), Static{}, kLong);
  }
  void remove_stone() { cell_.world().remove("stone", kLong); }

  Cell cell_ = connect();
  std::vector<double> from_;
  std::uint64_t contacts_ = 0;
};

TEST_F(StoneOnTheWay, GoesAroundWithinThePathTolerance) {
  Following following = follow({0.4, 0.4, 0.4, 0.6, 0.6, 0.6});
  following.begin();
  following.wait_for_share(0.05);
  add_stone(kLarge);
  const std::string words = "goes around within the path tolerance";
  EXPECT_TRUE(cell_.wait_until([&] { return cell_.arm("north").goal()->recovery_action.starts_with(words); }, kLong));
  const Result result = following.end();
  EXPECT_EQ(result.status(), kSucceeded) << result.result().error_string();
  EXPECT_EQ(result.result().error_code(), 0);
  EXPECT_LE(following.largest_share(), 1.0);
  EXPECT_GT(following.largest_distance(), 0.1) << "it has left the path";
  std::cout << "around: " << following.largest_share() << " of the tolerance, " << following.largest_distance()
            << " rad\n";
}

TEST_F(StoneOnTheWay, WaitsWhenThePathToleranceIsTooSmallUntilTheTimeTolerance) {
  Following following = follow(std::vector<double>(6, 0.03));
  following.goal().goal_time_tolerance().sec(6);
  Markers plans(*peer_, "rt/cell/hecaton/plans");
  Markers pairs(*peer_, "rt/cell/hecaton/binding_pairs");
  ASSERT_TRUE(plans.wait_matched() && pairs.wait_matched());
  following.begin();
  following.wait_for_share(0.05);
  add_stone();
  const auto line_of_north = [](const auto& message) {
    return std::any_of(message.markers().begin(), message.markers().end(),
                       [](const auto& marker) { return marker.ns() == "north" && marker.points().size() > 1; });
  };
  EXPECT_TRUE(plans.next(line_of_north)) << "the way of the tool";
  EXPECT_TRUE(pairs.next(line_of_north)) << "from the arm to the stone";
  const Result result = following.end();
  EXPECT_EQ(result.status(), kAborted);
  EXPECT_EQ(result.result().error_code(), -5);
  const std::string& why = result.result().error_string();
  EXPECT_NE(why.find("north/"), std::string::npos) << why;
  EXPECT_NE(why.find(" m from stone"), std::string::npos) << why;
  EXPECT_LE(following.largest_share(), 1.0);
  EXPECT_LT(following.share(), 0.5) << "it stands before the stone";
  std::cout << why << '\n';
}

TEST_F(StoneOnTheWay, WaitsWithoutATimeToleranceAndGoesOn) {
  Following following = follow(std::vector<double>(6, 0.03));
  following.begin();
  following.wait_for_share(0.05);
  add_stone();
  following.watch(10s);
  ASSERT_FALSE(following.over());
  EXPECT_LT(following.share(), 0.5) << "it stands before the stone";
  remove_stone();
  const Result result = following.end();
  EXPECT_EQ(result.status(), kSucceeded) << result.result().error_string();
  EXPECT_LE(following.largest_share(), 1.0);
}

TEST_F(StoneOnTheWay, LeavesAndRejoinsWhenTheToleranceIsErased) {
  Following following = follow(std::vector<double>(6, -1.0));
  following.begin();
  following.wait_for_share(0.05);
  add_stone(kLarge);
  following.wait_for_share(0.95);
  const double at_end = following.distance();
  const Result result = following.end();
  EXPECT_EQ(result.status(), kSucceeded) << result.result().error_string();
  EXPECT_GT(following.largest_distance(), 0.1) << "it has left the path";
  EXPECT_LT(at_end, 0.06) << "it follows again before the end";
  std::cout << "aside: " << following.largest_distance() << " rad\n";
}

// The arm turns its last joint alone, and a ball comes from above to where its tool is, and 50 mm deeper. The arm must
// flee farther than 0.02 rad in each joint could take it.
TEST_F(StoneOnTheWay, EndsTheTrajectoryWhenSomethingPushesTheArmOutOfThePathTolerance) {
  std::vector<double> to = from_;
  to[5] += 0.5;
  Following following(*peer_, "north", from_, to, 60.0, std::vector<double>(6, 0.02));
  following.begin();
  following.wait_for_share(0.01);
  drop_stone(cell_, "stone", "north", from_);
  const Result result = following.end();
  EXPECT_EQ(result.status(), kAborted);
  EXPECT_EQ(result.result().error_code(), -4);
  const std::string& why = result.result().error_string();
  EXPECT_NE(why.find("joint"), std::string::npos) << why;
  std::cout << why << '\n';
}

/// The cell without its moving obstacles: on a machine that gives the drivers no time, those reach arms that stand.
class StillRos2Cell : public Ros2Cell {
 protected:
  static void SetUpTestSuite() {
    const std::string text = three_puma();
    const std::size_t moving = text.find("obstacles:\n") + std::string("obstacles:\n").size();
    start_cell(text.substr(0, moving) + text.substr(text.find("  - name: post")));
  }
};

/// Number of random sets of trajectories; HECATON_SEEDS=20 for the long run.
int number_of_seeds() {
  const char* wanted = std::getenv("HECATON_SEEDS");
  return wanted == nullptr ? 1 : std::atoi(wanted);
}

/// What kept the arm until the end of its time: a pair of bodies near each other, or the arm that goes first. On a
/// machine that stands still for seconds, it may be a silent driver.
bool names_a_cause(const std::string& why) {
  constexpr std::array kCauses{" m from ", " has the right of way", " sends no states"};
  return std::any_of(kCauses.begin(), kCauses.end(),
                     [&](const char* cause) { return why.find(cause) != std::string::npos; });
}

// All three go to the centre of their common zone, where one has room, then back and to its edge. Each is bound to its
// path. One that has arrived gives way to the next.
TEST_F(StillRos2Cell, EndsConflictingTrajectoriesWithPathTolerancesAsDocumented) {
  const std::vector<double> centre{-0.22, -0.95, 3.0, 0.0, 0.7, 0.0};
  const std::vector<double> edge{-0.3, -1.25, 3.5, 0.0, 0.89, 0.0};
  const std::vector<double> rest{0.0, -1.9, 2.6, 0.0, 0.6, 0.0};
  const std::vector<std::string> arms{"north", "west", "east"};
  const Cell cell = connect();
  ASSERT_EQ(cell.world().obstacles(kLong).size(), 1U);
  const auto all_rest = [&] {
    return std::all_of(arms.begin(), arms.end(), [&](const std::string& arm) {
      const auto qd = cell.arm(arm).state(kLong).qd;
      return std::all_of(qd.begin(), qd.end(), [](double speed) { return std::abs(speed) < 1e-3; });
    });
  };
  std::map<std::string, int> outcomes;
  double worst = 0.0;
  for (int seed = 1; seed <= number_of_seeds(); ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto draw = [&](double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); };
    for (const std::string& arm : arms) static_cast<void>(home(cell, arm));
    for (const auto& around : {centre, rest, edge}) {
      // Arms without a goal give way to each other where two have arrived near each other. Held, they stay at the first
      // points of their trajectories.
      static_cast<void>(cell.hold(kLong));
      ASSERT_TRUE(cell.wait_until(all_rest, kLong));
      std::vector<std::unique_ptr<Following>> all;
      for (const std::string& arm : arms) {
        std::vector<double> to = around;
        std::vector<double> tolerance(6);
        for (double& q : to) q += draw(-0.1, 0.1);
        for (double& entry : tolerance) entry = draw(0.05, 0.4);
        all.push_back(
            std::make_unique<Following>(*peer_, arm, cell.arm(arm).state(kLong).q, to, draw(2.0, 4.0), tolerance));
        all.back()->goal().goal_time_tolerance().sec(10);
      }
      for (auto& following : all) following->begin();
      static_cast<void>(cell.resume(kLong));
      std::vector<std::future<Result>> ends;
      for (auto& following : all) {
        ends.push_back(std::async(std::launch::async, [&following] { return following->end(); }));
      }
      for (std::size_t i = 0; i < all.size(); ++i) {
        const Result result = ends[i].get();
        const int code = result.result().error_code();
        const std::string& why = result.result().error_string();
        ++outcomes[std::to_string(code)];
        if (code != 0) std::cout << "seed " << seed << ", " << arms[i] << ": " << code << ' ' << why << '\n';
        EXPECT_TRUE(code == 0 || code == -4 || code == -5) << arms[i] << ": " << code << ' ' << why;
        EXPECT_EQ(result.status(), code == 0 ? kSucceeded : kAborted) << arms[i] << ": " << why;
        EXPECT_TRUE(code != -5 || names_a_cause(why)) << why;
        if (code == -4) continue;
        EXPECT_LE(all[i]->largest_share(), 1.0)
            << "seed " << seed << ", " << arms[i] << " at " << all[i]->worst_at() << " of the way, code " << code;
        worst = std::max(worst, all[i]->largest_share());
      }
    }
  }
  for (const std::string& arm : arms) static_cast<void>(home(cell, arm));
  for (const auto& [code, count] : outcomes) std::cout << "code " << code << ": " << count << '\n';
  std::cout << "largest deviation " << worst << " of the tolerance\n";
  EXPECT_GT(outcomes["0"], 0);
  EXPECT_GT(worst, 0.1) << "they were in each other's way";
  EXPECT_EQ(cell.status(kLong).contacts->contacts, 0U);
}

}  // namespace
}  // namespace hecaton::test
