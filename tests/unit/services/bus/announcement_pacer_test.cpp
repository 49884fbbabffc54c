#include "services/bus/announcement_pacer.hpp"

#include <initializer_list>

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

constexpr Clock::time_point kBeginning{1h};
constexpr AnnouncementPacer::Address kPeerAddress = 0x0A00'0002'1D04;  // 10.0.0.2
constexpr AnnouncementPacer::Address kOtherAddress = 0x0A00'0003'1D04;
constexpr AnnouncementPacer::Address kGroup = 0xEFFF'0001'1CE8;  // 239.255.0.1

/// A header, then one submessage of this kind and writer after INFO_DST and INFO_TS.
std::vector<std::uint8_t> datagram(std::uint8_t kind, std::initializer_list<std::uint8_t> writer) {
  std::vector<std::uint8_t> bytes(20);
  const auto submessage = [&](std::uint8_t id, std::uint8_t size) {
    bytes.insert(bytes.end(), {id, 1, size, 0});
    bytes.resize(bytes.size() + size);
  };
  submessage(0x0E, 12);
  submessage(0x09, 8);
  submessage(kind, 200);
  std::copy(writer.begin(), writer.end(), bytes.end() - 200 + 8);
  return bytes;
}

std::span<const std::uint8_t> head(const std::vector<std::uint8_t>& bytes) {
  return {bytes.data(), std::min(bytes.size(), AnnouncementPacer::kHead)};
}

TEST(AnnouncementPacer, SendsTwoInALeaseToAPeer) {
  AnnouncementPacer pacer(2s, true);
  int sent = 0;
  for (auto now = kBeginning; now < kBeginning + 20s; now += 200ms) sent += pacer.is_due(kPeerAddress, now) ? 1 : 0;
  EXPECT_EQ(sent, 20);
  EXPECT_TRUE(pacer.is_due(kOtherAddress, kBeginning));
}

TEST(AnnouncementPacer, SendsAtOnceToAPeerThatWasFound) {
  AnnouncementPacer pacer(2s, true);
  EXPECT_TRUE(pacer.is_due(kPeerAddress, kBeginning));
  EXPECT_FALSE(pacer.is_due(kPeerAddress, kBeginning + 1ms));
  pacer.restart({kPeerAddress});
  EXPECT_TRUE(pacer.is_due(kPeerAddress, kBeginning + 2ms));
  EXPECT_FALSE(pacer.is_due(kPeerAddress, kBeginning + 3ms));
}

TEST(AnnouncementPacer, SendsAllByMulticastAndWithoutIt) {
  AnnouncementPacer with(2s, true);
  AnnouncementPacer without(2s, false);
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(with.is_due(kGroup, kBeginning));
    EXPECT_TRUE(without.is_due(kPeerAddress, kBeginning));
  }
}

TEST(AnnouncementPacer, SendsWhenItKnowsTooManyAddresses) {
  AnnouncementPacer pacer(2s, true);
  for (AnnouncementPacer::Address i = 0; i < 10'000; ++i)
    EXPECT_TRUE(pacer.is_due(kPeerAddress + (i << 16U), kBeginning));
  EXPECT_TRUE(pacer.is_due(kPeerAddress, kBeginning + 1s)) << "the former ones are forgotten";
  EXPECT_FALSE(pacer.is_due(kPeerAddress, kBeginning + 1s));
}

TEST(AnnouncementPacer, KnowsAnnouncementsByTheirWriter) {
  EXPECT_TRUE(AnnouncementPacer::is_announcement(head(datagram(0x15, {0, 1, 0, 0xC2}))));
  EXPECT_FALSE(AnnouncementPacer::is_announcement(head(datagram(0x15, {0, 0, 3, 0xC2})))) << "of a writer";
  EXPECT_FALSE(AnnouncementPacer::is_announcement(head(datagram(0x15, {0, 0, 5, 2})))) << "a sample";
  EXPECT_FALSE(AnnouncementPacer::is_announcement(head(datagram(0x07, {0, 1, 0, 0xC2})))) << "a heartbeat";
  const auto whole = datagram(0x15, {0, 1, 0, 0xC2});
  for (std::size_t size = 0; size < 60; ++size) EXPECT_FALSE(AnnouncementPacer::is_announcement({whole.data(), size}));
}

}  // namespace
}  // namespace hecaton::bus
