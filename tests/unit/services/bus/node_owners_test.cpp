#include "services/bus/node_owners.hpp"

#include <algorithm>
#include <map>
#include <string>

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

class NodeOwnersTest : public testing::Test {
 protected:
  static EndpointId writer_of(std::uint8_t participant) {
    EndpointId id;
    id.bytes.front() = participant;
    id.bytes.back() = 7;
    return id;
  }
  void join(std::uint8_t participant, const std::string& name) {
    owners_.found(writer_of(participant), name);
    owners_.matched(writer_of(participant));
    hear(participant);
  }
  void hear(std::uint8_t participant) { heard_[writer_of(participant)] = now_; }
  bool may_write(std::uint8_t participant, const std::string& node = "planner/north") {
    const auto owner = owners_.owner_beside(writer_of(participant), node, now_);
    if (owner) owners_.note_challenge({writer_of(participant), "GoalStatus", "north/g"}, *owner, now_);
    return !owner;
  }

  Clock::time_point now_{10s};
  std::map<EndpointId, Clock::time_point> heard_;
  NodeOwners owners_{{"planner/north", "planner/north@beta", "planner/south", "supervisor"},
                     [this](const EndpointId& id) {
                       const auto known = heard_.find(id);
                       return known == heard_.end() ? std::nullopt : std::optional(known->second);
                     }};
};

TEST_F(NodeOwnersTest, LetsAnyParticipantWriteWhileTheNodeHasNone) {
  join(1, "planner/south");
  join(2, "intruder");
  EXPECT_TRUE(may_write(1));
  EXPECT_TRUE(may_write(2));
  EXPECT_TRUE(may_write(3)) << "of which discovery knows nothing";
}

TEST_F(NodeOwnersTest, ProvesASecondWriterByTheOwnerThatIsHeard) {
  join(1, "planner/north");  // killed; its lease goes on
  now_ += 2s;
  join(2, "planner/north@beta");
  join(3, "intruder");
  EXPECT_FALSE(may_write(3));
  now_ += NodeOwners::kProof;
  hear(2);
  const auto challengers = owners_.take_challengers();
  ASSERT_EQ(challengers.size(), 1U);
  EXPECT_TRUE(challengers.front().writer.same_participant(writer_of(3)));
  now_ += 2 * NodeOwners::kSilence;
  EXPECT_FALSE(may_write(3)) << "both are silent, but discovery has lost neither";
}

TEST_F(NodeOwnersTest, RefusesParticipantsOfOtherNames) {
  join(1, "planner/north");
  join(2, "planner/south");
  join(3, "intruder");
  join(4, "planner/north@evil");
  join(5, "planner/northern");
  EXPECT_TRUE(may_write(1));
  for (std::uint8_t other = 2; other <= 6; ++other) EXPECT_FALSE(may_write(other)) << int{other};
  EXPECT_TRUE(may_write(2, "planner/south"));
}

TEST_F(NodeOwnersTest, LetsTheStandbyWriteBesideThePlannerInCharge) {
  join(1, "planner/north");
  join(2, "planner/north@beta");
  EXPECT_TRUE(may_write(1));
  EXPECT_TRUE(may_write(2));
}

TEST_F(NodeOwnersTest, RefusesTheSecondParticipantOfOneNameUntilTheFirstIsSilent) {
  join(1, "planner/north");
  join(2, "planner/north");
  EXPECT_TRUE(may_write(1));
  EXPECT_FALSE(may_write(2));
  now_ += NodeOwners::kSilence;
  EXPECT_FALSE(may_write(2)) << "announcements of the first may be late";
  now_ += 1ms;
  EXPECT_TRUE(may_write(2));
  hear(1);
  EXPECT_FALSE(may_write(2)) << "the first was slow";
  owners_.lost(writer_of(1));
  EXPECT_TRUE(may_write(2));
}

TEST_F(NodeOwnersTest, CountsNoParticipantWithoutAMatchedEndpoint) {
  owners_.found(writer_of(1), "planner/north");
  hear(1);
  join(2, "intruder");
  EXPECT_TRUE(may_write(2)) << "the planner may be one of another cell";
  EXPECT_TRUE(may_write(1)) << "what it writes arrives: it is matched";
  EXPECT_FALSE(may_write(2));
}

TEST_F(NodeOwnersTest, KnowsItsOwnParticipantFirst) {
  join(2, "supervisor");
  owners_.own(writer_of(1), "supervisor");
  owners_.lost(writer_of(1));
  now_ += 1h;
  EXPECT_TRUE(may_write(1, "supervisor"));
  EXPECT_FALSE(may_write(2, "supervisor"));
}

TEST_F(NodeOwnersTest, ReportsAWriterWhoseOwnerGoesOnOnce) {
  join(1, "planner/north");
  join(2, "intruder");
  ASSERT_FALSE(may_write(2));
  EXPECT_TRUE(owners_.take_challengers().empty()) << "its owner may have ended";
  now_ += NodeOwners::kProof;
  hear(1);
  const auto reported = owners_.take_challengers();
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported.front().writer, writer_of(2));
  EXPECT_EQ(reported.front().topic, "GoalStatus");
  EXPECT_EQ(reported.front().key, "north/g");
  EXPECT_TRUE(owners_.take_challengers().empty());
}

TEST_F(NodeOwnersTest, ReportsNoSuccessor) {
  join(1, "planner/north");
  join(3, "planner/north@beta");
  now_ += 100ms;
  join(2, "planner/north");
  ASSERT_FALSE(may_write(2)) << "early";
  now_ += 1s;
  hear(2);
  hear(3);
  EXPECT_TRUE(may_write(2));
  EXPECT_TRUE(owners_.take_challengers().empty());
  owners_.lost(writer_of(1));
  EXPECT_TRUE(owners_.take_challengers().empty());
}

// An intruder under the planner's name waits for the planner's end.
TEST_F(NodeOwnersTest, PrefersASuccessorToAParticipantThatWroteBesideTheFirst) {
  join(1, "planner/north");
  join(2, "planner/north");
  ASSERT_FALSE(may_write(2));
  now_ += NodeOwners::kProof;
  hear(1);
  hear(2);
  ASSERT_EQ(owners_.take_challengers().size(), 1U);
  owners_.lost(writer_of(1));
  join(3, "planner/north");
  EXPECT_TRUE(may_write(3));
  EXPECT_FALSE(may_write(2));
  owners_.lost(writer_of(3));
  EXPECT_TRUE(may_write(2)) << "no other is left";
}

TEST_F(NodeOwnersTest, BoundsItsMemory) {
  for (int i = 0; i < 200; ++i) {
    EndpointId id;
    id.bytes.at(1) = static_cast<std::uint8_t>(i);
    owners_.found(id, "planner/north");
    owners_.matched(id);
    heard_[id] = now_;
  }
  std::size_t refused = 0;
  for (std::uint8_t i = 0; i < 200; ++i) {
    EndpointId id;
    id.bytes.at(1) = i;
    const auto owner = owners_.owner_beside(id, "planner/north", now_);
    if (owner) owners_.note_challenge({id, "Fault", "f"}, *owner, now_);
    refused += owner ? 1 : 0;
  }
  EXPECT_EQ(refused, 199U);
  now_ += NodeOwners::kProof;
  for (auto& [id, heard] : heard_) heard = now_;
  EXPECT_EQ(owners_.take_challengers().size(), NodeOwners::kMostChallengers);
}

}  // namespace
}  // namespace hecaton::bus
