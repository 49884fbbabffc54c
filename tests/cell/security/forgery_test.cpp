/// Datagrams and identities that an intruder forges, against participants with keys and, as a control, without.

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/supervisor.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"
#include "services/security/certificate.hpp"
#include "services/security/keystore.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/rtps_datagram.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wiretap.hpp"

namespace hecaton::test {
namespace {

namespace fs = std::filesystem;
using services::Role;
constexpr auto kPatience = std::chrono::seconds(60);

/// A socket on another address than the participants have.
class Intruder {
 public:
  Intruder() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in own = address("127.0.0.9", 0);
    bound_ = ::bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0;
  }
  ~Intruder() { ::close(socket_); }
  Intruder(const Intruder&) = delete;
  Intruder& operator=(const Intruder&) = delete;

  [[nodiscard]] bool bound() const { return bound_; }
  /// To the port for user data of each of the first participants of this machine (RTPS 2.2, section 9.6.1.1).
  void send(int domain, const std::vector<std::uint8_t>& datagram) const {
    for (int participant = 0; participant < 4; ++participant) {
      const int port = 7400 + 250 * domain + 11 + 2 * participant;
      const sockaddr_in to = address("127.0.0.1", port);
      static_cast<void>(
          ::sendto(socket_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to));
    }
  }

 private:
  static sockaddr_in address(const char* text, int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, text, &address.sin_addr);
    return address;
  }
  int socket_;
  bool bound_ = false;
};

class Forgery : public testing::Test {
 protected:
  void SetUp() override {
    services::create_keystore(keys_, std::chrono::days(10));
    services::add_host(keys_, "localhost", std::chrono::days(5));
  }
  [[nodiscard]] bus::Participant participant(const std::string& name, std::optional<Role> role) const {
    bus::ParticipantOptions options;
    options.interfaces = {"127.0.0.1"};
    if (role) options.identity = services::enclave_folder(keys_, "localhost", *role);
    return {domain_.number(), name, options};
  }
  [[nodiscard]] static std::optional<bus::Refused> refused(const bus::Participant& participant,
                                                           const std::string& text) {
    const auto all = participant.refused(kPatience, 8);
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const bus::Refused& one) { return one.text.find(text) != std::string::npos; });
    return found == all.end() ? std::nullopt : std::optional(*found);
  }
  static bool await(const std::function<bool()>& condition, bus::Reader<msg::SupervisorRequest>& reader,
                    std::chrono::milliseconds limit = kPatience) {
    const auto until = bus::Clock::now() + limit;
    while (!condition()) {
      if (bus::Clock::now() > until) return false;
      static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
    }
    return true;
  }
  static msg::SupervisorRequest stop(std::uint64_t number) {
    msg::SupervisorRequest request;
    request.client("operator");
    request.request_id(number);
    request.kind(msg::RequestKind::REQUEST_STOP);
    return request;
  }
  /// An operator sends request 1. An intruder sends in its name that samples 2 to 1000 do not exist. Returns the
  /// requests that the supervisor receives after that, while the operator sends 2.
  std::vector<std::uint64_t> received_requests(bool secured) {
    bus::Participant person = participant("operator", secured ? std::optional(Role::kOperator) : std::nullopt);
    bus::Participant supervisor = participant("supervisor", secured ? std::optional(Role::kSupervisor) : std::nullopt);
    bus::Writer<msg::SupervisorRequest> requests(person);
    bus::Reader<msg::SupervisorRequest> reader(supervisor);
    EXPECT_TRUE(requests.wait_matched(1, kPatience));
    EXPECT_TRUE(requests.write(stop(1)));
    EXPECT_TRUE(await([&] { return !reader.take().empty(); }, reader));

    RtpsDatagram::Prefix prefix{};
    const bus::EndpointId id = requests.id();
    std::copy_n(id.bytes.begin(), prefix.size(), prefix.begin());
    std::uint32_t entity = 0;
    for (int i = 12; i < 16; ++i) entity = entity << 8U | id.bytes[i];
    intruder_.send(domain_.number(), RtpsDatagram(prefix).writer(entity).gap(2, 1001).bytes());
    // The supervisor has handled the datagram when it refuses it, or has handled a later one of the operator.
    if (secured) {
      EXPECT_TRUE(await([&] { return refused(supervisor, "not encrypted").has_value(); }, reader));
      EXPECT_EQ(refused(supervisor, "not encrypted")->address, "127.0.0.9");
      EXPECT_EQ(refused(supervisor, "not encrypted")->node, "operator");
    }
    std::vector<std::uint64_t> numbers;
    EXPECT_TRUE(requests.write(stop(2)));
    const auto take = [&] {
      for (const auto& sample : reader.take()) numbers.push_back(sample.value.request_id());
      return !numbers.empty();
    };
    static_cast<void>(await(take, reader, secured ? kPatience : std::chrono::milliseconds(1000)));
    return numbers;
  }

  FreeDomain domain_;
  TemporaryFolder folder_;
  const fs::path keys_ = folder_.path() / "keys";
  Intruder intruder_;
};

TEST_F(Forgery, RefusesDatagramsInTheNameOfAParticipantWithKeys) {
  ASSERT_TRUE(intruder_.bound());
  EXPECT_EQ(received_requests(true), std::vector<std::uint64_t>{2});
}

// What the keys prevent: the forged gap hides the operator's next order.
TEST_F(Forgery, HidesAnOrderFromAnOpenParticipant) {
  ASSERT_TRUE(intruder_.bound());
  EXPECT_TRUE(received_requests(false).empty());
}

// The recorded datagrams are of the planner, encrypted, and arrive once more after it has gone on.
TEST_F(Forgery, IgnoresRecordedDatagrams) {
  const Wiretap wiretap;
  if (!wiretap.listens()) {
    ASSERT_TRUE(may_skip()) << "this user may not record datagrams";
    GTEST_SKIP() << "this user may not record datagrams";
  }
  ASSERT_TRUE(intruder_.bound());
  bus::Participant driver = participant("driver", Role::kDriver);
  bus::Participant planner = participant("planner", Role::kPlanner);
  bus::Reader<msg::ArmCommand> reader(driver, nullptr, {.keys = {"north"}});
  bus::Writer<msg::ArmCommand> writer(planner, {.key = "north"});
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  std::vector<std::uint64_t> received;
  const auto receive = [&](std::uint64_t last) {
    const auto until = bus::Clock::now() + kPatience;
    while ((received.empty() || received.back() != last) && bus::Clock::now() < until) {
      static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
      for (const auto& sample : reader.take()) received.push_back(sample.value.sequence_number());
    }
  };
  const auto send = [&](std::uint64_t number) {
    msg::ArmCommand command;
    command.arm("north");
    command.sequence_number(number);
    EXPECT_TRUE(writer.write(command));
    receive(number);
  };
  const int first_port = 7400 + 250 * domain_.number();
  static_cast<void>(wiretap.take(first_port, first_port + 249));
  for (std::uint64_t number = 1; number <= 5; ++number) send(number);
  const auto recorded = wiretap.take(first_port, first_port + 249);
  ASSERT_GE(recorded.size(), 5U);
  ASSERT_EQ(received, (std::vector<std::uint64_t>{1, 2, 3, 4, 5}));

  for (int round = 0; round < 3; ++round) {
    for (const auto& datagram : recorded) intruder_.send(domain_.number(), datagram);
  }
  send(6);
  EXPECT_EQ(received, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6}));
}

// A viewer whose middleware lets it write commands: it has signed its own permissions, with an authority of its own.
TEST_F(Forgery, RefusesAParticipantWithPermissionsOfItsOwn) {
  const fs::path own = folder_.path() / "own";
  services::create_keystore(own, std::chrono::days(10));
  const fs::path viewer = services::enclave_folder(keys_, "localhost", Role::kViewer);
  const auto certificate = services::pki::read_certificate(viewer / "cert.pem");
  const auto authority = services::pki::read_certificate(own / "public" / "ca.cert.pem");
  const auto key = services::pki::read_key(own / "private" / "ca.key.pem");
  const auto now = std::chrono::system_clock::now();
  const std::string permissions =
      services::permissions_xml(Role::kPlanner, services::pki::subject_of(certificate.get()),
                                now - std::chrono::hours(1), now + std::chrono::hours(24));
  services::pki::write_signed(viewer / "permissions.p7s", permissions, authority.get(), key.get());
  fs::copy_file(own / "public" / "ca.cert.pem", viewer / "permissions_ca.cert.pem",
                fs::copy_options::overwrite_existing);
  fs::copy_file(own / "enclaves" / "governance.p7s", viewer / "governance.p7s", fs::copy_options::overwrite_existing);

  bus::Participant driver = participant("driver", Role::kDriver);
  bus::Reader<msg::ArmCommand> commands(driver, nullptr, {.keys = {"north"}});
  bus::Participant forger = participant("planner/north", Role::kViewer);
  bus::Writer<msg::ArmCommand> forged(forger, {.key = "north"});
  bus::Participant planner = participant("planner/north", Role::kPlanner);
  bus::Writer<msg::ArmCommand> writer(planner, {.key = "north"});
  msg::ArmCommand command;
  command.arm("north");
  // The forger has as long as the planner needed, and three seconds.
  const auto until = bus::Clock::now() + kPatience;
  auto end = until;
  while (bus::Clock::now() < end) {
    static_cast<void>(forged.write(command));
    if (writer.matched() > 0) static_cast<void>(writer.write(command));
    static_cast<void>(commands.wait_for_data(std::chrono::milliseconds(20)));
    if (end == until && commands.latest("north") != nullptr) end = bus::Clock::now() + std::chrono::seconds(3);
  }
  ASSERT_NE(commands.latest("north"), nullptr) << "of the planner";
  EXPECT_TRUE(commands.latest("north")->writer == writer.id());
  EXPECT_EQ(forged.matched(), 0);
  EXPECT_EQ(commands.matched(), 1);
  const auto all = driver.refused(kPatience, 8);
  const auto named = std::find_if(all.begin(), all.end(), [&](const bus::Refused& one) {
    return one.sender.same_participant(forged.id()) && one.text.find("its permissions are not valid") == 0;
  });
  ASSERT_NE(named, all.end());
  EXPECT_EQ(named->node, "planner/north");
}

// What the permissions prevent.
TEST_F(Forgery, CommandsOfAnyParticipantReachAnOpenDriver) {
  bus::Participant driver = participant("driver", std::nullopt);
  bus::Reader<msg::ArmCommand> commands(driver, nullptr, {.keys = {"north"}});
  bus::Participant forger = participant("planner/north", std::nullopt);
  bus::Writer<msg::ArmCommand> forged(forger, {.key = "north"});
  ASSERT_TRUE(forged.wait_matched(1, kPatience));
  msg::ArmCommand command;
  command.arm("north");
  ASSERT_TRUE(forged.write(command));
  const auto until = bus::Clock::now() + kPatience;
  while (commands.latest("north") == nullptr && bus::Clock::now() < until) {
    static_cast<void>(commands.wait_for_data(std::chrono::milliseconds(20)));
  }
  ASSERT_NE(commands.latest("north"), nullptr);
  EXPECT_TRUE(commands.latest("north")->writer == forged.id());
}

}  // namespace
}  // namespace hecaton::test
