#include "planner/model/srdf.hpp"

#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

std::shared_ptr<const RobotModel> puma_with(const std::string& srdf) {
  const test::TemporaryFolder folder;
  UrdfOptions options;
  options.srdf_path = folder.write("p.srdf", srdf);
  return load_urdf(test::kPuma, options);
}

std::string puma(const std::string& inside) {
  return "<robot name=\"puma560\">" + inside + "</robot>";
}

int pairs_with(const RobotModel& model, const std::string& link) {
  int count = 0;
  for (const auto& [a, b] : model.self_pairs) {
    count += model.links[model.geometry[a].link].name == link || model.links[model.geometry[b].link].name == link;
  }
  return count;
}

TEST(Srdf, DisablesPairsInEitherOrder) {
  const auto model = puma_with(puma(R"(<disable_collisions link1="base_link" link2="forearm" reason="Never"/>
                                       <disable_collisions link1="flange" link2="shoulder"/>)"));
  EXPECT_EQ(model->self_pairs.size(), 13U);
  EXPECT_EQ(pairs_with(*model, "base_link"), 4);  // 5 without the SRDF: all but the shoulder
  EXPECT_EQ(pairs_with(*model, "flange"), 4);     // 5 without the SRDF: all but the wrist's bend
}

TEST(Srdf, DisablesByDefaultUnlessEnabled) {
  const auto model = puma_with(puma(R"(<enable_collisions link1="base_link" link2="flange"/>
                                       <disable_default_collisions link="flange"/>)"));
  EXPECT_EQ(pairs_with(*model, "flange"), 1);
  EXPECT_EQ(model->self_pairs.size(), 11U);
}

TEST(Srdf, SkipsUnknownLinksWithOneNote) {
  const auto model = puma_with(puma(R"(<disable_collisions link1="camera" link2="forearm"/>
                                       <disable_collisions link1="camera" link2="base_link"/>)"));
  EXPECT_EQ(model->self_pairs.size(), 15U);
  EXPECT_TRUE(test::has_note(*model, "link 'camera' does not exist in the URDF and is skipped"));
}

TEST(Srdf, ReadsGroupStatesAsNamedConfigurations) {
  const auto model = puma_with(puma(R"(
      <group name="arm"><chain base_link="base_link" tip_link="tool0"/></group>
      <group_state name="ready" group="arm">
        <joint name="joint6" value="0.6"/><joint name="joint1" value="-0.3"/><joint name="joint2" value="-1.25"/>
        <joint name="joint3" value="3.5"/><joint name="joint4" value="0"/><joint name="joint5" value="0.89"/>
        <joint name="finger" value="0.04"/>
      </group_state>
      <group_state name="partial" group="arm"><joint name="joint1" value="0"/></group_state>
      <group_state name="outside" group="arm"><joint name="joint1" value="3"/></group_state>)"));
  ASSERT_EQ(model->named.size(), 1U);
  JointVector ready(6);
  ready << -0.3, -1.25, 3.5, 0, 0.89, 0.6;
  EXPECT_EQ(model->named.at("ready"), ready);
  EXPECT_TRUE(test::has_note(*model, "group_state 'partial' is skipped: it does not set every joint"));
  EXPECT_TRUE(test::has_note(*model, "group_state 'outside' is skipped: joint 'joint1' = 3"));
}

TEST(Srdf, SkipsStatesOfOtherGroupsWithoutANote) {
  const auto model =
      puma_with(puma(R"(<group_state name="open" group="hand"><joint name="finger" value="1"/></group_state>)"));
  EXPECT_TRUE(model->named.empty());
  EXPECT_FALSE(test::has_note(*model, "open"));
}

std::string tool_with(const std::string& inside, const std::string& base = "") {
  const test::TemporaryFolder folder;
  UrdfOptions options;
  options.srdf_path = folder.write("p.srdf", puma(inside));
  options.base_link = base;
  const auto model = load_urdf(test::kPuma, options);
  return model->links[model->tool_link].name;
}

TEST(Srdf, NamesTheToolLink) {
  const std::string chain = R"(<group name="arm"><chain base_link="base_link" tip_link="flange"/></group>)";
  const std::string short_chain = R"(<group name="half"><chain base_link="base_link" tip_link="forearm"/></group>)";
  EXPECT_EQ(tool_with(chain), "flange");
  EXPECT_EQ(tool_with(chain + short_chain), "tool0") << "two groups: the longest chain";
  EXPECT_EQ(tool_with(chain + short_chain + R"(<end_effector name="e" parent_link="forearm" group="h"/>)"), "forearm");
  EXPECT_EQ(tool_with(R"(<end_effector name="e" parent_link="nowhere" group="h"/>)"), "tool0");
  EXPECT_EQ(
      tool_with(short_chain + R"(<group name="g"><chain base_link="shoulder" tip_link="flange"/></group>)", "shoulder"),
      "flange");
}

TEST(Srdf, NamesTheToolLinkOfNestedGroups) {
  const std::string shoulder = R"(<group name="a"><chain base_link="base_link" tip_link="forearm"/></group>)";
  const std::string wrist = R"(<group name="b"><chain base_link="forearm" tip_link="flange"/></group>)";
  const std::string both = R"(<group name="arm"><group name="a"/><group name="b"/></group>)";
  EXPECT_EQ(tool_with(both + shoulder + wrist), "flange");
  EXPECT_EQ(tool_with(shoulder + wrist), "tool0") << "two groups: the longest chain";
  EXPECT_EQ(tool_with(both + shoulder + wrist, "base_link"), "flange");
  const std::string itself =
      R"(<group name="c"><group name="c"/><chain base_link="base_link" tip_link="flange"/></group>)";
  EXPECT_EQ(tool_with(itself), "flange");
  // A link after the tip of the chain, such as a gripper's in a group of arm and gripper, is not the tool.
  const std::string with_hand = R"(<group name="all"><group name="b"/><group name="hand"/></group>
                                   <group name="hand"><link name="tool0"/></group>)";
  EXPECT_EQ(tool_with(wrist + with_hand), "flange");
}

TEST(Srdf, NamesTheToolLinkOfGroupsOfJointsAndLinks) {
  const std::string joints =
      R"(<group name="arm"><joint name="joint1"/><joint name="joint2"/><joint name="joint3"/></group>)";
  const std::string links =
      R"(<group name="arm"><link name="shoulder"/><link name="upper_arm"/><link name="forearm"/></group>)";
  const std::string finger = R"(<group name="hand"><joint name="joint6"/></group>)";
  EXPECT_EQ(tool_with(joints + finger), "forearm");
  EXPECT_EQ(tool_with(links + finger), "forearm");
  EXPECT_EQ(tool_with(joints, "base_link"), "forearm");
  const std::string chain = R"(<group name="c"><chain base_link="base_link" tip_link="flange"/></group>)";
  EXPECT_EQ(tool_with(joints + chain), "flange") << "a chain says more than a list";
}

TEST(Srdf, NotesWhatItDoesNotUse) {
  const auto model =
      puma_with(puma(R"(<virtual_joint name="v" type="fixed" parent_frame="world" child_link="base_link"/>
                                       <passive_joint name="finger"/><passive_joint name="joint2"/>
                                       <group name="arm"><group name="nowhere"/></group>)"));
  EXPECT_TRUE(test::has_note(*model, "elements that are not used: 'passive_joint' (2), 'virtual_joint'"));
  EXPECT_TRUE(test::has_note(*model, "joint 'joint2' is passive, but moves the tool"));
  EXPECT_FALSE(test::has_note(*model, "joint 'finger' is passive"));
  EXPECT_TRUE(test::has_note(*model, "group 'nowhere' in group 'arm' does not exist and is skipped"));
  EXPECT_FALSE(test::has_note(*puma_with(puma("")), "not used"));
}

TEST(Srdf, RefusesBadFiles) {
  const auto error = [](const std::string& text) -> std::string {
    try {
      puma_with(text);
    } catch (const ModelError& caught) {
      return caught.what();
    }
    return "";
  };
  EXPECT_NE(error("<robot").find("p.srdf:1: malformed XML"), std::string::npos);
  EXPECT_NE(error("<group/>").find("an SRDF's is <robot>"), std::string::npos);
  EXPECT_NE(error(puma("<disable_collisions link1='flange'/>")).find("must have the attribute 'link2'"),
            std::string::npos);
  EXPECT_NE(error(puma("<group_state name='s'><joint name='joint1' value='up'/></group_state>"))
                .find("group_state 's': joint value = 'up' must be a finite number"),
            std::string::npos);
  UrdfOptions options;
  options.srdf_path = "/nowhere/at_all.srdf";
  EXPECT_THROW(std::ignore = load_urdf(test::kPuma, options), ModelError);
}

}  // namespace
}  // namespace hecaton::planner
