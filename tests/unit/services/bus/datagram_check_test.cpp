#include "services/bus/datagram_check.hpp"

#include <initializer_list>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/rtps_datagram.hpp"

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;
using test::RtpsDatagram;

constexpr std::int64_t kHuge = std::int64_t{1} << 62;

class DatagramCheckTest : public testing::Test {
 protected:
  static constexpr DatagramCheck::Address kSource = 11;
  static constexpr DatagramCheck::Address kOther = 22;

  bool refused(const RtpsDatagram& datagram, DatagramCheck::Address source = kSource) {
    return check_.refuse(datagram.bytes(), source, now_, stall_ended_).has_value();
  }

  /// Receives a stream of 500 Hz.
  void receive_stream(std::int64_t first, std::int64_t last) {
    for (std::int64_t number = first; number <= last; ++number) {
      ASSERT_FALSE(refused(RtpsDatagram().data(number))) << number;
      now_ += 2ms;
    }
  }

  DatagramCheck check_;
  Clock::time_point now_{100s};
  std::optional<Clock::time_point> stall_ended_;
};

TEST_F(DatagramCheckTest, PassesWhatAStreamSends) {
  for (std::int64_t number = 1; number < 5000; number += 7) {
    EXPECT_FALSE(refused(RtpsDatagram().data(number)));
    EXPECT_FALSE(refused(RtpsDatagram().heartbeat(std::max<std::int64_t>(1, number - 3), number)));
    EXPECT_FALSE(refused(RtpsDatagram().gap(number, number + 2)));
    EXPECT_FALSE(refused(RtpsDatagram().acknowledgement(number, 32)));
  }
  EXPECT_FALSE(refused(RtpsDatagram().heartbeat(1, 0))) << "a writer without samples";
  EXPECT_FALSE(refused(RtpsDatagram().fragment(5000, 1, 1, 60'000, 200'000)));
}

TEST_F(DatagramCheckTest, PassesOtherProtocols) {
  EXPECT_EQ(check_.refuse({}, kSource, now_), std::nullopt);
  const std::vector<std::uint8_t> other(100, 7);
  EXPECT_EQ(check_.refuse(other, kSource, now_), std::nullopt);
}

TEST_F(DatagramCheckTest, RefusesAbsurdRanges) {
  EXPECT_TRUE(refused(RtpsDatagram().gap(1, 2'000'000'000)));
  EXPECT_TRUE(refused(RtpsDatagram().gap(1, 1'000'000)));
  EXPECT_TRUE(refused(RtpsDatagram().gap(0, 1)));
  EXPECT_TRUE(refused(RtpsDatagram().gap(5, 4)));
  EXPECT_TRUE(refused(RtpsDatagram().gap(-5, -4)));
  EXPECT_TRUE(refused(RtpsDatagram().heartbeat(kHuge, kHuge)));
  EXPECT_TRUE(refused(RtpsDatagram().heartbeat(1, std::numeric_limits<std::int64_t>::max())));
  EXPECT_TRUE(refused(RtpsDatagram().heartbeat(0, 1)));
  EXPECT_TRUE(refused(RtpsDatagram().heartbeat(9, 5)));
  EXPECT_TRUE(refused(RtpsDatagram().data(0)));
  EXPECT_TRUE(refused(RtpsDatagram().data(-1)));
  EXPECT_TRUE(refused(RtpsDatagram().data(std::numeric_limits<std::int64_t>::max())));
  EXPECT_TRUE(refused(RtpsDatagram().acknowledgement(1, 100'000)));
  EXPECT_TRUE(refused(RtpsDatagram().acknowledgement(std::numeric_limits<std::int64_t>::max(), 0)));
}

TEST_F(DatagramCheckTest, RefusesAbsurdFragments) {
  EXPECT_TRUE(refused(RtpsDatagram().fragment(1, 1, 1, 60'000, 0xFFFFFFFF))) << "4 GiB";
  EXPECT_TRUE(refused(RtpsDatagram().fragment(1, 0, 1, 60'000, 200'000)));
  EXPECT_TRUE(refused(RtpsDatagram().fragment(1, 5, 1, 60'000, 200'000))) << "the fifth of four";
  EXPECT_TRUE(refused(RtpsDatagram().fragment(1, 1, 5, 60'000, 200'000)));
  EXPECT_TRUE(refused(RtpsDatagram().fragment(1, 1, 1, 0, 200'000)));
  EXPECT_TRUE(refused(RtpsDatagram().fragment(1, 0xFFFFFFFF, 0xFFFF, 1, 10)));
}

TEST_F(DatagramCheckTest, RefusesLeapsOfAWriter) {
  ASSERT_FALSE(refused(RtpsDatagram().data(5))) << "an old sample for a late joiner";
  ASSERT_FALSE(refused(RtpsDatagram().data(1'000'000))) << "the newest one";
  EXPECT_FALSE(refused(RtpsDatagram().gap(6, 999'999))) << "there is nothing in between";
  now_ += 1500ms;
  ASSERT_FALSE(refused(RtpsDatagram().data(1'000'001)));
  now_ += 900ms;
  EXPECT_FALSE(refused(RtpsDatagram().data(1'000'500)));
  EXPECT_TRUE(refused(RtpsDatagram().data(1'000'500 + DatagramCheck::kLeap + 1)));
  EXPECT_TRUE(refused(RtpsDatagram().heartbeat(1, 3'000'000)));
  EXPECT_FALSE(refused(RtpsDatagram().data(1'000'501))) << "the stream itself goes on";
  now_ += 2s;
  EXPECT_FALSE(refused(RtpsDatagram().data(1'000'501 + DatagramCheck::kLeap + 1))) << "the writer was not received";
  EXPECT_TRUE(refused(RtpsDatagram().data(1'000'501 + 2 * DatagramCheck::kLeapAfterPause)));
  check_.forget(RtpsDatagram::prefix());
  EXPECT_FALSE(refused(RtpsDatagram().data(100'000'000))) << "found again";
}

TEST_F(DatagramCheckTest, AcceptsWhatAnotherThreadReceivedEarlier) {
  ASSERT_FALSE(refused(RtpsDatagram().data(1)));
  now_ += 3s;
  ASSERT_FALSE(refused(RtpsDatagram().data(1)));
  now_ -= 200ms;
  EXPECT_FALSE(refused(RtpsDatagram().data(1))) << "its thread had to wait after it had read the clock";
  now_ += 400ms;
  EXPECT_TRUE(refused(RtpsDatagram().data(2 + DatagramCheck::kLeap + 200)));
}

// During a stall the receive buffer keeps the first samples. Those that follow are lost, and the rest comes at once.
TEST_F(DatagramCheckTest, AcceptsABurstWithLostSamplesAfterAStall) {
  receive_stream(1, 1500);
  now_ += 900ms;
  stall_ended_ = now_;
  for (std::int64_t number = 1501; number <= 1670; ++number) {
    now_ += 20us;
    ASSERT_FALSE(refused(RtpsDatagram().data(number))) << number;
  }
  EXPECT_TRUE(refused(RtpsDatagram().data(1670 + DatagramCheck::kLeapAfterPause))) << "no stall explains it";
  EXPECT_TRUE(refused(RtpsDatagram().data(2500))) << "more than twice what the writer has sent";
  EXPECT_FALSE(refused(RtpsDatagram().data(1951))) << "280 samples were lost";
  receive_stream(1952, 2600);
  EXPECT_TRUE(refused(RtpsDatagram().data(2600 + DatagramCheck::kLeap + 10))) << "the stall is long ago";
}

TEST_F(DatagramCheckTest, RefusesTheSameBurstWithoutAStall) {
  receive_stream(1, 1500);
  now_ += 900ms;
  ASSERT_FALSE(refused(RtpsDatagram().data(1501)));
  EXPECT_TRUE(refused(RtpsDatagram().data(1951)));
}

// The second stall begins while samples of the first one still wait in the buffer.
TEST_F(DatagramCheckTest, AcceptsABurstAfterStallsThatFollowOneAnother) {
  receive_stream(1, 1500);
  now_ += 800ms;
  stall_ended_ = now_;
  ASSERT_FALSE(refused(RtpsDatagram().data(1501)));
  now_ += 60ms;
  stall_ended_ = now_;
  EXPECT_FALSE(refused(RtpsDatagram().data(1502)));
  EXPECT_FALSE(refused(RtpsDatagram().data(1930)));
}

TEST(ReceptionStallTest, IsALongTimeBetweenReads) {
  ReceptionStall stall;
  Clock::time_point now{100s};
  stall.read(now);
  stall.read(now += ReceptionStall::kStall);
  EXPECT_EQ(stall.ended(), std::nullopt);
  stall.read(now += ReceptionStall::kStall + 1ms);
  EXPECT_EQ(stall.ended(), now);
  const Clock::time_point ended = now;
  stall.read(now += 1ms);
  EXPECT_EQ(stall.ended(), ended);
}

// A reader looks for each sample that a writer lists: for 2³² of them it takes a minute.
TEST_F(DatagramCheckTest, RefusesHeartbeatsThatListTooManySamples) {
  constexpr std::int64_t kMost = DatagramCheck::kMostListed;
  constexpr std::int64_t kFirst = DatagramCheck::kFirst;
  const auto of = [](std::uint32_t writer) { return RtpsDatagram().writer(writer); };
  EXPECT_TRUE(refused(of(0x102).heartbeat(1, kFirst))) << "the first one of a writer";
  EXPECT_TRUE(refused(of(0x102).heartbeat(1, kMost + 1)));
  EXPECT_FALSE(refused(of(0x102).heartbeat(1, kMost)));
  EXPECT_TRUE(refused(of(0x102).heartbeat(1, kMost + 1))) << "a later one";
  EXPECT_TRUE(refused(of(0x102).data(kMost + 1))) << "the reader would look for all before it, too";
  EXPECT_TRUE(refused(of(0x102).data(kFirst)));

  ASSERT_FALSE(refused(of(0x202).data(kFirst)));
  EXPECT_TRUE(refused(of(0x202).heartbeat(1, 10))) << "2³² samples before the one that the reader has";
  EXPECT_TRUE(refused(of(0x202).gap(1, 100'000)));
  EXPECT_FALSE(refused(of(0x202).heartbeat(kFirst - 3, kFirst))) << "the writer itself goes on";
  EXPECT_FALSE(refused(of(0x202).gap(kFirst - 2, kFirst - 1)));
}

// The writer of a stream of 500 Hz has sent for two months, and keeps the last sample of a key that was written half
// an hour ago.
TEST_F(DatagramCheckTest, PassesWhatALateJoinerGetsOfALongStream) {
  constexpr std::int64_t kOld = 3'000'000'000;
  std::int64_t last = kOld + 900'000;
  ASSERT_FALSE(refused(RtpsDatagram().heartbeat(kOld, last)));
  EXPECT_FALSE(refused(RtpsDatagram().data(kOld).gap(kOld + 1, last - 1).data(last)));
  // The key is not written again.
  for (int second = 0; second < 3000; ++second) {
    now_ += 1s;
    for (int i = 0; i < 10; ++i) ASSERT_FALSE(refused(RtpsDatagram().data(last += 50))) << last - kOld;
    ASSERT_FALSE(refused(RtpsDatagram().heartbeat(kOld, last))) << last - kOld;
  }
  EXPECT_GT(last - kOld, 2 * DatagramCheck::kMostListed);
}

TEST_F(DatagramCheckTest, RefusesOtherSocketsThanThoseOfTheParticipant) {
  ASSERT_FALSE(refused(RtpsDatagram().data(1)));
  ASSERT_FALSE(refused(RtpsDatagram().data(2), kOther)) << "it has two";
  now_ += ParticipantSources::kSettling + 1s;
  EXPECT_FALSE(refused(RtpsDatagram().data(3)));
  EXPECT_FALSE(refused(RtpsDatagram().data(4), kOther));
  EXPECT_TRUE(refused(RtpsDatagram().data(5), 33));
  EXPECT_TRUE(refused(RtpsDatagram().heartbeat(1, 40), 33));
  EXPECT_FALSE(refused(RtpsDatagram({9}).data(5), 33)) << "another participant";
  check_.forget(RtpsDatagram::prefix());
  EXPECT_TRUE(refused(RtpsDatagram().data(6), 33)) << "found again, but it had not left";
  check_.unbind(RtpsDatagram::prefix());
  EXPECT_FALSE(refused(RtpsDatagram().data(6), 33)) << "it has left";
}

TEST_F(DatagramCheckTest, AcceptsNewSocketsOfAParticipantThatWasSilent) {
  ASSERT_FALSE(refused(RtpsDatagram().data(1)));
  now_ += ParticipantSources::kSilence;
  EXPECT_TRUE(refused(RtpsDatagram().data(2), kOther));
  now_ += 1s;
  EXPECT_FALSE(refused(RtpsDatagram().data(2), kOther));
  now_ += ParticipantSources::kSettling + 1s;
  EXPECT_TRUE(refused(RtpsDatagram().data(3)));
}

RtpsDatagram::Prefix invented(std::size_t i) {
  return {7, static_cast<std::uint8_t>(i >> 16U), static_cast<std::uint8_t>(i >> 8U), static_cast<std::uint8_t>(i)};
}

TEST_F(DatagramCheckTest, BoundsTheSocketsOfAParticipantAndTheParticipantsOfASocket) {
  for (std::size_t i = 0; i < ParticipantSources::kSockets; ++i) ASSERT_FALSE(refused(RtpsDatagram().data(1), 100 + i));
  EXPECT_TRUE(refused(RtpsDatagram().data(1), 99));
  for (std::size_t i = 0; i < ParticipantSources::kSpokenFor; ++i) {
    ASSERT_FALSE(refused(RtpsDatagram(invented(i)).data(1), kOther));
    check_.found(invented(i));
  }
  EXPECT_TRUE(refused(RtpsDatagram({8}).data(1), kOther));
  EXPECT_FALSE(refused(RtpsDatagram({8}).data(1), 98)) << "of another socket";
  check_.unbind(invented(3));
  EXPECT_FALSE(refused(RtpsDatagram({8, 1}).data(1), kOther)) << "one has left";
}

// Participants that discovery never finds cost an intruder a datagram each.
TEST_F(DatagramCheckTest, HasAPlaceForEachNewParticipantWhateverWasInvented) {
  const RtpsDatagram::Prefix known = RtpsDatagram::prefix();
  ASSERT_FALSE(refused(RtpsDatagram(known).data(1)));
  check_.found(known);
  now_ += ParticipantSources::kSettling + 1s;
  for (std::size_t i = 0; i < 100'000; ++i) {
    ASSERT_FALSE(refused(RtpsDatagram(invented(i)).data(1), i % 16)) << i;
  }
  EXPECT_FALSE(refused(RtpsDatagram({8}).data(1), kOther)) << "a process that starts";
  EXPECT_FALSE(refused(RtpsDatagram(known).data(2)));
  EXPECT_TRUE(refused(RtpsDatagram(known).data(3), kOther)) << "what is bound stays bound";
}

TEST_F(DatagramCheckTest, BindsAParticipantThatWasFoundAfterItsPlaceWasLost) {
  ASSERT_FALSE(refused(RtpsDatagram().data(1)));
  for (std::size_t i = 0; i < 2 * ParticipantSources::kUnknown; ++i) {
    ASSERT_FALSE(refused(RtpsDatagram(invented(i)).data(1), kOther));
  }
  check_.found(RtpsDatagram::prefix());
  EXPECT_FALSE(refused(RtpsDatagram().data(2)));
  now_ += ParticipantSources::kSettling + 1s;
  EXPECT_TRUE(refused(RtpsDatagram().data(3), kOther));
  EXPECT_FALSE(refused(RtpsDatagram().data(3)));
}

// The reader would look for 2³² samples of a writer whose number was forgotten, or never noted.
TEST_F(DatagramCheckTest, KnowsTheNumbersOfAWriterAmongManyOthers) {
  constexpr std::int64_t kFirst = DatagramCheck::kFirst;
  const auto of = [](std::size_t writer) {
    return RtpsDatagram().writer(static_cast<std::uint32_t>(writer << 8U | 2U));
  };
  for (std::size_t i = 0; i < 10'000; ++i) ASSERT_FALSE(refused(RtpsDatagram(invented(i)).data(1), kOther));
  for (std::size_t i = 0; i < 10'000; ++i) ASSERT_FALSE(refused(of(100 + i).data(1)));
  ASSERT_FALSE(refused(of(1).data(kFirst)));
  EXPECT_TRUE(refused(of(1).heartbeat(1, 10)));
  for (std::size_t i = 0; i < 10'000; ++i) {
    now_ += 1ms;
    ASSERT_FALSE(refused(of(20'000 + i).data(1)));
  }
  EXPECT_TRUE(refused(of(1).heartbeat(1, 10))) << "it was not forgotten";
  for (std::size_t i = 0; i < 2 * DatagramCheck::kWriters; ++i) static_cast<void>(refused(of(40'000 + i).data(kFirst)));
  EXPECT_TRUE(refused(of(1).heartbeat(1, 10)));
  EXPECT_TRUE(refused(of(50'000).data(1))) << "no place, as all have great numbers";
}

TEST_F(DatagramCheckTest, RefusesDiscoveryOfAnotherParticipant) {
  constexpr RtpsDatagram::Prefix kVictim{9, 9, 9};
  const RtpsDatagram::Prefix own = RtpsDatagram::prefix();
  ASSERT_FALSE(refused(RtpsDatagram(kVictim).data(1), kOther));
  now_ += ParticipantSources::kSettling + 1s;
  ASSERT_FALSE(refused(RtpsDatagram(kVictim).data(2), kOther)) << "it lives";
  for (const std::uint32_t writer : {0x000100C2U, 0x000003C2U, 0x000004C2U}) {
    for (const std::uint16_t identifier : std::initializer_list<std::uint16_t>{0x50, 0x5A, 0x70}) {
      for (const bool inlined : {false, true}) {
        const auto speaks_of = [&](const RtpsDatagram::Prefix& named) {
          return RtpsDatagram().writer(writer).discovery(1, identifier, named, inlined);
        };
        EXPECT_FALSE(refused(speaks_of(own)));
        EXPECT_TRUE(refused(speaks_of(kVictim))) << std::hex << writer << ' ' << identifier << ' ' << inlined;
        EXPECT_FALSE(refused(speaks_of({9, 9, 8}))) << "a participant of the same process, as Cyclone DDS may do";
      }
    }
  }
  EXPECT_FALSE(refused(RtpsDatagram().writer(0x00000102).discovery(1, 0x50, kVictim))) << "a topic's sample";
  EXPECT_TRUE(refused(RtpsDatagram().data(1).writer(0x000003C2).discovery(2, 0x5A, kVictim))) << "the second of two";
}

TEST_F(DatagramCheckTest, RefusesSubmessagesForOthersAndBeyondTheEnd) {
  EXPECT_TRUE(refused(RtpsDatagram().submessage(0x0C, std::vector<std::uint8_t>(20))));
  const RtpsDatagram::Prefix own = RtpsDatagram::prefix();
  std::vector<std::uint8_t> sender(8);
  sender.insert(sender.end(), own.begin(), own.end());
  EXPECT_FALSE(refused(RtpsDatagram().submessage(0x0C, sender))) << "a signed message names its sender";
  auto cut = RtpsDatagram().heartbeat(1, 5).bytes();
  cut.resize(cut.size() - 3);
  EXPECT_TRUE(check_.refuse(cut, kSource, now_));
}

// Fast DDS aborts the process when statistics stand elsewhere.
TEST_F(DatagramCheckTest, AcceptsStatisticsAtTheEndOnly) {
  const std::vector<std::uint8_t> statistics(56);
  EXPECT_FALSE(refused(RtpsDatagram().data(1).submessage(0x80, statistics)));
  EXPECT_TRUE(refused(RtpsDatagram().submessage(0x80, statistics).data(2)));
  EXPECT_TRUE(refused(RtpsDatagram().submessage(0x80, statistics).submessage(0x80, statistics)));
}

// As Fast DDS does: what stands between two submessages would otherwise hide the second one.
TEST_F(DatagramCheckTest, LooksForSubmessagesAtMultiplesOfFourBytes) {
  std::vector<std::uint8_t> hides(5);
  auto bytes = RtpsDatagram().submessage(0x01, hides).bytes();
  bytes.insert(bytes.end(), 3, 0);
  const auto second = RtpsDatagram().heartbeat(std::int64_t{1} << 62, std::int64_t{1} << 62).bytes();
  bytes.insert(bytes.end(), second.begin() + 20, second.end());
  EXPECT_TRUE(check_.refuse(bytes, kSource, now_));
}

TEST_F(DatagramCheckTest, RecognisesAnAnnouncedDeparture) {
  const auto departs = [](const RtpsDatagram& datagram) {
    return DatagramCheck::announces_departure(datagram.bytes());
  };
  constexpr std::uint16_t kStatus = 0x71;
  constexpr std::uint16_t kKeyHash = 0x70;
  EXPECT_FALSE(departs(RtpsDatagram().announcement({}, 4)));
  EXPECT_FALSE(departs(RtpsDatagram().announcement({{kKeyHash, 7}}, 4)));
  EXPECT_FALSE(departs(RtpsDatagram().data(1))) << "of another writer";
  EXPECT_TRUE(departs(RtpsDatagram().announcement({}, 8))) << "a key without data";
  EXPECT_TRUE(departs(RtpsDatagram().announcement({{kStatus, 0x03000000}}, 8)));
  EXPECT_TRUE(departs(RtpsDatagram().announcement({{kKeyHash, 7}, {kStatus, 0x03000000}}, 4)));
  EXPECT_TRUE(departs(RtpsDatagram().heartbeat(1, 2).announcement({{kStatus, 0x01000000}})));
  EXPECT_TRUE(refused(RtpsDatagram().writer(0x000100C2).fragment(1, 1, 1, 100, 300)));
}

TEST_F(DatagramCheckTest, TellsWhatIsNotEncrypted) {
  using Protection = DatagramCheck::Protection;
  const auto protection = [](const RtpsDatagram& datagram) { return DatagramCheck::protection(datagram.bytes()); };
  const auto secure = [] { return RtpsDatagram().submessage(0x33, std::vector<std::uint8_t>(24)); };
  EXPECT_EQ(protection(secure()), Protection::kNotNeeded);
  EXPECT_EQ(protection(RtpsDatagram().announcement({{0x70, 7}}, 4).submessage(0x80, {1, 2, 3, 4})),
            Protection::kNotNeeded)
      << "with statistics of Fast DDS";
  EXPECT_EQ(protection(RtpsDatagram().submessage(0x09, std::vector<std::uint8_t>(8)).writer(0x000201C3).data(1)),
            Protection::kNotNeeded)
      << "a handshake";
  EXPECT_EQ(protection(RtpsDatagram().submessage(0x31, std::vector<std::uint8_t>(20))), Protection::kNotNeeded);

  EXPECT_EQ(protection(RtpsDatagram().writer(0x000003C2).heartbeat(1, 2)), Protection::kMissing) << "open discovery";
  for (const auto& forged : {RtpsDatagram().data(1), RtpsDatagram().heartbeat(1, 2), RtpsDatagram().gap(1, 3),
                             RtpsDatagram().acknowledgement(1, 32), RtpsDatagram().fragment(1, 1, 1, 100, 300),
                             RtpsDatagram().announcement({}).data(1), RtpsDatagram().submessage(0x12, {1, 2})}) {
    EXPECT_EQ(protection(forged), Protection::kForged);
  }
  auto behind = RtpsDatagram().submessage(0x09, std::vector<std::uint8_t>(8));
  behind.submessage(0x33, std::vector<std::uint8_t>(24)).data(1);
  EXPECT_EQ(protection(behind), Protection::kForged) << "Fast DDS would read it as it stands";
  auto cut = RtpsDatagram().gap(1, 3).bytes();
  cut.resize(cut.size() - 3);
  EXPECT_EQ(DatagramCheck::protection(cut), Protection::kForged);
}

TEST_F(DatagramCheckTest, SurvivesRandomAndTruncatedDatagrams) {
  std::mt19937_64 random(7);
  const auto model =
      RtpsDatagram().data(1).heartbeat(1, 2).gap(1, 3).fragment(2, 1, 1, 100, 300).announcement({{0x70, 1}}).bytes();
  for (int i = 0; i < 200'000; ++i) {
    auto bytes = model;
    for (int flips = 0; flips < 4; ++flips)
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
    bytes.resize(random() % (bytes.size() + 1));
    static_cast<void>(check_.refuse(bytes, kSource, now_));
    static_cast<void>(DatagramCheck::announces_departure(bytes));
    static_cast<void>(DatagramCheck::protection(bytes));
  }
}

}  // namespace
}  // namespace hecaton::bus
