#include "services/view/goal_preview.hpp"

#include <thread>

#include <gtest/gtest.h>

#include "planner/goal_check.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/kinematics.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/overlaps.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using planner::JointVector;

const std::string kThreePuma = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";

/// Three arms at their homes, without obstacles.
class PreviewTest : public testing::Test {
 protected:
  PreviewTest() {
    for (const planner::PlannedArm& planned : cell_.arms) scene_.q.emplace_back(planned.arm.home());
    put({});
  }
  [[nodiscard]] world::Pose tool(int arm, const JointVector& q) const {
    planner::Kinematics kinematics;
    planner::forward_kinematics(*cell_.arms[arm].arm.model, cell_.arms[arm].arm.X_WB, q, kinematics);
    return kinematics.X_WT;
  }
  [[nodiscard]] static PreviewQuestion question(const world::Pose& X_WT, const JointVector& start = {}) {
    PreviewQuestion asked;
    asked.page = 3;
    asked.id = -7;
    asked.X_WT = X_WT;
    asked.start = start;
    return asked;
  }
  /// A cube of 0.2 m for each of the names, described at those places.
  void put(const std::map<std::string, Eigen::Vector3d>& crates) {
    auto obstacles = std::make_shared<CellState::Obstacles>();
    for (const auto& [name, p_W] : crates) {
      world::Obstacle crate;
      crate.name = name;
      crate.shapes.push_back({world::Box{Eigen::Vector3d::Constant(0.1)}, world::Pose::Identity()});
      crate.X_WO.translation() = p_W;
      obstacles->emplace(name, messages::to_message(crate));
    }
    scene_.obstacles = obstacles;
    ++scene_.edition;
  }
  [[nodiscard]] PreviewAnswer ask(const world::Pose& X_WT, const JointVector& start = {}) {
    return solver_.answer(question(X_WT, start), scene_);
  }

  planner::Cell cell_ = config::load_cell_file(kThreePuma).cell;
  PreviewScene scene_;
  PreviewSolver solver_{cell_};
  const JointVector home_ = cell_.arms[0].arm.home();
};

TEST_F(PreviewTest, GivesNearJointPositionsForANearPose) {
  world::Pose X_WT = tool(0, home_);
  X_WT.translation().z() -= 0.05;
  const PreviewAnswer answer = ask(X_WT);
  EXPECT_EQ(answer.verdict, PreviewVerdict::kFree) << answer.text;
  EXPECT_TRUE(answer.accepted);
  EXPECT_EQ(answer.page, 3U);
  EXPECT_EQ(answer.id, -7);
  EXPECT_LT((answer.q - home_).cwiseAbs().maxCoeff(), 0.3);
  EXPECT_LT((tool(0, answer.q).translation() - X_WT.translation()).norm(), 1.01e-4);
  EXPECT_LT(Eigen::AngleAxisd(tool(0, answer.q).linear().transpose() * X_WT.linear()).angle(), 1.01e-3);
}

TEST_F(PreviewTest, AcceptsOnlyWhatAPlannerAccepts) {
  put({{"a", {0.3, 0.3, 0.9}}, {"b", {0.0, 0.0, 0.3}}});
  planner::CellGeometry geometry(planner::arms_of(cell_), 0);
  std::vector<world::Obstacle> obstacles;
  for (const auto& [name, message] : *scene_.obstacles) obstacles.push_back(*messages::from_message(message));
  geometry.set_obstacles(obstacles);
  std::vector<world::ObstacleState> states(2);
  for (int i = 0; i < 2; ++i) states[i].X_WO = obstacles[i].X_WO;

  std::mt19937_64 random(5);
  std::map<PreviewVerdict, int> seen;
  for (int i = 0; i < 300; ++i) {
    const world::Pose X_WT = tool(0, planner::random_configuration(cell_.arms[0].arm.limits, random));
    const PreviewAnswer answer = ask(X_WT, home_);
    ++seen[answer.verdict];
    if (!answer.accepted) {
      EXPECT_FALSE(answer.text.empty());
      continue;
    }
    EXPECT_FALSE(planner::reject_goal(geometry, answer.q, states)) << i;
    const world::Pose reached = tool(0, answer.q);
    EXPECT_LT((reached.translation() - X_WT.translation()).norm(), 1.01e-4) << i;
    EXPECT_LT(Eigen::AngleAxisd(reached.linear().transpose() * X_WT.linear()).angle(), 1.01e-3) << i;
  }
  EXPECT_GT(seen[PreviewVerdict::kFree], 50);
  EXPECT_GT(seen[PreviewVerdict::kCollision], 10);
  EXPECT_GT(seen[PreviewVerdict::kNear], 0);
}

TEST_F(PreviewTest, ShowsTheNearestPoseOutOfReach) {
  world::Pose X_WT = tool(0, home_);
  X_WT.translation().z() += 5.0;
  const PreviewAnswer answer = ask(X_WT);
  EXPECT_EQ(answer.verdict, PreviewVerdict::kUnreachable);
  EXPECT_FALSE(answer.accepted);
  EXPECT_EQ(answer.text.find("out of reach: the nearest pose found is "), 0U) << answer.text;
  // It stretches upwards: of 5 m less than the length of an arm is gained.
  const double above = tool(0, answer.q).translation().z() - tool(0, home_).translation().z();
  EXPECT_GE(above, 0.0);
  EXPECT_LT(above, 1.0);
}

TEST_F(PreviewTest, NamesTheObstacleInTheWay) {
  const world::Pose X_WT = tool(0, home_);
  put({{"crate", X_WT.translation()}});
  const PreviewAnswer answer = ask(X_WT);
  EXPECT_EQ(answer.verdict, PreviewVerdict::kCollision);
  EXPECT_FALSE(answer.accepted);
  EXPECT_EQ(answer.own.substr(0, 6), "north/");
  EXPECT_EQ(answer.other, "crate");
  EXPECT_LT(answer.distance, 0.0);
  EXPECT_EQ(answer.text.find(answer.own + " and crate overlap by "), 0U) << answer.text;
}

TEST_F(PreviewTest, TakesObstaclesWhereTheyAreNow) {
  const world::Pose X_WT = tool(0, home_);
  world::Pose far = world::Pose::Identity();
  far.translation().x() = 50.0;
  put({{"crate", X_WT.translation()}});
  scene_.X_WO["crate"] = messages::to_message(far);
  EXPECT_EQ(ask(X_WT).verdict, PreviewVerdict::kFree);
  scene_.X_WO["crate"] = messages::to_message(X_WT);
  EXPECT_EQ(ask(X_WT).other, "crate");
  scene_.X_WO.clear();
  put({});
  EXPECT_EQ(ask(X_WT).verdict, PreviewVerdict::kFree) << "it was removed";
}

TEST_F(PreviewTest, SaysThatAnObstacleIsNearerThanTheArmKeeps) {
  const world::Pose X_WT = tool(0, home_);
  Eigen::Vector3d p_W = X_WT.translation();
  PreviewAnswer answer;
  // From far away towards the arm: the first that is near is no contact yet.
  for (p_W.z() += 1.0; answer.verdict != PreviewVerdict::kNear && p_W.z() > X_WT.translation().z(); p_W.z() -= 0.005) {
    put({{"crate", p_W}});
    answer = ask(X_WT);
    ASSERT_NE(answer.verdict, PreviewVerdict::kCollision);
  }
  EXPECT_EQ(answer.verdict, PreviewVerdict::kNear);
  EXPECT_TRUE(answer.accepted);
  EXPECT_GT(answer.distance, 0.0);
  EXPECT_LE(answer.distance, cell_.arms[0].parameters.damper.security_distance);
  EXPECT_GT(answer.distance, cell_.arms[0].parameters.damper.security_distance - 0.006);
}

TEST_F(PreviewTest, TellsAnArmThatIsThereFromWhatStaysThere) {
  // Two postures in which the shapes of north and west overlap, found with the checks of cell files.
  std::vector<planner::CellGeometry> geometries;
  for (int i = 0; i < 2; ++i) geometries.emplace_back(planner::arms_of(cell_), i);
  std::mt19937_64 random(2);
  JointVector north;
  JointVector west;
  for (bool found = false; !found;) {
    north = planner::random_configuration(cell_.arms[0].arm.limits, random);
    west = planner::random_configuration(cell_.arms[1].arm.limits, random);
    scene_.q[1].reset();
    const PreviewAnswer alone = ask(tool(0, north), north);
    if (alone.verdict != PreviewVerdict::kFree || !alone.q.isApprox(north)) continue;
    found = config::nearest_pair_of_arms(cell_.arms[0].arm, config::place_arm({}, geometries[0], 0, north),
                                         cell_.arms[1].arm, config::place_arm({}, geometries[1], 1, west), -0.01)
                .found;
  }
  scene_.q[1] = west;
  const PreviewAnswer answer = ask(tool(0, north), north);
  EXPECT_EQ(answer.verdict, PreviewVerdict::kOccupied);
  EXPECT_TRUE(answer.accepted) << "west may leave";
  EXPECT_EQ(answer.own.substr(0, 6), "north/");
  EXPECT_EQ(answer.other.substr(0, 5), "west/");
  EXPECT_LE(answer.distance, -0.01);
}

TEST_F(PreviewTest, KeepsArmsAboveTheFloor) {
  std::mt19937_64 random(3);
  PreviewAnswer answer;
  JointVector q;
  while (answer.other != "floor") {
    q = planner::random_configuration(cell_.arms[0].arm.limits, random);
    answer = ask(tool(0, q), q);
  }
  EXPECT_EQ(answer.verdict, PreviewVerdict::kCollision);
  EXPECT_NE(answer.text.find("below the floor"), std::string::npos) << answer.text;
  cell_.scene.floor_z = -5.0;
  EXPECT_NE(ask(tool(0, q), q).other, "floor");
}

TEST_F(PreviewTest, NeedsAStateOfTheArmToBeginWith) {
  scene_.q[0].reset();
  const PreviewAnswer answer = ask(tool(0, home_));
  EXPECT_EQ(answer.verdict, PreviewVerdict::kUnknown);
  EXPECT_FALSE(answer.accepted);
  EXPECT_EQ(answer.text, "the view has received no state of arm north");
  EXPECT_EQ(ask(tool(0, home_), home_).verdict, PreviewVerdict::kFree);
}

TEST_F(PreviewTest, SurvivesAnObstacleThatNoArmCarries) {
  world::Obstacle crate;
  crate.name = "crate";
  crate.shapes.push_back({world::Box{Eigen::Vector3d::Constant(0.1)}, world::Pose::Identity()});
  crate.attachment = world::Attachment{.arm = "nobody", .X_TO = world::Pose::Identity()};
  scene_.obstacles =
      std::make_shared<CellState::Obstacles>(CellState::Obstacles{{"crate", messages::to_message(crate)}});
  ++scene_.edition;
  EXPECT_EQ(ask(tool(0, home_)).verdict, PreviewVerdict::kUnknown);
  put({});
  EXPECT_EQ(ask(tool(0, home_)).verdict, PreviewVerdict::kFree);
}

TEST_F(PreviewTest, IsAMessageOfThePage) {
  const world::Pose X_WT = tool(0, home_);
  put({{"crate", X_WT.translation()}});
  const view::Json json = preview_json(cell_, ask(X_WT));
  EXPECT_EQ(json.at("type"), "preview");
  EXPECT_EQ(json.at("id"), -7);
  EXPECT_EQ(json.at("arm"), "north");
  EXPECT_EQ(json.at("q").size(), 6U);
  EXPECT_EQ(json.at("verdict"), "collision");
  EXPECT_FALSE(json.at("accepted"));
  EXPECT_EQ(json.at("pair").at("other"), "crate");
  put({});
  EXPECT_TRUE(preview_json(cell_, ask(X_WT)).at("pair").is_null());
}

TEST_F(PreviewTest, AnswersInAThreadThatRestsAfterwards) {
  GoalPreview preview(cell_);
  const auto began = GoalPreview::Clock::now();
  // It is not ready either while its thread has the lock for a moment.
  const auto is_ready_within = [&](GoalPreview::Clock::duration later) {
    while (!preview.ready(began + later)) {
      if (GoalPreview::Clock::now() > began + 30s) return false;
      std::this_thread::yield();
    }
    return true;
  };
  ASSERT_TRUE(is_ready_within(0s));
  preview.ask(question(tool(0, home_)), scene_);
  std::optional<PreviewAnswer> answer;
  while (!answer && GoalPreview::Clock::now() < began + 20s) {
    std::this_thread::yield();
    answer = preview.take_answer();
  }
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->verdict, PreviewVerdict::kFree);
  EXPECT_FALSE(preview.take_answer()) << "it is given once";
  EXPECT_FALSE(preview.ready(began + 1ms)) << "it rests for as long as it worked";
  EXPECT_TRUE(is_ready_within(60s));
}

}  // namespace
}  // namespace hecaton::services
