// The self-collision pairs that the filter keeps, with exact distances.

#include "planner/collision/model_filter.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include "planner/collision/exact_distance.hpp"
#include "planner/model/collision_filter.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/rate_bounds.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::joint;

double distance(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
  return shape_distance(a, X_WA, b, X_WB).distance;
}

double pair_distance(const RobotModel& model, const std::pair<int, int>& pair, const JointVector& q) {
  Kinematics kinematics;
  forward_kinematics(model, Pose::Identity(), q, kinematics);
  const LinkGeometry& a = model.geometry[pair.first];
  const LinkGeometry& b = model.geometry[pair.second];
  return distance(a.shape, kinematics.X_WL[a.link] * a.X_LS, b.shape, kinematics.X_WL[b.link] * b.X_LS);
}

using Names = std::set<std::pair<std::string, std::string>>;

Names names(const RobotModel& model) {
  Names result;
  for (const auto& [a, b] : model.self_pairs) {
    result.emplace(model.links[model.geometry[a].link].name, model.links[model.geometry[b].link].name);
  }
  return result;
}

TEST(ModelFilter, KeepsOnlyPairsOfThePumaWithItsBase) {
  // Smallest distances over 4,000 random configurations, computed independently with the same dimensions. From the base
  // to forearm 16 mm, wrist roll 10 mm, wrist bend −10 mm, flange −31 mm. All other pairs: 51 mm and more.
  const Names expected{
      {"base_link", "forearm"}, {"base_link", "wrist_roll"}, {"base_link", "wrist_bend"}, {"base_link", "flange"}};
  const auto six = load_arm_model(test::kPuma);
  EXPECT_EQ(names(*six), expected);
  EXPECT_TRUE(test::has_note(*six, "provably never come near each other: "));
  EXPECT_EQ(names(*load_arm_model(test::kPuma5)), expected);
}

TEST(ModelFilter, DropsOnlyPairsThatStayApart) {
  const auto all = load_urdf(test::kPuma);
  const auto filtered = load_arm_model(test::kPuma);
  const std::set<std::pair<int, int>> kept(filtered->self_pairs.begin(), filtered->self_pairs.end());
  std::mt19937_64 random(4);
  for (int i = 0; i < 5000; ++i) {
    const JointVector q = test::random_joints(all->limits, random);
    for (const auto& pair : all->self_pairs) {
      if (!kept.contains(pair)) {
        ASSERT_GT(pair_distance(*all, pair, q), FilterOptions{}.apart);
      }
    }
  }
}

TEST(ModelFilter, ReadyPoseIsClearOfSelfCollision) {
  for (const std::string& urdf : {test::kPuma, test::kPuma5}) {
    const auto model = load_urdf(urdf);
    JointVector ready = JointVector::Zero(model->joints());
    ready.head(5) << -0.3, -1.25, 3.5, 0, 0.89;
    for (const auto& pair : model->self_pairs) EXPECT_GE(pair_distance(*model, pair, ready), 0.05);
  }
}

/// base –j1– a –j2– b –j3– c about parallel axes, one metre apart.
std::string planar(const std::string& extra_on_c, const std::string& limit) {
  const std::string inside = R"(<origin xyz="1 0 0"/><axis xyz="0 0 1"/>)" + limit;
  return test::robot(ball_link("base") + ball_link("a") + ball_link("b") + "<link name=\"c\"><collision>" + extra_on_c +
                     "</collision></link>" + joint("j1", "revolute", "base", "a", inside) +
                     joint("j2", "revolute", "a", "b", inside) + joint("j3", "revolute", "b", "c", inside));
}

TEST(ModelFilter, DropsPairsThatAlwaysTouch) {
  // A ball of 3 m on the tip encloses link a in every configuration, because a is at most 2 m away. It also encloses
  // the base, at most 3 m away: 3 − 0.05 < 3. Link b is a neighbour.
  const test::TemporaryFolder folder;
  const auto path = folder.write("r.urdf", planar(R"(<geometry><sphere radius="3"/></geometry>)", test::kLimit));
  EXPECT_EQ(load_urdf(path)->self_pairs.size(), 3U);  // base–b, base–c, a–c
  const auto model = load_arm_model(path);
  EXPECT_TRUE(test::has_note(*model, "touch in nearly every posture, or are nearer than 5 mm: "));
  for (const auto& pair : names(*model)) EXPECT_NE(pair.second, "c");
}

// A hull around the fork of a wrist encloses the flange in it. Their distance tells nothing, and it would block the
// arm.
TEST(ModelFilter, DropsPairsThatNoPosturePartsVisibly) {
  const auto kept = [](const std::string& gap) {
    const test::TemporaryFolder folder;
    const std::string limit = R"(<axis xyz="0 0 1"/><limit lower="-3.1" upper="3.1" effort="1" velocity="1"/>)";
    const auto path = folder.write(
        "r.urdf", test::robot(ball_link("base", "0.01 0 0") + ball_link("a") + ball_link("b", gap + " 0 0") +
                              joint("j1", "revolute", "base", "a", limit) + joint("j2", "revolute", "a", "b", limit)));
    return load_arm_model(path)->self_pairs.size();
  };
  EXPECT_EQ(kept("0.094"), 0U) << "from 16 mm of overlap to 4 mm apart";
  EXPECT_EQ(kept("0.098"), 1U) << "from 12 mm of overlap to 8 mm apart";
}

TEST(ModelFilter, KeepsPairsThatSometimesTouch) {
  const test::TemporaryFolder folder;
  const std::string limit = R"(<limit lower="-3.1" upper="3.1" effort="1" velocity="1"/>)";
  const auto model =
      load_arm_model(folder.write("r.urdf", planar(R"(<geometry><sphere radius="0.1"/></geometry>)", limit)));
  EXPECT_EQ(names(*model), (Names{{"base", "b"}, {"base", "c"}, {"a", "c"}}));
}

/// base –j1– a –j2– b –j3– c. Link a is a ball at j2, link c a ball 45 mm from j3, which is 70 mm from j2.
std::string wrist(const std::string& j3_axis, double limit) {
  const std::string range = "<limit lower=\"" + std::to_string(-limit) + "\" upper=\"" + std::to_string(limit) +
                            R"(" effort="1" velocity="1"/>)";
  return test::robot(
      ball_link("base") + ball_link("a") + "<link name=\"b\"/>" + ball_link("c", "0.045 0 0") +
      joint("j1", "revolute", "base", "a", R"(<origin xyz="0 0 1"/><axis xyz="0 0 1"/>)" + range) +
      joint("j2", "revolute", "a", "b", R"(<axis xyz="1 0 0"/>)" + range) +
      joint("j3", "revolute", "b", "c", R"(<origin xyz="0.07 0 0"/><axis xyz=")" + j3_axis + "\"/>" + range));
}

std::shared_ptr<const RobotModel> load_wrist(const std::string& j3_axis, double limit) {
  const test::TemporaryFolder folder;
  UrdfOptions options;
  options.allow_bare_links = true;
  return load_arm_model(folder.write("r.urdf", wrist(j3_axis, limit)), options);
}

TEST(ClosePairs, DropsPairsThatNoPosturePartsOrBringsTogether) {
  // Both axes pass through both balls: a and c are always 115 − 100 = 15 mm apart.
  const auto constant = load_wrist("1 0 0", 2.0);
  EXPECT_TRUE(names(*constant).empty());
  EXPECT_TRUE(test::has_note(*constant, "provably never touch: a–c"));
  // About y the centres are √(70² + 45² + 2·70·45 cos θ) mm apart: 104 mm at 0.9 rad.
  const auto narrow = load_wrist("0 1 0", 0.9);
  EXPECT_TRUE(names(*narrow).empty());
  EXPECT_TRUE(test::has_note(*narrow, "provably never touch: a–c"));
}

// A base and an upper arm that swings past it: with the second joint down they are near, and no joint parts them.
TEST(ModelFilter, DropsPairsOfTwoJointsThatProvablyNeverTouch) {
  const auto load = [](const std::string& length) {
    const test::TemporaryFolder folder;
    const std::string turns = R"(<limit lower="-6.2" upper="6.2" effort="1" velocity="1"/>)";
    return load_arm_model(folder.write(
        "r.urdf",
        test::robot(ball_link("base") + ball_link("a") + ball_link("b", length + " 0 0") +
                    joint("j1", "revolute", "base", "a", R"(<origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>)" + turns) +
                    joint("j2", "revolute", "a", "b", R"(<axis xyz="0 1 0"/>)" + turns))));
  };
  const auto near = load("0.095");  // 5 mm to 195 mm apart
  EXPECT_TRUE(names(*near).empty());
  EXPECT_TRUE(test::has_note(*near, "have two joints between them and provably never touch: base–b"));
  EXPECT_EQ(names(*load("0.105")), (Names{{"base", "b"}})) << "5 mm of overlap";
}

TEST(ClosePairs, KeepsAndListsThoseThatCanTouch) {
  const auto model = load_wrist("0 1 0", 2.0);  // 87 mm at 2 rad: 13 mm deep
  EXPECT_EQ(names(*model), (Names{{"a", "c"}}));
  ASSERT_EQ(model->close_pairs.size(), 1U);
  EXPECT_EQ(std::pair(model->close_pairs[0].first, model->close_pairs[0].second), model->self_pairs[0]);
  EXPECT_NEAR(model->close_pairs[0].widest, 0.015, 1e-4);  // stretched
  EXPECT_TRUE(test::has_note(*model, "(proven), therefore they keep smaller distances than other links: a–c"));
}

TEST(ClosePairs, ListsNoPairOfThePuma) {
  EXPECT_TRUE(load_arm_model(test::kPuma)->close_pairs.empty());
}

/// base –lift– upper –elbow– fore, with balls at the axis of `lift` and, 0.3 m behind the elbow, at the end of fore,
/// which is `aside` [m] of the plane of upper. Folded by 2 acos(1/6) = 161° or more, the balls overlap.
std::shared_ptr<const RobotModel> load_folding(const std::string& elbow_type, const std::string& aside,
                                               const std::string& elbow_limit) {
  const test::TemporaryFolder folder;
  UrdfOptions options;
  options.allow_bare_links = true;
  const std::string turns = R"(<limit lower="-6.28" upper="6.28" effort="1" velocity="1"/>)";
  return load_arm_model(
      folder.write("r.urdf",
                   test::robot(ball_link("base") + "<link name=\"upper\"/>" + ball_link("fore", "0.3 0 " + aside) +
                               joint("lift", "revolute", "base", "upper", R"(<axis xyz="0 0 1"/>)" + turns) +
                               joint("elbow", elbow_type, "upper", "fore",
                                     R"(<origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>)" + elbow_limit))),
      options);
}

TEST(BlockedTurns, EndAJointWhereLinksOverlapInEveryPosture) {
  constexpr double kBlocked = 165.0 * std::numbers::pi / 180.0;  // the first of the positions in steps of 15°
  const auto two_turns =
      load_folding("revolute", "0", R"(<limit lower="-6.28" upper="6.28" effort="1" velocity="1"/>)");
  EXPECT_NEAR(two_turns->limits.lower[1], -kBlocked, 1e-9);
  EXPECT_NEAR(two_turns->limits.upper[1], kBlocked, 1e-9);
  EXPECT_EQ(two_turns->limits.upper[0], 6.28) << "nothing blocks it";
  EXPECT_TRUE(test::has_note(*two_turns, "no motion passes there: elbow -165° to 165°"));
  const auto endless = load_folding("continuous", "0", R"(<limit effort="1" velocity="1"/>)");
  EXPECT_NEAR(endless->limits.lower[1], -kBlocked, 1e-9);
  EXPECT_NEAR(endless->limits.upper[1], kBlocked, 1e-9);
}

TEST(BlockedTurns, KeepJointsThatCanTurnOn) {
  const auto aside = load_folding("revolute", "0.2", R"(<limit lower="-6.28" upper="6.28" effort="1" velocity="1"/>)");
  EXPECT_EQ(aside->limits.lower[1], -6.28);
  EXPECT_EQ(aside->limits.upper[1], 6.28);
  const auto endless = load_folding("continuous", "0.2", R"(<limit effort="1" velocity="1"/>)");
  EXPECT_TRUE(std::isinf(endless->limits.upper[1]));
  // One turn has no other turn.
  const auto one_turn = load_folding("revolute", "0", R"(<limit lower="-3.1" upper="3.1" effort="1" velocity="1"/>)");
  EXPECT_EQ(one_turn->limits.upper[1], 3.1);
}

TEST(SeparationProof, BoundsTheLargestDistance) {
  const auto model = load_wrist("0 1 0", 2.0);
  const auto [a, c] = model->self_pairs.at(0);
  EXPECT_TRUE(proven_within(*model, a, c, distance, 0.016, 20000));
  EXPECT_FALSE(proven_within(*model, a, c, distance, 0.014, 20000));
  EXPECT_FALSE(proven_within(*model, a, c, distance, 0.016, 1));  // too few evaluations to tell
}

TEST(SeparationProof, IsTightOnAPlanarArm) {
  // Balls of 5 cm at joints one metre apart. With θ = q1 the base is at (0, 0), a at (1, 0), b at (1 + cos θ, sin θ).
  // The distance of base and b is √(2 + 2 cos θ). It is smallest at |θ| = 2: 2 cos 1 = 1.0806, minus two radii 0.9806.
  const auto model = test::load_text(planar(R"(<geometry><sphere radius="0.05"/></geometry>)", test::kLimit));
  int base = -1;
  int b = -1;
  for (int i = 0; i < static_cast<int>(model->geometry.size()); ++i) {
    if (model->links[model->geometry[i].link].name == "base") base = i;
    if (model->links[model->geometry[i].link].name == "b") b = i;
  }
  EXPECT_TRUE(proven_apart(*model, base, b, distance, 0.97, 2000));
  EXPECT_TRUE(proven_apart(*model, b, base, distance, 0.97, 2000));
  EXPECT_FALSE(proven_apart(*model, base, b, distance, 0.99, 100000));
  EXPECT_FALSE(proven_apart(*model, base, b, distance, 0.97, 2));  // too few evaluations to tell
}

/// Arms with random geometry, skew axes and prismatic joints. Every third one has a follower.
class RandomArms {
 public:
  std::shared_ptr<const RobotModel> next() {
    const char* kShapes[] = {R"(<sphere radius="0.06"/>)", R"(<box size="0.1 0.2 0.15"/>)",
                             R"(<cylinder radius="0.05" length="0.3"/>)"};
    const char* kTypes[] = {"revolute", "prismatic", "continuous", "revolute"};
    const bool follows = drawn_++ % 3 == 0;
    std::string urdf;
    for (int i = 0; i < 5; ++i) {
      const std::string name = "l" + std::to_string(i);
      urdf += "<link name=\"" + name + "\"><collision><origin xyz=\"" + triple(0.2) + "\" rpy=\"" + triple(2.0) +
              "\"/><geometry>" + kShapes[random_() % 3] + "</geometry></collision></link>";
      if (i == 0) continue;
      urdf += joint("j" + std::to_string(i), kTypes[random_() % 4], "l" + std::to_string(i - 1), name,
                    "<origin xyz=\"" + triple(0.5) + "\" rpy=\"" + triple(2.0) + "\"/><axis xyz=\"" + triple(1.0) +
                        R"("/><limit lower="-0.5" upper="0.4" effort="1" velocity="1"/>)" +
                        (i == 3 && follows ? R"(<mimic joint="j1" multiplier="-1.5"/>)" : ""));
    }
    return test::load_text(test::robot(urdf));
  }
  std::mt19937_64& random() { return random_; }

 private:
  std::string triple(double scale) {
    const auto number = [&] { return std::to_string(scale * uniform_(random_)); };
    const std::string x = number();
    const std::string y = number();
    return x + " " + y + " " + number();
  }

  std::mt19937_64 random_{12};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
  int drawn_ = 0;
};

TEST(RateBounds, AreNeverExceeded) {
  RandomArms arms;
  int followers = 0;
  double tightest = 0.0;
  for (int trial = 0; trial < 60; ++trial) {
    const auto model = arms.next();
    followers += model->has_followers ? 1 : 0;
    for (const auto& pair : model->self_pairs) {
      const auto part = [&](int i) {
        const LinkGeometry& geometry = model->geometry[i];
        return link_part(geometry.link, geometry.shape, geometry.X_LS);
      };
      const RateBounds bounds(*model, part(pair.first), part(pair.second));
      EXPECT_EQ(RateBounds(*model, part(pair.second), part(pair.first)).rates(), bounds.rates());
      for (int i = 0; i < 100; ++i) {
        const JointVector from = test::random_joints(model->limits, arms.random());
        JointVector to = test::random_joints(model->limits, arms.random());
        if (i % 2 == 0) to = from + 0.01 * (to - from);
        const double change = std::abs(pair_distance(*model, pair, to) - pair_distance(*model, pair, from));
        const double bound = bounds.rates().dot((to - from).cwiseAbs());
        ASSERT_LE(change, bound + 3e-6) << "from " << from.transpose() << " to " << to.transpose();
        if (bound > 1e-3) tightest = std::max(tightest, change / bound);
      }
    }
  }
  EXPECT_GE(followers, 20);
  EXPECT_GT(tightest, 0.8);
}

TEST(SeparationProof, IsNeverRefutedByRandomSearch) {
  RandomArms arms;
  int proven = 0;
  int refuted = 0;
  int followers = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const auto model = arms.next();
    followers += model->has_followers ? 1 : 0;
    for (const auto& pair : model->self_pairs) {
      if (!proven_apart(*model, pair.first, pair.second, distance, 0.02, 500)) {
        ++refuted;
        continue;
      }
      ++proven;
      for (int i = 0; i < 300; ++i) {
        ASSERT_GT(pair_distance(*model, pair, test::random_joints(model->limits, arms.random())), 0.02);
      }
    }
  }
  EXPECT_GT(proven, 20);
  EXPECT_GT(refuted, 20);
  EXPECT_GE(followers, 20);
}

}  // namespace
}  // namespace hecaton::planner
