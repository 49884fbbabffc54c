#include "planner/model/urdf_loader.hpp"

#include <chrono>
#include <cmath>

#include "planner/model/kinematics.hpp"
#include "planner/model/xacro.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::has_note;
using test::joint;
using test::kLimit;
using test::load_text;
using test::robot;

constexpr double kDegree = 0.017453292519943295;

TEST(UrdfLoader, ReadsThePuma) {
  const auto model = load_urdf(test::kPuma);
  EXPECT_EQ(model->name, "puma560");
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"joint1", "joint2", "joint3", "joint4", "joint5", "joint6"}));
  const double lower[] = {-160, -225, -45, -110, -100, -266};  // [Lee82], degrees
  const double upper[] = {160, 45, 225, 170, 100, 266};
  for (int j = 0; j < 6; ++j) {
    EXPECT_NEAR(model->limits.lower[j], lower[j] * kDegree, 1e-6);
    EXPECT_NEAR(model->limits.upper[j], upper[j] * kDegree, 1e-6);
    EXPECT_DOUBLE_EQ(model->limits.velocity[j], 1.5);
    EXPECT_DOUBLE_EQ(model->limits.acceleration[j], 10.0);
  }
  EXPECT_EQ(model->links[model->tool_link].name, "tool0");
  ASSERT_EQ(model->geometry.size(), 7U);
  int capsules = 0;
  int spheres = 0;
  for (const LinkGeometry& geometry : model->geometry) {
    capsules += std::holds_alternative<world::Capsule>(geometry.shape) ? 1 : 0;
    spheres += std::holds_alternative<world::Sphere>(geometry.shape) ? 1 : 0;
  }
  EXPECT_EQ(capsules, 6);
  EXPECT_EQ(spheres, 1);
  const auto& column = std::get<world::Capsule>(model->geometry[0].shape);
  EXPECT_DOUBLE_EQ(column.radius, 0.09);
  EXPECT_DOUBLE_EQ(column.half_length, 0.205);
  EXPECT_TRUE(model->geometry[0].X_LS.translation().isApprox(Eigen::Vector3d(0, 0, 0.295)));
}

TEST(UrdfLoader, LeavesOutPairsOfOneBodyAndOfNeighbours) {
  // 7 shapes on 7 bodies: 21 pairs, less 6 neighbours.
  EXPECT_EQ(load_urdf(test::kPuma)->self_pairs.size(), 15U);
  // Without joint 6 the wrist and the flange are one body: 21 − 1 − the 5 joints' pairs, of which the wrist roll's
  // bridges to two shapes.
  EXPECT_EQ(load_urdf(test::kPuma5)->self_pairs.size(), 21U - 1U - 6U);
}

TEST(UrdfLoader, ReadsSeveralPrimitivesPerLink) {
  const auto model = load_text(robot(
      R"(<link name="base"/><link name="a">
         <visual><geometry><mesh filename="package://nowhere/not_needed.dae"/></geometry></visual>
         <collision><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
         <collision><geometry><cylinder radius="0.1" length="0.5"/></geometry></collision>
         <collision><geometry><sphere radius="0.3"/></geometry></collision></link>)" +
      joint("j", "revolute", "base", "a", kLimit)));
  ASSERT_EQ(model->geometry.size(), 3U);
  EXPECT_TRUE(std::get<world::Box>(model->geometry[0].shape).half_extents.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  // The box's own x axis points along y of the link.
  EXPECT_TRUE((model->geometry[0].X_LS * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3)));
  EXPECT_DOUBLE_EQ(std::get<world::Cylinder>(model->geometry[1].shape).half_length, 0.25);
  EXPECT_DOUBLE_EQ(std::get<world::Sphere>(model->geometry[2].shape).radius, 0.3);
  EXPECT_TRUE(has_note(*model, "the base, link 'base', has no collision geometry"));
}

TEST(UrdfLoader, ReadsJointTypesLimitsAndAxes) {
  const auto model =
      load_text(robot(ball_link("base") + ball_link("a") + ball_link("b") + ball_link("c") +
                      joint("slide", "prismatic", "base", "a",
                            R"(<axis xyz="0 0 2"/><limit lower="0.1" upper="0.5" velocity="0.7"/>)") +
                      joint("spin", "continuous", "a", "b", R"(<limit velocity="3" effort="1"/>)") +
                      joint("turn", "revolute", "b", "c", R"(<axis xyz="0 -1 0"/><limit upper="1" velocity="2"/>)")));
  ASSERT_EQ(model->joint_names, (std::vector<std::string>{"slide", "spin", "turn"}));
  EXPECT_DOUBLE_EQ(model->limits.lower[0], 0.1);
  EXPECT_DOUBLE_EQ(model->limits.upper[0], 0.5);
  EXPECT_EQ(model->limits.lower[1], -INFINITY);
  EXPECT_EQ(model->limits.upper[1], INFINITY);
  EXPECT_DOUBLE_EQ(model->limits.lower[2], 0.0);  // URDF's default
  EXPECT_TRUE(model->limits.velocity.isApprox(Eigen::Vector3d(0.7, 3.0, 2.0)));
  EXPECT_TRUE(model->links[1].axis.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(model->links[2].axis.isApprox(Eigen::Vector3d::UnitX()));  // URDF's default
  EXPECT_TRUE(model->links[3].axis.isApprox(-Eigen::Vector3d::UnitY()));
}

TEST(UrdfLoader, SoftLimitsTightenTheRange) {
  const std::string inside =
      kLimit + R"(<safety_controller k_velocity="1" soft_lower_limit="-1.5" soft_upper_limit="3"/>)";
  const auto model = load_text(robot(ball_link("base") + ball_link("a") + joint("j", "revolute", "base", "a", inside)));
  EXPECT_DOUBLE_EQ(model->limits.lower[0], -1.5);
  EXPECT_DOUBLE_EQ(model->limits.upper[0], 2.0);
  EXPECT_TRUE(has_note(*model, "soft limits of safety controllers narrow the ranges of joints: 'j'"));
}

TEST(UrdfLoader, TakesNothingByUnsetSoftLimitsOrFromALockedJoint) {
  const std::string unset = kLimit + R"(<safety_controller k_velocity="1" soft_lower_limit="0" soft_upper_limit="0"/>)";
  const std::string locked = R"(<limit lower="0.5" upper="0.5" effort="1" velocity="1"/>)"
                             R"(<safety_controller k_velocity="1" soft_lower_limit="-1" soft_upper_limit="1"/>)";
  const auto model =
      load_text(robot(ball_link("base") + ball_link("a") + ball_link("b") + joint("j", "revolute", "base", "a", unset) +
                      joint("held", "revolute", "a", "b", locked)));
  ASSERT_EQ(model->joint_names, std::vector<std::string>{"j"});
  EXPECT_DOUBLE_EQ(model->limits.upper[0], 2.0);
  EXPECT_TRUE(has_note(*model, "joint 'held' is fixed"));
  EXPECT_FALSE(has_note(*model, "soft limits"));
}

TEST(UrdfLoader, UsesTheDefaultVelocityOnlyWhenGiven) {
  const std::string urdf = robot(ball_link("base") + ball_link("a") + ball_link("b") +
                                 joint("missing", "revolute", "base", "a", R"(<limit lower="-1" upper="1"/>)") +
                                 joint("zero", "continuous", "a", "b", R"(<limit effort="0" velocity="0"/>)"));
  EXPECT_NE(test::error_of(urdf).find("joint 'missing' has no velocity limit above 0"), std::string::npos);
  UrdfOptions options;
  options.default_velocity = 0.8;
  options.default_acceleration = 3.0;
  const auto model = load_text(urdf, options);
  EXPECT_TRUE(model->limits.velocity.isApproxToConstant(0.8));
  EXPECT_TRUE(model->limits.acceleration.isApproxToConstant(3.0));
  EXPECT_TRUE(has_note(*model, "joints 'missing', 'zero' have no velocity limit; the default 0.8 is used"));
}

TEST(UrdfLoader, AssumesAccelerationsFromVelocities) {
  UrdfOptions options;
  options.default_acceleration.reset();
  const auto model =
      load_text(robot(ball_link("base") + ball_link("a") + joint("j", "revolute", "base", "a", test::kLimit)), options);
  EXPECT_DOUBLE_EQ(model->limits.acceleration[0], 6.0);  // 1.5 rad/s within 0.25 s
}

TEST(UrdfLoader, NotesIgnoredLimitsOfAContinuousJoint) {
  const auto of = [](const std::string& limit) {
    return load_text(robot(ball_link("base") + ball_link("a") +
                           joint("spin", "continuous", "base", "a", "<limit " + limit + R"( velocity="1"/>)")));
  };
  const auto bounded = of(R"(lower="-0.5" upper="0.75")");
  EXPECT_TRUE(has_note(*bounded,
                       "joint 'spin' is continuous, therefore its limits lower = -0.5 and upper = 0.75 are "
                       "ignored"));
  EXPECT_TRUE(std::isinf(bounded->limits.upper[0]));
  EXPECT_FALSE(has_note(*of(""), "is continuous"));
}

TEST(UrdfLoader, NotesUnlikelySizesOnce) {
  const auto of = [](const std::string& sphere) {
    const std::string shape = "<collision><geometry><sphere radius=\"" + sphere + "\"/></geometry></collision>";
    return load_text(robot("<link name=\"base\">" + shape + "</link><link name=\"a\">" + shape + "</link>" +
                           joint("j", "revolute", "base", "a", test::kLimit)));
  };
  EXPECT_TRUE(has_note(*of("45"),
                       "unlikely size: the collision geometry of 'base' (90 m), 'a' (90 m) is more than "
                       "10 m across; a mesh in millimetres needs scale"));
  EXPECT_TRUE(has_note(*of("0.002"), "unlikely size: no collision shape is more than 4 mm across"));
  EXPECT_FALSE(has_note(*of("0.2"), "unlikely size"));
}

TEST(UrdfLoader, NotesLimitsInDegreesOnce) {
  const auto of = [](const std::string& limit) {
    return load_text(robot(ball_link("base") + ball_link("a") + ball_link("b") +
                           joint("j", "revolute", "base", "a", "<limit " + limit + "/>") +
                           joint("k", "revolute", "a", "b", "<limit " + limit + "/>")));
  };
  EXPECT_TRUE(has_note(*of(R"(lower="-90" upper="90" velocity="2")"),
                       "unlikely limits: 'j' (-90 to 90 rad, 2 rad/s), 'k' (-90 to 90 rad, 2 rad/s); a URDF has "
                       "radians, not degrees"));
  EXPECT_TRUE(has_note(*of(R"(lower="-1" upper="1" velocity="180")"), "unlikely limits: 'j' (-1 to 1 rad, 180 rad/s)"));
  EXPECT_FALSE(has_note(*of(R"(lower="-31" upper="31" velocity="50")"), "unlikely limits")) << "ten turns, a wrist";
}

TEST(UrdfLoader, PlacesTheToolFrameOnTheToolLink) {
  UrdfOptions options;
  options.tool_link = "forearm";
  options.X_LT.translation() << 0, -0.1, 0;
  const auto model = load_urdf(test::kPuma, options);
  EXPECT_EQ(model->joints(), 3);
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(3), kinematics);
  // The forearm's frame is at the elbow (0.4318, 0.15, 0.672), its −y is up.
  EXPECT_TRUE(kinematics.X_WT.translation().isApprox(Eigen::Vector3d(0.4318, 0.15, 0.772), 1e-9));
  // What hangs on the forearm is carried along, its joints held.
  EXPECT_EQ(model->links.size(), 8U);
  EXPECT_TRUE(has_note(*model, "outside the chain to the tool are held: 'joint4' at 0, 'joint5' at 0, 'joint6' at 0"));
}

TEST(UrdfLoader, AcceptsBareLinksOnlyWhenAllowed) {
  const std::string urdf = robot(ball_link("base") + R"(<link name="bare"/><link name="frame"/>)" + ball_link("a") +
                                 joint("j1", "revolute", "base", "bare", kLimit) +
                                 joint("f", "fixed", "bare", "frame") + joint("j2", "revolute", "frame", "a", kLimit));
  EXPECT_NE(test::error_of(urdf).find("link 'bare', which joint 'j1' moves, has no collision geometry"),
            std::string::npos);
  UrdfOptions options;
  options.allow_bare_links = true;
  EXPECT_TRUE(has_note(*load_text(urdf, options), "link 'bare'"));
  // Geometry on a link that is rigidly attached covers the body.
  EXPECT_EQ(
      test::error_of(robot(ball_link("base") + R"(<link name="bare"/>)" + ball_link("cover") +
                           joint("j1", "revolute", "base", "bare", kLimit) + joint("f", "fixed", "bare", "cover"))),
      "");
}

std::string with_shape(const std::string& geometry) {
  return robot(ball_link("base") +
               "<link name=\"a\"><collision><origin xyz=\"1 0 0\" rpy=\"1.5707963267948966 0 0\"/>" + "<geometry>" +
               geometry + "</geometry></collision></link>" + joint("j", "revolute", "base", "a", kLimit));
}

TEST(UrdfLoader, ReadsCapsules) {
  const auto model = load_text(with_shape(R"(<capsule radius="0.1" length="0.5"/>)"));
  ASSERT_EQ(model->geometry.size(), 2U);
  const auto& capsule = std::get<world::Capsule>(model->geometry[1].shape);
  EXPECT_DOUBLE_EQ(capsule.radius, 0.1);
  EXPECT_DOUBLE_EQ(capsule.half_length, 0.25);
  EXPECT_TRUE(model->geometry[1].X_LS.translation().isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE((model->geometry[1].X_LS.linear() * Eigen::Vector3d::UnitZ()).isApprox(-Eigen::Vector3d::UnitY()));
  const auto ball = load_text(with_shape(R"(<capsule radius="0.1" length="0"/>)"));
  EXPECT_DOUBLE_EQ(std::get<world::Sphere>(ball->geometry.at(1).shape).radius, 0.1);
}

TEST(UrdfLoader, LeavesOutShapesWithoutSizeAndThickensFlatOnes) {
  UrdfOptions options;
  options.allow_bare_links = true;
  const auto without = load_text(with_shape(R"(<box size="0 0 0"/>)"), options);
  EXPECT_EQ(without->geometry.size(), 1U);
  EXPECT_TRUE(has_note(*without, "link 'a', collision: the box has no size and is left out"));
  const auto flat = load_text(with_shape(R"(<box size="0.2 0 0.4"/>)"));
  EXPECT_TRUE(
      std::get<world::Box>(flat->geometry.at(1).shape).half_extents.isApprox(Eigen::Vector3d(0.1, 0.0005, 0.2)));
  EXPECT_TRUE(has_note(*flat, "the box has a size of 0, which is taken as 1 mm"));
}

TEST(UrdfLoader, NamesARobotWithoutNameAfterItsFile) {
  const auto model = load_text("<robot>" + ball_link("base") + ball_link("a") +
                               joint("j", "revolute", "base", "a", kLimit) + "</robot>");
  EXPECT_EQ(model->name, "r");
  EXPECT_TRUE(has_note(*model, "the robot has no name; it is called 'r'"));
}

TEST(UrdfLoader, ReadsLatin1AndByteOrderMarks) {
  const std::string parts = ball_link("base") + ball_link("a") + joint("j", "revolute", "base", "a", kLimit);
  EXPECT_EQ(load_text("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><robot name=\"Gr\xFC\xDF\">" + parts + "</robot>")
                ->name,
            "Gr\xC3\xBC\xC3\x9F");
  EXPECT_EQ(load_text("\xEF\xBB\xBF<robot name=\"b\">" + parts + "</robot>")->name, "b");
}

TEST(UrdfLoader, IgnoresXacroTextWhereNothingDependsOnIt) {
  const std::string link = R"(<link name="a"><visual><xacro:grey/><geometry><box size="${x} 1 1"/></geometry></visual>
      <inertial><mass value="${m}"/></inertial><collision><geometry><sphere radius="0.05"/></geometry></collision></link>)";
  const auto model = load_text(robot(ball_link("base") + link + joint("j", "revolute", "base", "a", kLimit) +
                                     R"(<gazebo reference="a"><plugin filename="$(find p)/x"/></gazebo>)"));
  EXPECT_EQ(model->geometry.size(), 2U);
  EXPECT_TRUE(has_note(*model, "have xacro text that is not expanded"));
}

TEST(UrdfLoader, TakesVisualShapesWhereNoLinkHasCollisionShapes) {
  const std::string seen = R"(<visual><geometry><box size="0.2 0.1 0.1"/></geometry><material name="grey"/></visual>)";
  const std::string moved = joint("j", "revolute", "base", "a", kLimit);
  const auto model = load_text(robot(R"(<link name="base"/><link name="a">)" + seen + "</link>" + moved));
  ASSERT_EQ(model->geometry.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<world::Box>(model->geometry[0].shape));
  EXPECT_TRUE(has_note(*model, "no link has collision geometry: the visual geometry of all links stands for it"));
  const auto mixed = load_text(robot(R"(<link name="base">)" + seen + "</link>" + ball_link("a") + moved));
  EXPECT_EQ(mixed->geometry.size(), 1U) << "collision shapes of any link rule out visual shapes";
}

TEST(UrdfLoader, NotesAToolThatTheLastJointOnlyTurns) {
  const auto arm = [](const std::string& tip) {
    const std::string joint = "<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>";
    return robot(ball_link("base") + ball_link("upper") + ball_link("lower") +
                 "<joint name='a' type='revolute'><parent link='base'/><child link='upper'/>" + joint +
                 "<joint name='b' type='revolute'><parent link='upper'/><child link='lower'/><origin xyz='1 0 0'/>" +
                 joint + tip);
  };
  const std::string note =
      "joint 'b' only turns the tool about its own origin; if the arm's tip is elsewhere, give its place in the frame "
      "of link 'lower' with the cell file's key 'tool'";
  UrdfOptions options;
  options.tool_link = "lower";
  EXPECT_TRUE(has_note(*load_text(arm(""), options), note));
  options.X_LT.translate(Eigen::Vector3d(0.4, 0.0, 0.0));
  EXPECT_FALSE(has_note(*load_text(arm(""), options), note));
  options = {};
  options.tool_link = "tip";
  const auto with_tip = load_text(arm("<link name='tip'/><joint name='c' type='fixed'><parent link='lower'/>"
                                      "<child link='tip'/><origin xyz='0.4 0 0'/></joint>"),
                                  options);
  EXPECT_TRUE(std::none_of(with_tip->notes.begin(), with_tip->notes.end(), [](const std::string& one) {
    return one.find("only turns the tool") != std::string::npos;
  }));
}

/// Puts a program `xacro` on the PATH for the time of a test.
class Xacro : public testing::Test {
 protected:
  explicit Xacro() : path_(std::getenv("PATH")) {}
  ~Xacro() override { setenv("PATH", path_.c_str(), 1); }
  void install(const std::string& script) {
    const std::string program = folder_.write("bin/xacro", "#!/bin/sh\n" + script);
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("PATH", (folder_.path("bin") + ":" + path_).c_str(), 1);
  }

  test::TemporaryFolder folder_;
  std::string path_;
  std::string source_ = robot(ball_link("base") + "<xacro:arm/>");
};

TEST_F(Xacro, ExpandsFilesAndTheSnapshotKeepsTheResult) {
  install(
      "test \"$2\" = side:=left || exit 1\nsed 's/<xacro:arm.>/<link name=\"left\"\\/>'"
      "'<joint name=\"j\" type=\"continuous\"><parent link=\"base\"\\/><child link=\"left\"\\/>'"
      "'<limit effort=\"1\" velocity=\"1\"\\/><\\/joint>/' \"$1\"\n");
  const std::string file = folder_.write("r.urdf.xacro", source_);
  SourceFiles sources;
  UrdfOptions options;
  options.sources = &sources;
  options.allow_bare_links = true;
  options.xacro_arguments = {{"side", "left"}};
  options.names.xacro_arguments = "--xacro NAME=VALUE";
  const auto model = load_urdf(file, options);
  EXPECT_EQ(model->joint_names, std::vector<std::string>{"j"});
  EXPECT_TRUE(has_note(*model, "the program xacro expanded the file; --xacro NAME=VALUE gives it arguments"));
  sources.keep(folder_.path("snapshot"));
  install("exit 1\n");
  SourceFiles kept(folder_.path("snapshot"));
  options.sources = &kept;
  EXPECT_EQ(load_urdf(file, options)->joint_names, std::vector<std::string>{"j"});
}

TEST_F(Xacro, FailsWithTheErrorLineOfTheProgramElseItsLastLine) {
  UrdfOptions options;
  options.names.xacro_arguments = "--xacro NAME=VALUE";
  install("echo first >&2\necho error: no file arm.xacro >&2\necho when processing file: r.urdf >&2\nexit 2\n");
  EXPECT_NE(test::error_of(source_, options).find("cannot expand this file: 'no file arm.xacro'"), std::string::npos);
  install("echo first >&2\necho undefined argument side >&2\nexit 2\n");
  const std::string message = test::error_of(source_, options);
  EXPECT_NE(message.find("r.urdf: xacro cannot expand this file: 'undefined argument side'; --xacro NAME=VALUE gives"),
            std::string::npos)
      << message;
  options.names.xacro_arguments.clear();
  const std::string without_option = test::error_of(source_, options);
  EXPECT_TRUE(
      without_option.ends_with("if it needs arguments, expand it first (xacro in.xacro NAME:=VALUE > out.urdf)"))
      << without_option;
}

// xacro prints where it was after its error.
TEST_F(Xacro, FailsWithTheErrorAndNotWithItsPlace) {
  install("echo 'error: unknown macro name: arm' >&2\necho 'when processing file: r.xacro' >&2\nexit 2\n");
  const std::string message = test::error_of(source_);
  EXPECT_NE(message.find("xacro cannot expand this file: 'unknown macro name: arm'"), std::string::npos) << message;
}

TEST_F(Xacro, SaysHowToNameAPackage) {
  install("echo \"error: \\\"package 'my_arm' not found, searching: ['/opt']\\\"\" >&2\nexit 2\n");
  UrdfOptions options;
  options.names.packages = "--package @=DIR";
  const std::string message = test::error_of(source_, options);
  EXPECT_TRUE(
      message.ends_with("; map package 'my_arm' to its folder (--package my_arm=DIR), or keep the file below a "
                        "folder of that name, or source its ROS 2 workspace"))
      << message;
}

/// A program that needs the package my_arm, and inserts the link that the package's file arm.xml holds.
const std::string kNeedsPackage =
    "IFS=:\nfor prefix in $AMENT_PREFIX_PATH; do\n"
    "  if test -f \"$prefix/share/ament_index/resource_index/packages/my_arm\"; then\n"
    "    sed \"s/<xacro:arm.>/$(cat \"$prefix/share/my_arm/arm.xml\")/\" \"$1\"; exit 0; fi\ndone\n"
    "echo \"error: package 'my_arm' not found\" >&2\nexit 2\n";
const std::string kArm =
    "<link name=\"left\"\\/><joint name=\"j\" type=\"continuous\"><parent link=\"base\"\\/><child link=\"left\"\\/>"
    "<limit effort=\"1\" velocity=\"1\"\\/><\\/joint>";

TEST_F(Xacro, FindsPackagesThatTheUserNames) {
  install(kNeedsPackage);
  folder_.write("elsewhere/arm.xml", kArm);
  const std::string file = folder_.write("r.urdf.xacro", source_);
  UrdfOptions options;
  options.allow_bare_links = true;
  EXPECT_THROW(static_cast<void>(load_urdf(file, options)), ModelError);
  options.packages = {{"my_arm", folder_.path("elsewhere")}};
  EXPECT_EQ(load_urdf(file, options)->joint_names, std::vector<std::string>{"j"});
}

TEST_F(Xacro, WritesNothingOutsideOfItsFolder) {
  install(kNeedsPackage);
  const std::string outside = folder_.path("outside");
  const std::string file = folder_.write("r.urdf.xacro", source_);
  UrdfOptions options;
  options.packages = {{outside, folder_.path("")}, {"../../../../../outside", folder_.path("")}};
  EXPECT_THROW(static_cast<void>(load_urdf(file, options)), ModelError);
  EXPECT_FALSE(std::filesystem::exists(outside));
}

TEST_F(Xacro, FindsThePackageThatTheFileIsIn) {
  install(kNeedsPackage);
  folder_.write("repository/package.xml", "<package><name>my_arm</name></package>");
  folder_.write("repository/arm.xml", kArm);
  const std::string file = folder_.write("repository/urdf/r.urdf.xacro", source_);
  UrdfOptions options;
  options.allow_bare_links = true;
  EXPECT_EQ(load_urdf(file, options)->joint_names, std::vector<std::string>{"j"});
}

TEST_F(Xacro, KillsAProgramThatDoesNotEnd) {
  install("exec sleep 1000\n");
  const std::string file = folder_.write("r.urdf.xacro", source_);
  XacroOptions options;
  options.time_limit = std::chrono::seconds(1);
  SourceFiles sources;
  try {
    std::ignore = expand_xacro(file, sources, options);
    FAIL() << "the program did not end";
  } catch (const ModelError& error) {
    EXPECT_NE(std::string(error.what()).find("r.urdf.xacro: the program xacro did not end within 1 s and was killed: "),
              std::string::npos)
        << error.what();
  }
}

TEST_F(Xacro, GetsNoPathThatLooksLikeAnOption) {
  install("case \"$1\" in -*) exit 3;; esac\nsed 's/<xacro:arm.>/" + kArm + "/' \"$1\"\n");
  folder_.write("-r.urdf.xacro", source_);
  UrdfOptions options;
  options.allow_bare_links = true;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path(""));
  EXPECT_EQ(load_urdf("-r.urdf.xacro", options)->joint_names, std::vector<std::string>{"j"});
  std::filesystem::current_path(before);
}

TEST_F(Xacro, LeavesNoXacroText) {
  install("cat \"$1\"\n");
  EXPECT_NE(test::error_of(source_).find("<xacro:arm> is xacro that the program xacro left as it was"),
            std::string::npos);
}

TEST(UrdfLoader, PrintsNothing) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  std::ignore = load_urdf(test::kPuma);
  EXPECT_NE(test::error_of("<robot name='x'><link name='a'/>"), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace hecaton::planner
