/// Inputs of ticks as messages: random values survive the wire to the last bit.
#include <bit>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "planner/local/random.hpp"
#include "services/bus/recorded_sample.hpp"
#include "services/config/cell_file.hpp"
#include "services/tick_log/cell_changes.hpp"
#include "services/tick_log/tick_reader.hpp"
#include "services/tick_log/tick_writer.hpp"

namespace hecaton::services {
namespace {

using planner::JointVector;
using planner::Random;

constexpr int kSelf = 1;
constexpr int kJoints = 6;

const planner::Cell& cell() {
  static const config::CellFile file =
      config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml");
  return file.cell;
}

void expect_same_bits(const JointVector& a, const JointVector& b) {
  ASSERT_EQ(a.size(), b.size());
  for (Eigen::Index j = 0; j < a.size(); ++j) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a[j]), std::bit_cast<std::uint64_t>(b[j])) << a[j] << " " << b[j];
  }
}

void expect_same_bits(const world::Pose& a, const world::Pose& b) {
  EXPECT_EQ(std::memcmp(a.matrix().data(), b.matrix().data(), sizeof(double) * 16), 0);
}

/// Draws inputs of periods.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  JointVector joints() {
    JointVector q(kJoints);
    for (double& value : q) value = random_.uniform(-3.0, 3.0);
    if (random_.uniform() < 0.2) q[0] = -0.0;
    if (random_.uniform() < 0.2) q[1] = 5e-324;
    return q;
  }
  world::Pose pose() {
    world::Pose pose = world::Pose::Identity();
    pose.linear() = Eigen::Quaterniond(random_.normal(), random_.normal(), random_.normal(), random_.normal())
                        .normalized()
                        .toRotationMatrix();
    for (double& value : pose.translation()) value = random_.uniform(-1.0, 1.0);
    return pose;
  }
  bool coin() { return random_.uniform() < 0.5; }

  std::shared_ptr<const planner::CoupledPlan> plan() {
    auto plan = std::make_shared<planner::CoupledPlan>();
    plan->number = static_cast<std::uint32_t>(random_.next());
    plan->arms = {0, kSelf};
    plan->points = {{joints(), joints()}, {joints(), joints()}};
    return plan;
  }
  planner::ArmObservation arm() {
    planner::ArmObservation arm;
    arm.known = coin();
    if (arm.known) arm.q = joints();
    if (arm.known) arm.qd = joints();
    arm.age = random_.uniform();
    arm.plans = coin();
    arm.foreign = coin();
    arm.has_goal = coin();
    if (arm.has_goal) arm.q_goal = joints();
    arm.priority = static_cast<std::uint32_t>(random_.next());
    if (coin()) arm.position_uncertainty = joints();
    arm.progress = {coin() ? 2 : -1, 7, -1};
    arm.speed = random_.uniform();
    return arm;
  }
  world::ObstacleState obstacle() {
    world::ObstacleState state;
    state.X_WO = pose();
    state.velocity.linear = {random_.normal(), random_.normal(), random_.normal()};
    state.velocity.angular = {0.0, -0.0, random_.normal()};
    return state;
  }
  planner::RouteAnswer route(int arms) {
    planner::RouteAnswer answer;
    answer.kind = planner::RouteAnswer::Kind::kFound;
    for (int point = 0; point < 3; ++point) {
      auto& at = answer.points.emplace_back();
      for (int arm = 0; arm < arms; ++arm) at.push_back(joints());
    }
    return answer;
  }
  std::uint64_t number() { return random_.next(); }
  double uniform() { return random_.uniform(); }

 private:
  Random random_;
};

std::vector<world::Obstacle> obstacles(Draw& draw) {
  std::vector<world::Obstacle> all(3);
  for (int i = 0; i < 3; ++i) {
    world::Obstacle& obstacle = all[static_cast<std::size_t>(i)];
    obstacle.name = "box" + std::to_string(i);
    obstacle.X_WO = draw.pose();
    obstacle.shapes.push_back({world::Box{{0.1, 0.2, 0.3}}, draw.pose()});
    obstacle.shapes.push_back({world::Capsule{0.1, 0.7}, draw.pose()});
  }
  all[2].attachment = world::Attachment{cell().arms[0].arm.name, draw.pose()};
  return all;
}

/// The wire, and the reader behind it.
class Wire {
 public:
  void pass(const msg::PlannerTick& message) {
    const auto bytes = bus::encode_recorded(message);
    ASSERT_FALSE(bytes.empty()) << "the tick keeps the rules of the wire";
    const auto decoded = bus::decode_recorded<msg::PlannerTick>(bytes);
    ASSERT_TRUE(decoded.value);
    const auto error = reader.take(*decoded.value);
    ASSERT_FALSE(error) << *error;
  }
  TickReader reader{cell(), kSelf};
};

TEST(TickLog, KeepsEachBitOfTheInputs) {
  Draw draw(5);
  TickWriter writer(cell().arms[kSelf].arm.name, kSelf, "planner/test");
  Wire wire;
  std::vector<planner::ArmObservation> arms(3);
  std::vector<world::ObstacleState> states(3);
  planner::SharedObstacles list;
  for (int period = 0; period < 300; ++period) {
    SCOPED_TRACE(period);
    planner::PeriodEvents events;
    events.missed = draw.uniform();
    events.drops_setpoint = draw.coin();
    if (period % 7 == 0)
      events.obstacles = list = std::make_shared<const std::vector<world::Obstacle>>(obstacles(draw));
    if (period % 3 == 0)
      events.goal = planner::GoalChange{period % 6 == 0 ? std::optional(draw.joints()) : std::nullopt};
    if (period % 12 == 0) {
      auto trajectory = std::make_shared<planner::TimedTrajectory>();
      trajectory->points = {{0.0, draw.joints(), draw.joints(), {}},
                            {1.0 + draw.uniform(), draw.joints(), draw.joints(), {}}};
      trajectory->path_tolerance = draw.joints().cwiseAbs();
      trajectory->path_tolerance[0] = std::numeric_limits<double>::infinity();
      events.goal->trajectory = std::move(trajectory);
      events.goal->trajectory_time = draw.uniform();
    }
    std::vector<planner::RangeScan> scans;
    events.scans = scans;
    std::optional<TickWriter::Snapshot> snapshot;
    if (period % 50 == 0) snapshot = TickWriter::Snapshot{{1, 2, 3}, "test", {}, list};
    writer.begin(period, events, snapshot);

    for (int i = 0; i < 3; ++i) {
      const auto proposal = arms[i].proposal;
      arms[i] = draw.arm();
      arms[i].proposal = period % 5 == 0 ? (draw.coin() ? draw.plan() : nullptr) : proposal;
      if (draw.coin()) states[i] = draw.obstacle();
    }
    const bool one_age = draw.coin();
    for (auto& state : states) state.age = one_age ? 0.25 : draw.uniform();
    planner::PeriodInputs inputs;
    inputs.own.state = {draw.joints(), draw.joints()};
    inputs.own.age = draw.uniform();
    inputs.own.follows = draw.coin();
    inputs.own.setpoint = draw.number() >> 3U;
    inputs.own.setpoint_age = draw.uniform();
    inputs.own.tracking_delay = draw.uniform();
    inputs.own.speed_scaling = draw.uniform();
    inputs.arms = arms;
    inputs.obstacles = states;
    inputs.hold = draw.coin();
    inputs.speed = draw.uniform();
    inputs.commands = draw.coin();
    inputs.number = draw.number() >> 3U;
    if (draw.coin()) {
      inputs.answers.rollout.emplace().manoeuvre = {planner::ManoeuvreKind::kEvade, draw.number(), draw.joints(), 1.5};
    }
    if (draw.coin()) inputs.answers.route = draw.route(1);
    if (draw.coin()) inputs.answers.coupled_plan = draw.route(2);
    planner::TickResult result;
    result.q = draw.joints();
    result.qd = draw.joints();
    const bool planned = period % 11 != 10;
    if (planned) writer.finish(inputs, result);
    wire.pass(writer.message());
    ASSERT_FALSE(testing::Test::HasFatalFailure());

    const planner::PeriodEvents& read = wire.reader.events();
    EXPECT_EQ(read.missed, events.missed);
    EXPECT_EQ(read.drops_setpoint, events.drops_setpoint);
    ASSERT_EQ(read.goal.has_value(), events.goal.has_value());
    if (read.goal) {
      ASSERT_EQ(read.goal->q_goal.has_value(), events.goal->q_goal.has_value());
      if (read.goal->q_goal) expect_same_bits(*read.goal->q_goal, *events.goal->q_goal);
      EXPECT_EQ(read.goal->trajectory_time, events.goal->trajectory_time);
      ASSERT_EQ(read.goal->trajectory != nullptr, events.goal->trajectory != nullptr);
      if (read.goal->trajectory) {
        const planner::TimedTrajectory& a = *read.goal->trajectory;
        const planner::TimedTrajectory& b = *events.goal->trajectory;
        ASSERT_EQ(a.points.size(), b.points.size());
        for (std::size_t i = 0; i < b.points.size(); ++i) {
          EXPECT_EQ(a.points[i].time, b.points[i].time);
          expect_same_bits(a.points[i].q, b.points[i].q);
          expect_same_bits(a.points[i].qd, b.points[i].qd);
          EXPECT_EQ(a.points[i].qdd.size(), 0);
        }
        expect_same_bits(a.path_tolerance, b.path_tolerance);
      }
    }
    ASSERT_EQ(read.obstacles != nullptr, events.obstacles != nullptr || snapshot.has_value());
    if (read.obstacles) {
      ASSERT_EQ(read.obstacles->size(), list->size());
      for (std::size_t i = 0; i < list->size(); ++i) {
        const world::Obstacle& a = (*read.obstacles)[i];
        const world::Obstacle& b = (*list)[i];
        EXPECT_EQ(a.name, b.name);
        expect_same_bits(a.X_WO, b.X_WO);
        for (std::size_t k = 0; k < b.shapes.size(); ++k) expect_same_bits(a.shapes[k].X_BS, b.shapes[k].X_BS);
        ASSERT_EQ(a.attachment.has_value(), b.attachment.has_value());
        if (b.attachment) expect_same_bits(a.attachment->X_TO, b.attachment->X_TO);
      }
    }
    if (!planned) continue;
    const planner::PeriodInputs& got = wire.reader.inputs();
    expect_same_bits(got.own.state.q, inputs.own.state.q);
    expect_same_bits(got.own.state.qd, inputs.own.state.qd);
    EXPECT_EQ(got.own.age, inputs.own.age);
    EXPECT_EQ(got.own.follows, inputs.own.follows);
    EXPECT_EQ(got.own.setpoint, inputs.own.setpoint);
    EXPECT_EQ(got.own.setpoint_age, inputs.own.setpoint_age);
    EXPECT_EQ(got.own.tracking_delay, inputs.own.tracking_delay);
    EXPECT_EQ(got.own.speed_scaling, inputs.own.speed_scaling);
    EXPECT_EQ(got.hold, inputs.hold);
    EXPECT_EQ(got.speed, inputs.speed);
    EXPECT_EQ(got.commands, inputs.commands);
    EXPECT_EQ(got.number, inputs.number);
    for (int i = 0; i < 3; ++i) {
      if (i == kSelf) continue;
      const planner::ArmObservation& a = got.arms[i];
      const planner::ArmObservation& b = arms[i];
      expect_same_bits(a.q, b.q);
      expect_same_bits(a.qd, b.qd);
      expect_same_bits(a.q_goal, b.q_goal);
      expect_same_bits(a.position_uncertainty, b.position_uncertainty);
      EXPECT_TRUE(a.age == b.age && a.known == b.known && a.plans == b.plans && a.foreign == b.foreign &&
                  a.has_goal == b.has_goal && a.priority == b.priority && a.progress == b.progress &&
                  a.speed == b.speed);
      ASSERT_EQ(a.proposal != nullptr, b.proposal != nullptr);
      if (!b.proposal) continue;
      EXPECT_EQ(a.proposal->number, b.proposal->number);
      EXPECT_EQ(a.proposal->arms, b.proposal->arms);
      ASSERT_EQ(a.proposal->points.size(), b.proposal->points.size());
      for (std::size_t k = 0; k < b.proposal->points.size(); ++k) {
        for (std::size_t arm = 0; arm < 2; ++arm) {
          expect_same_bits(a.proposal->points[k][arm], b.proposal->points[k][arm]);
        }
      }
    }
    ASSERT_EQ(got.obstacles.size(), states.size());
    for (std::size_t i = 0; i < states.size(); ++i) {
      expect_same_bits(got.obstacles[i].X_WO, states[i].X_WO);
      EXPECT_EQ(got.obstacles[i].velocity.linear, states[i].velocity.linear);
      EXPECT_EQ(got.obstacles[i].velocity.angular, states[i].velocity.angular);
      EXPECT_EQ(got.obstacles[i].age, states[i].age);
    }
    ASSERT_EQ(got.answers.rollout.has_value(), inputs.answers.rollout.has_value());
    if (got.answers.rollout) {
      const planner::Manoeuvre& a = got.answers.rollout->manoeuvre;
      const planner::Manoeuvre& b = inputs.answers.rollout->manoeuvre;
      EXPECT_TRUE(a.kind == b.kind && a.seed == b.seed && a.time_limit == b.time_limit);
      expect_same_bits(a.q, b.q);
    }
    for (const auto& [a, b] : {std::pair{&got.answers.route, &inputs.answers.route},
                               std::pair{&got.answers.coupled_plan, &inputs.answers.coupled_plan}}) {
      ASSERT_EQ(a->has_value(), b->has_value());
      if (!*a) continue;
      EXPECT_EQ((*a)->kind, (*b)->kind);
      ASSERT_EQ((*a)->points.size(), (*b)->points.size());
      for (std::size_t k = 0; k < (*b)->points.size(); ++k) {
        ASSERT_EQ((*a)->points[k].size(), (*b)->points[k].size());
        for (std::size_t arm = 0; arm < (*b)->points[k].size(); ++arm) {
          expect_same_bits((*a)->points[k][arm], (*b)->points[k][arm]);
        }
      }
    }
  }
}

TEST(TickLog, RefusesSizesThatDoNotFitTheCell) {
  const auto refused = [](const std::function<void(msg::PlannerTick&)>& change) {
    Draw draw(1);
    TickWriter writer(cell().arms[kSelf].arm.name, kSelf, "planner/test");
    const auto list = std::make_shared<const std::vector<world::Obstacle>>(obstacles(draw));
    writer.begin(0, {}, TickWriter::Snapshot{{}, "test", {}, list});
    std::vector<planner::ArmObservation> arms(3);
    std::vector<world::ObstacleState> states(3);
    planner::PeriodInputs inputs;
    inputs.own.state = {draw.joints(), draw.joints()};
    inputs.arms = arms;
    inputs.obstacles = states;
    planner::TickResult result;
    writer.finish(inputs, result);
    msg::PlannerTick message = writer.message();
    TickReader reader(cell(), kSelf);
    EXPECT_FALSE(reader.take(message));
    EXPECT_TRUE(reader.planner(message));
    change(message);
    return reader.take(message).has_value() || !reader.planner(message);
  };
  EXPECT_FALSE(refused([](msg::PlannerTick&) {}));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.own().q().pop_back(); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.arms().pop_back(); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.arms()[0].arm(kSelf); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.arms()[0].arm(200); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.arms()[0].proposer(3); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.obstacle_states().pop_back(); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.obstacle_states()[0].obstacle(3); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.obstacle_frames().pop_back(); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.obstacle_ages().clear(); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.obstacles()[2].attached_to("nobody"); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.options().pop_back(); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) { tick.memory({1, 2, 3}); }));
  EXPECT_TRUE(refused([](msg::PlannerTick& tick) {
    tick.proposals().emplace_back().arm(0);
    tick.proposals()[0].arms({0, 1});
    tick.proposals()[0].points(2);
  }));
}

TEST(TickLog, KeepsTheChangesOfASimulation) {
  const CellChanges changes{"local", 3, true, 0.7};
  const auto read = CellChanges::from_json(changes.json());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->json(), changes.json());
  EXPECT_FALSE(CellChanges::from_json("{}"));
  EXPECT_FALSE(CellChanges::from_json("[1, 2"));
  planner::Cell changed = cell();
  EXPECT_FALSE(changes.apply(changed));
  EXPECT_EQ(changed.arms[0].arm.limits.velocity[0], 0.7);
  EXPECT_EQ(changed.arms[0].parameters.rollout.candidates, 3);
  EXPECT_TRUE((CellChanges{.method = "none"}.apply(changed)));
}

}  // namespace
}  // namespace hecaton::services
