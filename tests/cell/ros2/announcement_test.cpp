/// The announcement of the node hecaton, ros_discovery_info: hecaton-ros2 alone, without the other programs of a cell.

#include <csignal>

#include "services/ros2/node_graph.hpp"
#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {
namespace {

/// hecaton-ros2 with the cell three_puma and these further keys of the section `ros2`.
class Announcement : public testing::Test {
 protected:
  using Times = PeerReader<rosgraph_msgs::msg::ClockPubSubType>;

  Announcement() { RawPeerType::name = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"; }
  void start(const std::string& keys) {
    const std::string cells = HECATON_LIVE_CELLS;
    std::filesystem::create_directory_symlink(cells + "/urdf", folder_.path() / "urdf");
    std::ifstream plain(cells + "/three_puma.yaml");
    const std::string text{std::istreambuf_iterator<char>(plain), {}};
    const std::string file =
        folder_.write("cell.yaml", text + "\nros2: {domain: " + std::to_string(ros_domain_.number()) + keys + "}\n");
    ros2_ = std::make_unique<Process>(std::vector<std::string>{std::string(HECATON_BIN_DIR) + "/hecaton-ros2", file,
                                                               "--domain", std::to_string(cell_domain_.number())});
  }
  void TearDown() override {
    ros2_->signal(SIGINT);
    EXPECT_EQ(ros2_->wait(), 0) << ros2_->err();
  }
  /// Waits until the service has run for longer than it waits for announcements of other nodes.
  static bool runs_long_enough(RosPeer& peer) {
    constexpr std::int32_t kMore = ros2::NodeGraph::kLook.count() + 2;  // [s]
    Times times(peer, "rt/clock", {false, false, 1});
    const auto first = times.next();
    return first && times.next([&](const auto& time) { return time.clock().sec() > first->clock().sec() + kMore; });
  }

  // Each test has one peer that reads and then one that writes: these two would match each other.
  FreeDomain cell_domain_;
  FreeDomain ros_domain_;
  TemporaryFolder folder_;
  std::unique_ptr<Process> ros2_;
};

TEST_F(Announcement, IsSentWithADistribution) {
  start(", distribution: jazzy");
  {
    RosPeer reader(ros_domain_.number(), 100);
    PeerReader<RawPeerType> announcements(reader, "ros_discovery_info", {true, true, 1});
    ASSERT_TRUE(runs_long_enough(reader));
    EXPECT_TRUE(announcements.next());
    EXPECT_TRUE(announcements.wait_matched());
  }
  RosPeer writer(ros_domain_.number(), 101);
  PeerWriter<RawPeerType> other(writer, "ros_discovery_info", {true, true, 1});
  EXPECT_TRUE(other.wait_matched()) << "it reads those of other nodes";
}

TEST_F(Announcement, HasNoEndpointWithoutADistribution) {
  start("");
  {
    RosPeer reader(ros_domain_.number(), 100);
    PeerReader<RawPeerType> announcements(reader, "ros_discovery_info", {true, true, 1});
    ASSERT_TRUE(runs_long_enough(reader));
    EXPECT_TRUE(announcements.take().empty());
    EXPECT_FALSE(announcements.wait_matched(0s)) << "a writer";
  }
  RosPeer writer(ros_domain_.number(), 101);
  PeerWriter<RawPeerType> other(writer, "ros_discovery_info", {true, true, 1});
  ASSERT_TRUE(runs_long_enough(writer));
  EXPECT_FALSE(other.matched()) << "a reader";
}

}  // namespace
}  // namespace hecaton::test
