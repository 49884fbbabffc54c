// An intruder floods all processes of a cell with malformed datagrams, without and with keys. No arm moves, no process
// ends, memory does not grow, and the cell runs again when the flood has ceased.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "services/bus/participant_sources.hpp"
#include "services/security/keystore.hpp"
#include "tests/cell/intruder/flood.hpp"
#include "tests/cell/intruder/intruder.hpp"
#include "tests/support/rtps_datagram.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wiretap.hpp"

namespace hecaton::test {
namespace {

/// Datagrams that an intruder makes of those that it has recorded.
class Forger {
 public:
  explicit Forger(std::vector<Bytes> recorded) : recorded_(std::move(recorded)) {
    recorded_.push_back(RtpsDatagram().data(1).heartbeat(1, 2).gap(1, 3).fragment(2, 1, 1, 100, 300).bytes());
    recorded_.push_back(RtpsDatagram().announcement({{0x70, 7}, {0x15, 0xFFFFFFFF}}).bytes());
  }

  Bytes next() {
    switch (mutator_.below(6)) {
      case 0:
      case 1:
        return crafted();
      case 2:
        return of_another_participant();
      default:
        return mutator_.mutated(any());
    }
  }

 private:
  const Bytes& any() { return recorded_[mutator_.below(recorded_.size())]; }

  /// A recorded datagram as if a participant had sent it that does not exist.
  Bytes of_another_participant() {
    Bytes bytes = any();
    if (bytes.size() < kHeader) return bytes;
    RtpsDatagram::Prefix real{};
    std::copy_n(bytes.begin() + kPrefixAt, real.size(), real.begin());
    RtpsDatagram::Prefix other = real;
    for (std::size_t i = 4; i < other.size(); ++i) other[i] = static_cast<std::uint8_t>(mutator_.below(256));
    for (auto at = bytes.begin();;) {
      at = std::search(at, bytes.end(), real.begin(), real.end());
      if (at == bytes.end()) return bytes;
      at = std::copy(other.begin(), other.end(), at);
    }
  }

  Bytes crafted() {
    RtpsDatagram::Prefix sender = RtpsDatagram::prefix();
    const Bytes& real = any();
    if (real.size() >= kHeader && mutator_.below(2) == 0) {
      std::copy_n(real.begin() + kPrefixAt, sender.size(), sender.begin());
    }
    RtpsDatagram datagram(sender);
    datagram.writer(kWriters.at(mutator_.below(kWriters.size())));
    const auto number = [&] { return kNumbers.at(mutator_.below(kNumbers.size())); };
    switch (mutator_.below(7)) {
      case 0:
        return datagram.heartbeat(number(), number(), 0x7FFFFFFF).bytes();
      case 1:
        return datagram.gap(number(), number(), static_cast<std::uint32_t>(number())).bytes();
      case 2:
        return datagram.data(number(), mutator_.random_bytes(200)).bytes();
      case 3:
        return datagram.fragment(number(), static_cast<std::uint32_t>(number()), 1, 60'000, 0xFFFFFFFF).bytes();
      case 4:
        return datagram.acknowledgement(number(), static_cast<std::uint32_t>(number())).bytes();
      case 5: {  // discovery of a participant that lives, or its end
        RtpsDatagram::Prefix named = sender;
        const Bytes& other = any();
        if (other.size() >= kHeader) std::copy_n(other.begin() + kPrefixAt, named.size(), named.begin());
        return datagram.discovery(number(), mutator_.below(2) == 0 ? 0x5A : 0x70, named, mutator_.below(2) == 0)
            .bytes();
      }
      default:
        return datagram.announcement({{static_cast<std::uint16_t>(mutator_.below(0x80)), 0xFFFFFFFF}}).bytes();
    }
  }

  static constexpr std::size_t kHeader = 20;
  static constexpr std::size_t kPrefixAt = 8;
  static constexpr std::array<std::uint32_t, 6> kWriters = {0x000002C2, 0x00000102, 0x00000103,
                                                            0x000003C2, 0x000004C2, 0x000100C2};
  static constexpr std::array<std::int64_t, 6> kNumbers = {
      1, 1'000'000, std::int64_t{1} << 32, std::int64_t{1} << 40, std::int64_t{1} << 62, -1};

  std::vector<Bytes> recorded_;
  Mutator mutator_{34};
};

class DatagramFlood : public Flood {
 protected:
  void flood() {
    // Until each process knows the sockets of all others.
    const auto settled = bus::Clock::now() + bus::ParticipantSources::kSettling + 1s;
    const int first_port = 7400 + 250 * domain_.number();
    std::vector<Bytes> recorded;
    const Wiretap wiretap;
    ASSERT_TRUE(await([&] {
      for (Bytes& datagram : wiretap.take(first_port, first_port + 249)) {
        if (recorded.size() < kRecorded) recorded.push_back(std::move(datagram));
      }
      return bus::Clock::now() > settled && (recorded.size() == kRecorded || !wiretap.listens());
    }));
    Forger forger(std::move(recorded));
    const DatagramSender sender(domain_.number());
    const std::size_t wanted = flood_size();
    const auto began = bus::Clock::now();
    for (std::size_t sent = 0; sent < wanted;) {
      sender.send(forger.next());
      if (++sent % 256 == 0) watch();
    }
    watch();
    std::cout << "the flood took " << std::chrono::duration<double>(bus::Clock::now() - began).count() << " s\n";
    expect_unharmed(wanted);
    EXPECT_TRUE(named_.contains(msg::CauseKind::CAUSE_INPUT_REFUSED));
  }

 private:
  static constexpr std::size_t kRecorded = 2000;
};

TEST_F(DatagramFlood, StopsNoProcess) {
  flood();
}

class SecuredDatagramFlood : public DatagramFlood {
 protected:
  void SetUp() override {
    services::create_keystore(keystore(), std::chrono::days(60));
    services::add_host(keystore(), "localhost", std::chrono::days(30));
    std::ofstream(cell_file())
        << "name: secured\n"
           "security: {keystore: keys}\n"
           // Encryption on a busy machine of two processors: a cell of a lower rate.
           "timing: {control_period: 20ms, driver_period: 4ms, world_period: 20ms, command_timeout: 400ms}\n"
           "supervision: {heartbeat_deadline: 250ms, host_lease: 1s}\n"
           "defaults: {robot: ur5e}\n"
           "arms:\n"
           "  - {name: north, base: {xyz: [0, 0.8, 0]}}\n"
           "  - {name: south, base: {xyz: [0, -0.8, 0]}}\n";
    DatagramFlood::SetUp();
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path() / "cell.yaml"; }
  [[nodiscard]] std::filesystem::path keystore() const { return folder_.path() / "keys"; }
  [[nodiscard]] std::vector<std::string> arms() const override { return {"north", "south"}; }
  [[nodiscard]] bus::ParticipantOptions watching() const override {
    bus::ParticipantOptions options;
    options.partition = "secured";
    options.identity = services::enclave_folder(keystore(), "localhost", services::Role::kViewer);
    return options;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(SecuredDatagramFlood, StopsNoProcess) {
  flood();
}

}  // namespace
}  // namespace hecaton::test
