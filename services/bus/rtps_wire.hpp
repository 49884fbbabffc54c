#pragma once
/// Numbers of the wire protocol of DDS (RTPS 2.2) that the checks of datagrams need. Private to services/bus; standard
/// library only.

#include <array>
#include <cstddef>
#include <cstdint>

namespace hecaton::bus::wire {

// RTPS 2.2, section 9.4.5.
namespace submessage {
enum Id : std::uint8_t {
  kAckNack = 0x06,
  kHeartbeat = 0x07,
  kGap = 0x08,
  kInfoTimestamp = 0x09,
  kInfoSource = 0x0C,
  kNackFragments = 0x12,
  kHeartbeatFragments = 0x13,
  kData = 0x15,
  kDataFragment = 0x16,
  kPad = 0x01,
  kInfoReply4 = 0x0D,
  kInfoDestination = 0x0E,
  kInfoReply = 0x0F,
  // DDS Security 1.1, section 7.3.6.2.
  kSecureBody = 0x30,
  kSecurePrefix = 0x31,
  kSecurePostfix = 0x32,
  kSecureMessage = 0x33,
  // Of Fast DDS, which ends each of its datagrams with one.
  kStatistics = 0x80,
  kFirstOfVendors = kStatistics
};
}  // namespace submessage
namespace flag {
inline constexpr std::uint8_t kLittleEndian = 1;
inline constexpr std::uint8_t kParameters = 2;
inline constexpr std::uint8_t kPayload = 4;
inline constexpr std::uint8_t kKeyOnly = 8;
}  // namespace flag
/// Of parameter lists, section 9.6.2.2.2.
namespace parameter {
inline constexpr std::uint16_t kEnd = 0x0001;
inline constexpr std::uint16_t kParticipantGuid = 0x0050;
inline constexpr std::uint16_t kEndpointGuid = 0x005A;
inline constexpr std::uint16_t kKeyHash = 0x0070;
inline constexpr std::uint16_t kStatus = 0x0071;
}  // namespace parameter
/// The writer with which each participant announces itself (SPDP), section 9.3.1.3.
inline constexpr std::array<std::uint8_t, 4> kAnnouncer{0x00, 0x01, 0x00, 0xC2};
/// Those that announce its writers and readers (SEDP), section 9.3.1.4.
inline constexpr std::array<std::uint8_t, 4> kWriterAnnouncer{0x00, 0x00, 0x03, 0xC2};
inline constexpr std::array<std::uint8_t, 4> kReaderAnnouncer{0x00, 0x00, 0x04, 0xC2};
/// The writer of handshakes, DDS Security 1.1, section 7.4.6.1.
inline constexpr std::array<std::uint8_t, 4> kAuthenticator{0x00, 0x02, 0x01, 0xC3};
/// Of the last byte of an endpoint's identifier: neither bit is set in those of users (RTPS 2.2, section 9.3.1.2).
inline constexpr std::uint8_t kBuiltin = 0xC0;
inline constexpr std::size_t kHeader = 20;  ///< of a datagram [byte]

}  // namespace hecaton::bus::wire
