/// Trajectories at random on three arms that share a zone, while a planner is killed: every goal has the outcome that
/// docs/reference/ros2.md names, and nothing touches.

#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <thread>
#include <utility>

#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

constexpr double kTimeTolerance = 30.0;  // of a trajectory that may have to wait [s]
constexpr Seconds kSlack{0.1};           // between clocks of two programs that count in periods

/// Number of trajectories; HECATON_TRAJECTORIES=300 for the long run.
int number_of_trajectories() {
  const char* wanted = std::getenv("HECATON_TRAJECTORIES");
  return wanted == nullptr ? 36 : std::atoi(wanted);
}

/// Sends an arm one trajectory after the other and judges how each ends.
class Customer {
 public:
  using DropStone =
      std::function<void(const Cell&, const std::string& name, const std::string& arm, const std::vector<double>& q)>;

  /// `drop_stone`: Ros2Cell::drop_stone.
  Customer(RosPeer& peer, Cell cell, std::string arm, unsigned seed, DropStone drop_stone)
      : cell_(std::move(cell)),
        arm_(std::move(arm)),
        client_(peer, arm_),
        seed_(seed),
        random_(seed),
        drop_stone_(std::move(drop_stone)) {}

  [[nodiscard]] bool wait_available() { return client_.wait_available(); }

  void run(int trajectories) {
    for (int i = 0; i < trajectories; ++i) {
      constexpr int kKinds = 8;
      switch (i % kKinds) {
        case 0:
          invalid(i / kKinds + static_cast<int>(seed_));
          break;
        case 1:
          cancelled(towards(i + 1, 2.0));
          break;
        case 2: {
          const auto first = send(towards(i, 2.0));
          wait(0.1, 1.0);
          const auto second = send(towards(i + 1));
          ++i;  // two trajectories
          expect_end("replaced", first, kAborted, -1);
          expect("later", second);
          break;
        }
        case 4:
          expect("with a path tolerance", send(with_path_tolerance(towards(i))));
          break;
        case 6:
          outside_goal_tolerance();
          break;
        case 7:
          pushed();
          break;
        default:
          expect("plain", send(towards(i)));
      }
    }
    expect("home", send(smooth_to(kHome)));
  }

  [[nodiscard]] int sent() const { return sent_; }
  [[nodiscard]] const std::map<std::string, int>& outcomes() const { return outcomes_; }
  /// Valid trajectories that were not cancelled and had no path tolerance, and how many of these succeeded.
  [[nodiscard]] int plain() const { return plain_; }
  [[nodiscard]] int succeeded() const { return succeeded_; }

 private:
  using Goal = control_msgs::action::FollowJointTrajectory_Goal;
  struct Sent {
    ActionClient::Id id{};
    rtps::SampleIdentity asked;
    bool accepted = false;
    std::chrono::steady_clock::time_point at;  ///< just before it was sent
    Seconds duration{0.0};
    bool has_path_tolerance = false;
  };
  static inline const std::vector<double> kHome{0.0, -1.9, 2.6, 0.0, 0.6, 0.0};
  static inline const std::vector<double> kReady{-0.3, -1.25, 3.5, 0.0, 0.89, 0.0};
  /// Away from all others, the tool 0.7 m from the axis of the base.
  static inline const std::vector<double> kAside{2.4, -1.0, 2.4, 0.0, 0.6, 0.0};

  double draw(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  /// Orders come at any time.
  void wait(double from, double to) { std::this_thread::sleep_for(std::chrono::duration<double>(draw(from, to))); }

  Goal smooth_to(const std::vector<double>& to, double shortest = 0.5) {
    const std::vector<double> q = cell_.arm(arm_).state(kLong).q;
    double farthest = 0.0;
    for (std::size_t j = 0; j < q.size(); ++j) farthest = std::max(farthest, std::abs(to[j] - q[j]));
    const double fastest = draw(0.4, 1.2);  // [rad/s]
    Goal goal = client_.smooth(q, to, std::max(shortest, 0.5 * M_PI * farthest / fastest));
    // The arm may be moving: the first point is where it is then.
    goal.trajectory().points().erase(goal.trajectory().points().begin());
    goal.goal_time_tolerance().sec(static_cast<std::int32_t>(kTimeTolerance));
    return goal;
  }
  /// Into the shared zone, and back.
  Goal towards(int i, double shortest = 0.5) {
    std::vector<double> to = i % 2 == 0 ? kReady : kHome;
    for (double& q : to) q += draw(-0.15, 0.15);
    return smooth_to(to, shortest);
  }
  Goal with_path_tolerance(Goal goal) {
    goal.path_tolerance().resize(1);
    goal.path_tolerance()[0].name("joint1");
    goal.path_tolerance()[0].position(0.1);
    return goal;
  }

  Sent send(const Goal& goal) {
    ++sent_;
    Sent sent;
    sent.at = std::chrono::steady_clock::now();
    const auto& end = goal.trajectory().points().back().time_from_start();
    sent.duration = std::chrono::seconds(end.sec()) + std::chrono::nanoseconds(end.nanosec());
    sent.has_path_tolerance = !goal.path_tolerance().empty();
    const auto id = client_.send(goal);
    EXPECT_TRUE(id) << arm_;
    if (!id) return sent;
    sent.id = *id;
    sent.asked = client_.ask_result(*id);
    sent.accepted = true;
    return sent;
  }

  void expect_end(const std::string& kind, const Sent& sent, int status, int code) {
    const auto result = end_of(kind, sent);
    if (!result) return;
    EXPECT_EQ(result->status(), status) << arm_ << ", " << kind << ": " << result->result().error_string();
    EXPECT_EQ(result->result().error_code(), code) << arm_ << ", " << kind << ": " << result->result().error_string();
    EXPECT_TRUE(code == 0 || !result->result().error_string().empty()) << arm_ << ", " << kind;
  }
  /// A valid trajectory: at its goal, or too late, or pushed off the path that it must keep, with a reason.
  void expect(const std::string& kind, const Sent& sent) {
    const auto result = end_of(kind, sent);
    if (!result) return;
    judge(kind, sent, *result);
    if (sent.has_path_tolerance) return;
    ++plain_;
    succeeded_ += result->status() == kSucceeded ? 1 : 0;
  }
  void judge(const std::string& kind, const Sent& sent, const Result& result) {
    const int code = result.result().error_code();
    const std::string& why = result.result().error_string();
    const std::string what = arm_ + ", " + kind + ": " + std::to_string(code) + ' ' + why;
    EXPECT_EQ(result.status(), code == 0 ? kSucceeded : kAborted) << what;
    EXPECT_EQ(why.empty(), code == 0) << what;
    switch (code) {
      case 0:
        break;
      case -1:
        EXPECT_TRUE(is_rejected(result)) << what;
        break;
      case -4:
        EXPECT_TRUE(sent.has_path_tolerance) << what;
        break;
      case -5:
        // These goals have a tolerance of time and none of position.
        EXPECT_NE(why.find("s after its time"), std::string::npos) << what;
        EXPECT_GT(since(sent), sent.duration + Seconds(kTimeTolerance) - kSlack) << what;
        break;
      default:
        ADD_FAILURE() << what;
    }
  }
  /// Where a trajectory ends may be in the way of the ball.
  static bool is_rejected(const Result& result) {
    return result.result().error_code() == -1 &&
           result.result().error_string().starts_with("the planner rejects the trajectory");
  }
  static Seconds since(const Sent& sent) { return std::chrono::steady_clock::now() - sent.at; }

  /// Most are cancelled on their way, some at their end.
  void cancelled(const Goal& goal) {
    const std::string kind = "cancelled";
    const Sent sent = send(goal);
    if (!sent.accepted) return;
    wait(0.0, std::min(1.2 * sent.duration.count(), 3.0));
    const int code = client_.cancel(sent.id);
    const Seconds answered = since(sent);
    if (code == 0) return expect_end(kind, sent, kCanceled, 0);
    EXPECT_EQ(code, 3) << arm_ << ": the trajectory has ended before";
    const auto result = end_of(kind, sent);
    if (!result) return;
    judge(kind, sent, *result);
    EXPECT_TRUE(is_rejected(*result) || answered > sent.duration - kSlack)
        << arm_ << ": not cancelled " << answered.count() << " s after the start of a trajectory of "
        << sent.duration.count() << " s";
  }
  std::optional<Result> end_of(const std::string& kind, const Sent& sent) {
    if (!sent.accepted) return std::nullopt;
    auto result = client_.await_result(sent.asked);
    EXPECT_TRUE(result) << arm_ << ", " << kind << ": no result";
    if (!result) return result;
    ++outcomes_[kind + ": status " + std::to_string(result->status()) + ", code " +
                std::to_string(result->result().error_code())];
    return result;
  }

  /// Ends farther from its goal than the least tolerance allows: no drive is that exact.
  void outside_goal_tolerance() {
    Goal goal = smooth_to(kHome);
    goal.goal_tolerance().resize(1);
    goal.goal_tolerance()[0].name("joint2");
    goal.goal_tolerance()[0].position(std::numeric_limits<double>::min());
    goal.goal_time_tolerance().sec(1);
    expect_end("outside its goal tolerance", send(goal), kAborted, -5);
  }
  /// The arm turns its last joint alone, and a ball comes from above to where its tool is, and 50 mm deeper. The arm
  /// must flee farther than the path tolerance.
  void pushed() {
    expect("aside", send(smooth_to(kAside)));
    const std::vector<double> q = cell_.arm(arm_).state(kLong).q;
    for (std::size_t j = 0; j < q.size(); ++j) {
      if (std::abs(q[j] - kAside[j]) > 0.1) return;  // something was in its way
    }
    std::vector<double> to = q;
    to[5] += 0.5;
    Goal goal = client_.smooth(q, to, 60.0);
    for (std::size_t j = 0; j < q.size(); ++j) {
      auto& entry = goal.path_tolerance().emplace_back();
      entry.name("joint" + std::to_string(j + 1));
      entry.position(0.02);
    }
    const Sent sent = send(goal);
    const std::string stone = "stone-" + arm_;
    drop_stone_(cell_, stone, arm_, q);
    expect_end("pushed off its path", sent, kAborted, -4);
    EXPECT_NO_THROW(cell_.world().remove(stone, kLong));
  }
  /// One of each error in turn.
  void invalid(int number) {
    Goal goal = towards(number);
    auto& points = goal.trajectory().points();
    switch (number % 6) {
      case 0:
        goal.trajectory().joint_names()[0] = "elbow";
        return expect_end("unknown joint", send(goal), kAborted, -2);
      case 1:
        goal.trajectory().header().stamp().sec(1000);
        return expect_end("old stamp", send(goal), kAborted, -3);
      case 2:
        std::swap(points.front(), points.back());
        return expect_end("times that fall", send(goal), kAborted, -1);
      case 3:
        points.back().positions()[1] = 9.0;
        return expect_end("outside the limits", send(goal), kAborted, -1);
      case 4:
        points.front().time_from_start().sec(0);
        points.front().time_from_start().nanosec(0);
        points.front().positions()[0] += 0.3;
        return expect_end("begins elsewhere", send(goal), kAborted, -1);
      default: {
        // Slower than its time allows: the speed override stretches it.
        EXPECT_NO_THROW(cell_.arm(arm_).set_speed(0.05, kLong));
        std::vector<double> to = cell_.arm(arm_).state(kLong).q;
        to[0] += to[0] > 0.0 ? -0.4 : 0.4;
        goal = smooth_to(to);
        goal.goal_time_tolerance().sec(0);
        goal.goal_time_tolerance().nanosec(100'000'000);
        const Sent sent = send(goal);
        expect_end("late", sent, kAborted, -5);
        EXPECT_NO_THROW(cell_.arm(arm_).set_speed(1.0, kLong));
      }
    }
  }

  Cell cell_;
  std::string arm_;
  ActionClient client_;
  unsigned seed_;
  std::mt19937 random_;
  DropStone drop_stone_;
  int sent_ = 0;
  int plain_ = 0;
  int succeeded_ = 0;
  std::map<std::string, int> outcomes_;
};

TEST_F(Ros2Cell, EndsManyTrajectoriesAsDocumentedAndTouchesNothing) {
  const Cell cell = connect();
  const std::vector<std::string> arms{"north", "west", "east"};
  std::vector<std::unique_ptr<Customer>> customers;
  for (std::size_t i = 0; i < arms.size(); ++i) {
    static_cast<void>(home(cell, arms[i]));
    customers.push_back(std::make_unique<Customer>(*peer_, cell, arms[i], static_cast<unsigned>(2 * i), drop_stone));
    ASSERT_TRUE(customers.back()->wait_available()) << arms[i];
  }
  const int each = number_of_trajectories() / static_cast<int>(arms.size());
  std::vector<std::thread> threads;
  for (const auto& customer : customers) threads.emplace_back([&customer, each] { customer->run(each); });
  // While an arm moves in the zone.
  const auto moves = [&] {
    const auto goal = cell.arm("west").goal();
    return goal && goal->trajectory_time && *goal->trajectory_time > Seconds(0.5) && !is_final(goal->state);
  };
  EXPECT_TRUE(cell.wait_until(moves, kLong));
  ASSERT_EQ(kill(planner_of("west"), SIGKILL), 0);
  for (std::thread& thread : threads) thread.join();
  std::map<std::string, int> all;
  int ended = 0;
  int sent = 0;
  int plain = 0;
  int succeeded = 0;
  for (const auto& customer : customers) {
    sent += customer->sent();
    plain += customer->plain();
    succeeded += customer->succeeded();
    for (const auto& [outcome, count] : customer->outcomes()) {
      all[outcome] += count;
      ended += count;
    }
  }
  for (const auto& [outcome, count] : all) std::cout << outcome << ": " << count << '\n';
  EXPECT_EQ(ended, sent) << "each has a result";
  EXPECT_GT(all["pushed off its path: status 6, code -4"], 0);
  EXPECT_GT(all["cancelled: status 5, code 0"], 0) << "no cancellation came while a trajectory was running";
  EXPECT_GT(2 * succeeded, plain) << succeeded << " of " << plain << " valid trajectories succeeded";
  const CellStatus status = cell.status(kLong);
  ASSERT_TRUE(status.contacts);
  EXPECT_EQ(status.contacts->contacts, 0U);
  if (status.contacts->smallest) std::cout << "smallest separation " << status.contacts->smallest->distance << " m\n";
}

}  // namespace
}  // namespace hecaton::test
