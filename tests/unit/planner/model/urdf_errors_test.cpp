// Every reason to refuse a URDF, and its sentence.

#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::joint;
using test::kLimit;
using test::robot;

struct BadUrdf {
  const char* name;
  std::string urdf;
  std::string sentence;  // a part of it
  std::string tool_link = "";
};

void PrintTo(const BadUrdf& bad, std::ostream* out) {
  *out << bad.name;
}

/// base –j– a, with `inside` in the joint and `link_inside` in link a.
std::string two_links(const std::string& type, const std::string& inside) {
  return robot(ball_link("base") + ball_link("a") + joint("j", type, "base", "a", inside));
}

std::string shape(const std::string& geometry) {
  return robot(ball_link("base") + "<link name=\"a\"><collision>" + geometry + "</collision></link>" +
               joint("j", "revolute", "base", "a", kLimit));
}

class BadUrdfs : public testing::TestWithParam<BadUrdf> {};

TEST_P(BadUrdfs, AreRefusedInOneSentenceThatNamesTheFile) {
  UrdfOptions options;
  options.tool_link = GetParam().tool_link;
  const std::string message = test::error_of(GetParam().urdf, options);
  EXPECT_NE(message.find(GetParam().sentence), std::string::npos) << message;
  EXPECT_NE(message.find("r.urdf:"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

const std::string kMassless = ball_link("base") + ball_link("a");

INSTANTIATE_TEST_SUITE_P(
    Document, BadUrdfs,
    testing::Values(
        BadUrdf{"empty", "", "this URDF file is empty"},
        BadUrdf{"lfs_pointer", "version https://git-lfs.github.com/spec/v1\noid sha256:1f\nsize 12\n",
                "this URDF file is a pointer of Git LFS, not the file itself; fetch it with 'git lfs pull'"},
        BadUrdf{"not_xml", "solid stl", "malformed XML"},
        BadUrdf{"unclosed", "<robot name='r'>\n<link name='a'>\n</robot>", "r.urdf:2: malformed XML (XML_ERROR_MISM"},
        BadUrdf{"root", "<sdf version='1.6'/>", "the root element is 'sdf'; a URDF's is <robot>"},
        BadUrdf{"xacro_element", robot("<xacro:include filename='x'/>" + kMassless),
                "<xacro:include> is xacro, not plain URDF; install the program xacro and put it on the PATH"},
        BadUrdf{"xacro_value", two_links("revolute", "<origin xyz='${l} 0 0'/>" + kLimit), "xyz = '${l} 0 0' is xacro"},
        BadUrdf{"no_links", robot(""), "the robot has no links"},
        BadUrdf{"no_joints", robot(ball_link("base")), "no joint between the root and tool link 'base' moves"},
        BadUrdf{"unnamed_link", robot("<link/>"), "<link> must have the attribute 'name'"},
        BadUrdf{"duplicate_link", robot(ball_link("a") + ball_link("a")), "link 'a' exists twice"},
        BadUrdf{"duplicate_joint",
                robot(kMassless + ball_link("b") + joint("j", "revolute", "base", "a", kLimit) +
                      joint("j", "revolute", "a", "b", kLimit)),
                "joint 'j' exists twice"},
        BadUrdf{"two_roots", robot(kMassless), "links 'a' and 'base' both have no parent"},
        BadUrdf{"two_parents",
                robot(kMassless + ball_link("b") + joint("j", "revolute", "base", "a", kLimit) +
                      joint("k", "fixed", "base", "b") + joint("l", "fixed", "b", "a")),
                "joint 'l': its child link 'a' is already the child of joint 'j'"},
        BadUrdf{"loop",
                robot(ball_link("base") + ball_link("a") + ball_link("b") + joint("j", "fixed", "a", "b") +
                      joint("k", "fixed", "b", "a")),
                "link 'a' is part of a loop of joints"},
        BadUrdf{"self_loop", robot(ball_link("base") + joint("j", "fixed", "base", "base")), "part of a loop"},
        BadUrdf{"tool", two_links("revolute", kLimit), "tool link 'hand' must be one of its links: base, a", "hand"}),
    test::CaseName());

INSTANTIATE_TEST_SUITE_P(
    Joint, BadUrdfs,
    testing::Values(
        BadUrdf{"no_type", robot(kMassless + "<joint name='j'/>"), "joint 'j': <joint> must have the attribute 'type'"},
        BadUrdf{"type", two_links("ball", kLimit), "joint 'j': type = 'ball' must be revolute, continuous"},
        BadUrdf{"no_parent", robot(kMassless + "<joint name='j' type='fixed'><child link='a'/></joint>"),
                "joint 'j' has no <parent link=…>"},
        BadUrdf{"missing_parent", robot(kMassless + joint("j", "fixed", "bass", "a")),
                "joint 'j': its parent link 'bass' does not exist"},
        BadUrdf{"missing_child", robot(kMassless + joint("j", "fixed", "base", "b")),
                "joint 'j': its child link 'b' does not exist"},
        BadUrdf{"no_limit", two_links("prismatic", ""), "joint 'j' has no <limit>; revolute and prismatic"},
        BadUrdf{"swapped_limits", two_links("revolute", "<limit lower='1' upper='-1' velocity='1'/>"),
                "joint 'j': limit lower = '1' must be below upper = '-1'"},
        BadUrdf{"equal_limits", two_links("revolute", "<limit velocity='1'/>"), "limit lower = '0' must be below"},
        BadUrdf{"nan_limit", two_links("revolute", "<limit lower='nan' upper='1' velocity='1'/>"),
                "joint 'j': limit lower = 'nan' must be a finite number"},
        BadUrdf{"word_limit", two_links("revolute", "<limit lower='-pi' upper='1' velocity='1'/>"),
                "limit lower = '-pi' must be a finite number"},
        BadUrdf{"huge_limit", two_links("revolute", "<limit lower='0' upper='1e999' velocity='1'/>"),
                "limit upper = '1e999' must be a finite number"},
        BadUrdf{"no_velocity", two_links("revolute", "<limit lower='0' upper='1'/>"),
                "joint 'j' has no velocity limit above 0"},
        BadUrdf{"zero_velocity", two_links("revolute", "<limit lower='0' upper='1' velocity='0'/>"),
                "joint 'j' has no velocity limit above 0"},
        BadUrdf{"continuous_velocity", two_links("continuous", ""), "joint 'j' has no velocity limit above 0"},
        BadUrdf{"negative_velocity", two_links("revolute", "<limit lower='0' upper='1' velocity='-2'/>"),
                "joint 'j' has no velocity limit above 0"},
        BadUrdf{"zero_axis", two_links("revolute", "<axis xyz='0 0 0'/>" + kLimit),
                "joint 'j': axis xyz = '0 0 0' must be a direction"},
        BadUrdf{"short_axis", two_links("revolute", "<axis xyz='0 1'/>" + kLimit), "axis xyz = '0 1' must be 3 finite"},
        BadUrdf{"inf_origin", two_links("revolute", "<origin xyz='0 inf 0'/>" + kLimit),
                "joint 'j': origin xyz = '0 inf 0' must be 3 finite numbers"},
        BadUrdf{"nan_rpy", two_links("revolute", "<origin rpy='0 0 nan'/>" + kLimit),
                "origin rpy = '0 0 nan' must be 3"},
        BadUrdf{"far_origin", two_links("revolute", "<origin xyz='0 0 5000'/>" + kLimit), "must lie within 1000 m"},
        BadUrdf{"mimic", two_links("revolute", "<mimic joint='k'/>" + kLimit),
                "joint 'j': it mimics joint 'k', which does not exist"},
        BadUrdf{"mimic_itself", two_links("revolute", "<mimic joint='j'/>" + kLimit),
                "joint 'j': it mimics joint 'j' and so follows itself"},
        BadUrdf{"soft_limits",
                two_links("revolute", kLimit + "<safety_controller soft_lower_limit='5' soft_upper_limit='6'/>"),
                "soft_lower_limit = '5' and soft_upper_limit = '6' must leave a part of the joint's range"}),
    test::CaseName());

INSTANTIATE_TEST_SUITE_P(
    Link, BadUrdfs,
    testing::Values(
        BadUrdf{"no_geometry", shape(""), "link 'a', collision has no shape; box, cylinder, sphere, capsule and mesh"},
        BadUrdf{"empty_geometry", shape("<geometry/>"), "link 'a', collision has no shape"},
        BadUrdf{"unknown", shape("<geometry><cone r='1'/></geometry>"), "link 'a', collision: shape 'cone' is unknown"},
        BadUrdf{"inside_out_box", shape("<geometry><box size='1 -1 1'/></geometry>"),
                "box size = '1 -1 1' must be at least 0"},
        BadUrdf{"box_without_size", shape("<geometry><box/></geometry>"), "<box> must have the attribute 'size'"},
        BadUrdf{"sphere", shape("<geometry><sphere radius='-0.1'/></geometry>"),
                "sphere radius = '-0.1' must be at least"},
        BadUrdf{"cylinder", shape("<geometry><cylinder radius='0.1' length='-1'/></geometry>"),
                "cylinder length = '-1' must be at least 0"},
        BadUrdf{"capsule", shape("<geometry><capsule radius='0' length='1'/></geometry>"),
                "capsule radius = '0', length = '1' must be above 0"},
        BadUrdf{"nan_sphere", shape("<geometry><sphere radius='nan'/></geometry>"), "radius = 'nan' must be a finite"},
        BadUrdf{"mesh_without_file", shape("<geometry><mesh/></geometry>"),
                "<mesh> must have the attribute 'filename'"},
        BadUrdf{"mesh_scale", shape("<geometry><mesh filename='x.stl' scale='1 0 1'/></geometry>"),
                "mesh scale = '1 0 1' must not hold a 0"},
        BadUrdf{"missing_mesh", shape("<geometry><mesh filename='x.stl'/></geometry>"), "x.stl' does not exist"},
        BadUrdf{"package", shape("<geometry><mesh filename='package://no_such_package/x.stl'/></geometry>"),
                "link 'a': 'package://no_such_package/x.stl' is not found: map package 'no_such_package'"},
        BadUrdf{"nan_inertia",
                robot(ball_link("base") + "<link name='a'><inertial><mass value='nan'/></inertial></link>"),
                "link 'a': mass value = 'nan' must be a finite number"},
        BadUrdf{"bare", robot(ball_link("base") + "<link name='a'/>" + joint("j", "revolute", "base", "a", kLimit)),
                "link 'a', which joint 'j' moves, has no collision geometry"}),
    test::CaseName());

TEST(BadFiles, AreRefusedIfTheyAreUtf16) {
  const std::string message = test::error_of(std::string("\xFF\xFE<\0r\0", 6));
  EXPECT_NE(message.find("r.urdf: this URDF is UTF-16; it must be UTF-8"), std::string::npos) << message;
}

TEST(BadFiles, AreMissingOrAFolder) {
  const test::TemporaryFolder folder;
  const auto message = [](const std::string& path) -> std::string {
    try {
      std::ignore = load_urdf(path);
    } catch (const ModelError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(folder.path("none.urdf")).find("none.urdf: this URDF file does not exist"), std::string::npos);
  EXPECT_NE(message(folder.path("")).find("must be a regular file"), std::string::npos);
}

TEST(BadOptions, AreRefusedUnlessPositive) {
  UrdfOptions options;
  options.default_velocity = 0.0;
  EXPECT_NE(test::error_of(two_links("revolute", kLimit), options).find("default velocity"), std::string::npos);
  options.default_velocity.reset();
  options.default_acceleration = -1.0;
  EXPECT_NE(test::error_of(two_links("revolute", kLimit), options).find("default acceleration"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::planner
