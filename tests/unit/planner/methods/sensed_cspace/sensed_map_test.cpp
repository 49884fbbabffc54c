#include "planner/methods/sensed_cspace/sensed_map.hpp"

#include <set>

#include <gtest/gtest.h>

#include "planner/local/random.hpp"
#include "planner/methods/sensed_cspace/cspace_search.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner::cspace {
namespace {

std::shared_ptr<const RobotModel> robot(const std::string& name) {
  return load_urdf(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/" + name + ".urdf");
}

JointVector random_joints(Random& random, const JointLimits& limits) {
  JointVector q(limits.lower.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = random.uniform(limits.lower[j], limits.upper[j]);
  return q;
}

Eigen::Vector3d random_point(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

TEST(ArmPlanes, MatchThePapersArms) {
  const ArmPlanes planar(*robot("planar_2r"));
  EXPECT_FALSE(planar.spatial());
  EXPECT_NEAR(planar.arm().length1, 0.5, 1e-12);
  EXPECT_NEAR(planar.arm().length2, 0.5, 1e-12);
  EXPECT_NEAR(planar.arm().width1, 0.025, 1e-9);
  EXPECT_NEAR(planar.arm().width2, 0.025, 1e-9);

  const ArmPlanes puma(*robot("puma560_3dof"));
  EXPECT_TRUE(puma.spatial());
  EXPECT_NEAR(puma.arm().length1, 0.4318, 1e-9);                        // a₂
  EXPECT_NEAR(puma.arm().length2, std::hypot(0.4318, 0.0203), 1e-9);    // d₄ and a₃
  EXPECT_NEAR(puma.slab(0).high - puma.slab(0).low, 2.0 * 0.08, 1e-9);  // the upper arm's radius
}

TEST(ArmPlanes, RejectArmsOfAnotherStructure) {
  EXPECT_EQ(ArmPlanes::why_not(*robot("puma560")), "it has 6 joints, not 2 or 3");
  EXPECT_EQ(ArmPlanes::why_not(*robot("planar_2r")), std::nullopt);
}

// The tool, placed in the plane at θ₀, is where two links of these lengths at θ₁ and θ₁ + θ₂ end.
TEST(ArmPlanes, AgreeWithForwardKinematics) {
  Random random(11);
  for (const char* name : {"planar_2r", "puma560_3dof"}) {
    const auto model = robot(name);
    const ArmPlanes planes(*model);
    for (int i = 0; i < 200; ++i) {
      const JointVector q = random_joints(random, model->limits);
      Kinematics kinematics;
      forward_kinematics(*model, Pose::Identity(), q, kinematics);
      const Angles t = planes.angles(q);
      const PlacedPoint tool = planes.place(kinematics.X_WT.translation(), {std::cos(t[0]), std::sin(t[0])});
      const PlanarArm& arm = planes.arm();
      EXPECT_NEAR(tool.in_plane.x, arm.length1 * std::cos(t[1]) + arm.length2 * std::cos(t[1] + t[2]), 1e-9) << name;
      EXPECT_NEAR(tool.in_plane.y, arm.length1 * std::sin(t[1]) + arm.length2 * std::sin(t[1] + t[2]), 1e-9) << name;
      EXPECT_LT((planes.joints(t) - q).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

struct DistanceFrom {
  Eigen::Vector3d p_S;

  double operator()(const world::Sphere& sphere) const { return p_S.norm() - sphere.radius; }
  double operator()(const world::Cylinder& cylinder) const {
    const double aside = std::hypot(p_S.x(), p_S.y()) - cylinder.radius;
    const double beyond = std::abs(p_S.z()) - cylinder.half_length;
    return aside > 0.0 && beyond > 0.0 ? std::hypot(aside, beyond) : std::max(aside, beyond);
  }
  double operator()(const world::Capsule& capsule) const {
    const double on_axis = std::clamp(p_S.z(), -capsule.half_length, capsule.half_length);
    return (p_S - on_axis * Eigen::Vector3d::UnitZ()).norm() - capsule.radius;
  }
  template <typename Other>
  double operator()(const Other&) const {
    ADD_FAILURE() << "another shape";
    return 0.0;
  }
};

/// Between a point and the moving links' shapes.
double distance_to_links(const RobotModel& model, const Kinematics& kinematics, const Eigen::Vector3d& p_B) {
  double least = 1e300;
  for (const LinkGeometry& geometry : model.geometry) {
    if (axes_before(model, geometry.link) < model.joints() - 1) continue;
    const Pose X_BS = kinematics.X_WL[geometry.link] * geometry.X_LS;
    least = std::min(least, std::visit(DistanceFrom{X_BS.inverse() * p_B}, geometry.shape));
  }
  return least;
}

// In a cell that is not blocked the arm is clear of everything that was seen, by the margin, wherever in it it is.
TEST(SensedMap, FreeCellsKeepTheMargin) {
  Random random(5);
  for (const char* name : {"planar_2r", "puma560_3dof"}) {
    const auto model = robot(name);
    const ArmPlanes planes(*model);
    const SensedParameters parameters{.cells = 120, .margin = 0.03};
    int free = 0;
    int near = 0;
    for (int scene = 0; scene < 40; ++scene) {
      SensedMap map(planes, model->limits, parameters);
      std::vector<Eigen::Vector3d> points;
      for (int i = 0; i < 6; ++i) {
        points.push_back(random_point(random, 1.1));
        if (!planes.spatial()) points.back().z() = 0.0;
        // Two in one small cube.
        points.push_back(points.back() + Eigen::Vector3d(0.002, -0.002, 0.0));
      }
      for (const Eigen::Vector3d& p_B : points) (void)map.add(p_B);
      for (int i = 0; i < 500; ++i) {
        const JointVector q = random_joints(random, model->limits);
        if (map.blocked(map.cell_at(q))) continue;
        ++free;
        Kinematics kinematics;
        forward_kinematics(*model, Pose::Identity(), q, kinematics);
        for (const Eigen::Vector3d& p_B : points) {
          const double distance = distance_to_links(*model, kinematics, p_B);
          near += distance < 0.15 ? 1 : 0;
          ASSERT_GE(distance, parameters.margin) << name << ", q = " << q.transpose() << ", p = " << p_B.transpose();
        }
      }
    }
    EXPECT_GT(free, 5000) << name;
    EXPECT_GT(near, 500) << name << ": otherwise the test shows nothing";
  }
}

// A limit a hair within the next cell: to arrive in that one would be a matter of rounding, and an arm that cannot goes
// from search to search.
TEST(SensedMap, CellsCutByALimitCountOrMergeWithTheNext) {
  const auto model = robot("planar_2r");
  const ArmPlanes planes(*model);
  constexpr int kCells = 120;
  const double pitch = AngleGrid{kCells}.pitch();
  const SensedParameters parameters{.cells = kCells, .margin = 0.03};
  Random random(21);
  int near = 0;
  for (const double into : {0.001, 0.05, 0.12, 0.13, 0.4, 0.6, 0.99}) {  // of the outermost cells
    JointLimits limits = model->limits;
    limits.lower.setConstant(-(20.5 + into) * pitch);
    limits.upper.setConstant((20.5 + into) * pitch);
    SensedMap map(planes, limits, parameters);
    for (int angle = 1; angle < 3; ++angle) EXPECT_EQ(map.size()[angle], into < 0.125 ? 41 : 43) << into;
    for (const Cell3& cell : {Cell3{0, 0, 0}, Cell3{0, map.size()[1] - 1, map.size()[2] - 1}}) {
      const JointVector inside = map.centre(cell).cwiseMax(limits.lower).cwiseMin(limits.upper);
      for (const double off : {-0.1, 0.1}) {
        EXPECT_EQ(map.cell_at(inside + JointVector::Constant(2, off * pitch)), cell) << into;
      }
    }
    for (int i = 0; i < 4; ++i) (void)map.add({random.uniform(-1.1, 1.1), random.uniform(-1.1, 1.1), 0.0});
    for (int i = 0; i < 500; ++i) {
      JointVector q = random_joints(random, limits);
      q[i % 2] = i % 4 < 2 ? limits.lower[i % 2] : limits.upper[i % 2];
      if (map.blocked(map.cell_at(q))) continue;
      Kinematics kinematics;
      forward_kinematics(*model, Pose::Identity(), q, kinematics);
      for (const Eigen::Vector3d& p_B : map.points()) {
        const double distance = distance_to_links(*model, kinematics, p_B);
        near += distance < 0.15 ? 1 : 0;
        ASSERT_GE(distance, parameters.margin) << into << ", q = " << q.transpose();
      }
    }
  }
  EXPECT_GT(near, 200) << "otherwise the test shows nothing";
}

/// The numbers of blocked cells.
std::set<int> blocked_cells(const SensedMap& map) {
  std::set<int> blocked;
  for (int cell = 0; cell < map.size()[0] * map.size()[1] * map.size()[2]; ++cell) {
    if (map.blocked(map.cell(cell))) blocked.insert(cell);
  }
  return blocked;
}

TEST(SensedMap, PublishedMapperGroupsNeighbours) {
  const auto model = robot("planar_2r");
  const ArmPlanes planes(*model);
  const SensedParameters parameters{.cells = 120, .margin = 0.03, .mapper = Mapper::kPublished};
  const auto mapped = [&](const std::vector<Eigen::Vector3d>& points, bool together) {
    SensedMap map(planes, model->limits, parameters);
    for (const Eigen::Vector3d& p_B : points) {
      EXPECT_TRUE(map.note(p_B));
      if (!together) {
        EXPECT_TRUE(map.map_noted());
      }
    }
    EXPECT_EQ(map.map_noted(), together);
    return blocked_cells(map);
  };
  const std::vector<Eigen::Vector3d> apart = {{0.7, 0.0, 0.0}, {-0.7, 0.0, 0.0}};
  EXPECT_EQ(mapped(apart, true), mapped(apart, false));
  // An edge of 0.4 m: five critical points stand for 9.
  std::vector<Eigen::Vector3d> edge;
  for (int i = -4; i <= 4; ++i) edge.emplace_back(0.6, 0.05 * i, 0.0);
  EXPECT_NE(mapped(edge, true), mapped(edge, false));
}

TEST(SensedMap, StraightPathEndsAtABlockedCell) {
  const auto model = robot("planar_2r");
  SensedMap map(ArmPlanes(*model), model->limits, {.cells = 360});
  const JointVector left = Eigen::Vector2d(-1.0, 0.0);
  const JointVector right = Eigen::Vector2d(1.0, 0.0);
  EXPECT_TRUE(map.straight_path_free(left, right));
  EXPECT_TRUE(map.add({0.8, 0.0, 0.0}));
  EXPECT_FALSE(map.add({0.8, 0.0, 0.0})) << "is known";
  EXPECT_FALSE(map.straight_path_free(left, right));
  EXPECT_TRUE(map.straight_path_free(left, Eigen::Vector2d(-0.5, 0.0)));
  map.forget();
  EXPECT_TRUE(map.straight_path_free(left, right));
}

// However a wide line runs, the rest of it is free from every place on it, and a little aside.
TEST(SensedMap, RestOfAWideLineIsFree) {
  const auto model = robot("planar_2r");
  Random random(9);
  int wide = 0;
  for (int scene = 0; scene < 200; ++scene) {
    SensedMap map(ArmPlanes(*model), model->limits, {.cells = 120});
    for (int i = 0; i < 2; ++i) (void)map.add({random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0});
    const JointVector from = random_joints(random, model->limits);
    const JointVector to = random_joints(random, model->limits);
    if (!map.straight_path_free(from, to, true)) continue;
    ++wide;
    for (int i = 0; i < 50; ++i) {
      JointVector q = from + random.uniform() * (to - from);
      for (Eigen::Index j = 0; j < q.size(); ++j) q[j] += random.uniform(-1.0, 1.0) * map.pitch() / 16.0;
      EXPECT_TRUE(map.straight_path_free(q, to));
    }
  }
  EXPECT_GT(wide, 20);
}

TEST(SensedMap, CellsAndTheirCentres) {
  const auto model = robot("puma560_3dof");
  const SensedMap map(ArmPlanes(*model), model->limits, {.cells = 180});
  for (const Cell3& cell : {Cell3{0, 0, 0}, Cell3{3, 7, 11}, Cell3{150, 120, 100}}) {
    EXPECT_EQ(map.cell_at(map.centre(cell)), cell);
    EXPECT_EQ(map.cell(map.index(cell)), cell);
  }
}

// A wall of blocked cells: straight through is closed, round one end is open.
class Search : public testing::Test {
 protected:
  Search() : model_(robot("planar_2r")), map_(ArmPlanes(*model_), model_->limits, {.cells = 180}) {}

  CspaceSearch::State search(const JointVector& from, const JointVector& to) {
    search_.begin(map_, map_.cell_at(from), map_.cell_at(to));
    while (search_.state() == CspaceSearch::State::kRunning) (void)search_.advance(map_, 100);
    return search_.state();
  }

  std::shared_ptr<const RobotModel> model_;
  SensedMap map_;
  CspaceSearch search_{map_};
};

TEST_F(Search, GoesStraightInAnEmptyMap) {
  const JointVector from = map_.centre({0, 20, 30});
  const JointVector to = map_.centre({0, 60, 70});
  ASSERT_EQ(search(from, to), CspaceSearch::State::kFound);
  EXPECT_EQ(search_.path(map_).size(), 41U);  // along the diagonal
}

TEST_F(Search, PathUsesFreeCellsOnly) {
  (void)map_.add({0.75, 0.0, 0.0});  // blocks the stretched arm; the bent one passes
  const JointVector from = Eigen::Vector2d(-0.8, 0.0);
  const JointVector to = Eigen::Vector2d(0.8, 0.0);
  ASSERT_FALSE(map_.straight_path_free(from, to));
  ASSERT_EQ(search(from, to), CspaceSearch::State::kFound);
  const std::vector<Cell3> path = search_.path(map_);
  EXPECT_EQ(path.front(), map_.cell_at(from));
  EXPECT_EQ(path.back(), map_.cell_at(to));
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_FALSE(map_.blocked(path[i]));
    for (int k = 0; i > 0 && k < 3; ++k) EXPECT_LE(std::abs(path[i][k] - path[i - 1][k]), 1);
  }
}

// For any blocked cells: a straight line from one cell of the way to the next, from corner to corner, stays in free
// ones.
TEST_F(Search, NeverCutsACorner) {
  Random random(3);
  int found = 0;
  for (int scene = 0; scene < 30; ++scene) {
    map_.forget();
    for (int i = 0; i < 4; ++i) (void)map_.add({random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0});
    const JointVector from = random_joints(random, model_->limits);
    if (map_.blocked(map_.cell_at(from))) continue;
    if (search(from, random_joints(random, model_->limits)) != CspaceSearch::State::kFound) continue;
    ++found;
    const std::vector<Cell3> path = search_.path(map_);
    for (std::size_t i = 1; i < path.size(); ++i) {
      EXPECT_FALSE(map_.blocked({0, path[i - 1][1], path[i][2]}));
      EXPECT_FALSE(map_.blocked({0, path[i][1], path[i - 1][2]}));
    }
  }
  EXPECT_GT(found, 5);
}

// What is blocked during a search may lie on its way; but nothing is entered from there.
TEST_F(Search, RespectsCellsBlockedDuringTheSearch) {
  search_.begin(map_, map_.cell_at(Eigen::Vector2d(-2.0, 0.0)), map_.cell_at(Eigen::Vector2d(2.0, 0.0)));
  ASSERT_EQ(search_.advance(map_, 20), CspaceSearch::State::kRunning);
  (void)map_.add({0.3, 0.0, 0.0});
  while (search_.state() == CspaceSearch::State::kRunning) (void)search_.advance(map_, 100);
  EXPECT_EQ(search_.state(), CspaceSearch::State::kNone);
}

TEST_F(Search, FindsNoPathWhereTheFirstLinkIsBlocked) {
  (void)map_.add({0.3, 0.0, 0.0});
  EXPECT_EQ(search(Eigen::Vector2d(-0.8, 0.0), Eigen::Vector2d(0.8, 0.0)), CspaceSearch::State::kNone);
}

TEST_F(Search, EntersAndLeavesNoBlockedCell) {
  (void)map_.add({0.75, 0.0, 0.0});
  const JointVector blocked = Eigen::Vector2d(0.0, 0.0);
  ASSERT_TRUE(map_.blocked(map_.cell_at(blocked)));
  EXPECT_EQ(search(blocked, Eigen::Vector2d(0.8, 0.0)), CspaceSearch::State::kNone);
  EXPECT_EQ(search(Eigen::Vector2d(0.8, 0.0), blocked), CspaceSearch::State::kNone);
}

}  // namespace
}  // namespace hecaton::planner::cspace
