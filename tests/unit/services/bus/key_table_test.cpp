#include "services/bus/key_table.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

class KeyTableTest : public testing::Test {
 protected:
  static EndpointId writer_of(std::uint8_t participant, std::uint8_t entity = 1) {
    EndpointId id;
    id.bytes.front() = participant;
    id.bytes.back() = entity;
    return id;
  }
  bool admits(std::uint8_t participant, const std::string& key, std::size_t bytes = 10) {
    displaced_.clear();
    return table_.admit(key, writer_of(participant), bytes, displaced_);
  }
  /// A participant takes all places that it can get.
  std::size_t flood(std::uint8_t participant, std::size_t bytes = 10) {
    std::size_t admitted = 0;
    for (int i = 0; i < 1000; ++i) {
      admitted += admits(participant, std::to_string(participant) + "-" + std::to_string(i), bytes) ? 1 : 0;
    }
    return admitted;
  }

  KeyTable table_{{.keys = 100, .bytes = 10'000}};
  std::vector<KeyTable::Key> displaced_;
};

TEST_F(KeyTableTest, RefusesFurtherKeysOfTheParticipantWithTheMost) {
  ASSERT_TRUE(admits(1, "north"));
  EXPECT_EQ(flood(2), 99U);
  EXPECT_EQ(table_.keys(), 100U);
  EXPECT_FALSE(admits(2, "more"));
  EXPECT_TRUE(displaced_.empty());
  EXPECT_TRUE(admits(2, "2-5")) << "what it has";
  EXPECT_TRUE(admits(1, "north"));
}

TEST_F(KeyTableTest, HasAPlaceForANewcomer) {
  flood(2);
  ASSERT_TRUE(admits(1, "south"));
  ASSERT_EQ(displaced_.size(), 1U);
  EXPECT_TRUE(displaced_.front().writer.same_participant(writer_of(2)));
  EXPECT_EQ(table_.keys(), 100U);
  flood(3);
  flood(4);
  EXPECT_TRUE(admits(1, "south"));
  EXPECT_TRUE(displaced_.empty()) << "the participant with more keys loses places first";
  EXPECT_EQ(table_.keys(), 100U);
}

TEST_F(KeyTableTest, TakesThePlacesOfThoseThatHaveLeftFirst) {
  ASSERT_TRUE(admits(1, "old"));
  ASSERT_TRUE(admits(3, "living"));
  flood(2);
  table_.left(writer_of(1, 9));
  EXPECT_TRUE(admits(2, "one more"));
  ASSERT_EQ(displaced_.size(), 1U);
  EXPECT_EQ(displaced_.front().text, "old");
  EXPECT_FALSE(admits(2, "and another"));
}

TEST_F(KeyTableTest, GivesTheKeyOfAParticipantThatHasLeftToItsSuccessor) {
  ASSERT_TRUE(admits(1, "north"));
  table_.left(writer_of(1));
  ASSERT_TRUE(admits(5, "north"));
  flood(2);
  EXPECT_FALSE(admits(2, "one more")) << "none has left";
  table_.erase("north");
  EXPECT_TRUE(admits(2, "one more"));
}

TEST_F(KeyTableTest, BoundsTheBytesOfTheNewestSamples) {
  EXPECT_FALSE(admits(1, "large", 10'001));
  ASSERT_TRUE(admits(1, "north", 1000));
  flood(2, 500);
  EXPECT_LE(table_.bytes(), 10'000U);
  EXPECT_TRUE(admits(1, "north", 3000)) << "it has less than the other";
  EXPECT_FALSE(displaced_.empty());
  EXPECT_LE(table_.bytes(), 10'000U);
  EXPECT_FALSE(admits(1, "north", 9900)) << "it would have more";
  EXPECT_TRUE(admits(1, "north", 10));
  for (int i = 0; i < 10'000; ++i) {
    static_cast<void>(
        admits(static_cast<std::uint8_t>(i % 7), std::to_string(i % 331), static_cast<std::size_t>(i * 37 % 4000)));
    ASSERT_LE(table_.bytes(), 10'000U);
    ASSERT_LE(table_.keys(), 100U);
  }
}

}  // namespace
}  // namespace hecaton::bus
