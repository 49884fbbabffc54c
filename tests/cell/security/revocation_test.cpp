/// Participants whose keys are revoked while they are connected, and later.

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <openssl/pem.h>

#include "services/bus/endpoint.hpp"
#include "services/security/certificate.hpp"
#include "services/security/keystore.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

namespace fs = std::filesystem;
using services::Role;
constexpr auto kPatience = std::chrono::seconds(60);

class Revocation : public testing::Test {
 protected:
  void SetUp() override {
    services::create_keystore(keys_, std::chrono::days(10));
    services::add_host(keys_, "cell-pc", std::chrono::days(5));
    services::add_host(keys_, "guest-pc", std::chrono::days(5));
    fs::copy(keys_, stolen_, fs::copy_options::recursive);
  }

  [[nodiscard]] static bus::ParticipantOptions options(const fs::path& keystore, const std::string& host, Role role) {
    bus::ParticipantOptions options;
    options.interfaces = {"127.0.0.1"};
    options.identity = services::enclave_folder(keystore, host, role);
    return options;
  }
  /// As services/runtime/join.cpp does it.
  [[nodiscard]] bus::ParticipantOptions watching(Role role) const {
    bus::ParticipantOptions watching = options(keys_, "cell-pc", role);
    watching.revoked = [watch = services::RevocationWatch(watching.identity)]() mutable { return watch.update(); };
    return watching;
  }
  /// Writes states of an arm until `done`, which is evaluated after each reception by `reader` and at least every 20
  /// ms.
  static bool write_until(bus::Writer<msg::ArmState>& states, bus::Reader<msg::ArmState>& reader,
                          const std::function<bool()>& done) {
    const auto until = bus::Clock::now() + kPatience;
    while (!done()) {
      if (bus::Clock::now() > until) return false;
      msg::ArmState state;
      state.arm("north");
      static_cast<void>(states.write(state));
      static_cast<void>(reader.wait_for_data(std::chrono::milliseconds(20)));
    }
    return true;
  }
  [[nodiscard]] static bool refused(const bus::Participant& participant, const std::string& text) {
    const auto all = participant.refused(kPatience, 8);
    return std::any_of(all.begin(), all.end(),
                       [&](const bus::Refused& one) { return one.text.find(text) != std::string::npos; });
  }

  /// Makes the certificate of an identity end after `left`, as its authority would. Returns when that is.
  [[nodiscard]] std::chrono::system_clock::time_point shorten_certificate(const fs::path& enclave,
                                                                          std::chrono::seconds left) const {
    namespace pki = services::pki;
    const auto authority = pki::read_key(keys_ / "private" / "ca.key.pem");
    const auto certificate = pki::read_certificate(enclave / "cert.pem");
    X509_gmtime_adj(X509_getm_notAfter(certificate.get()), left.count());
    X509_sign(certificate.get(), authority.get(), EVP_sha256());
    pki::write_file(enclave / "cert.pem",
                    pki::pem([&](BIO* out) { return PEM_write_bio_X509(out, certificate.get()); }, enclave));
    return pki::end_of(certificate.get()) + std::chrono::seconds(1);
  }

  FreeDomain domain_;
  TemporaryFolder folder_;
  const fs::path keys_ = folder_.path() / "keys";
  const fs::path stolen_ = folder_.path() / "stolen";  ///< what the guest keeps
};

TEST_F(Revocation, EndsAConnectedParticipantAndKeepsTheOthers) {
  bus::Participant driver(domain_.number(), "driver", watching(Role::kDriver));
  bus::Writer<msg::ArmState> states(driver);
  bus::Participant planner(domain_.number(), "planner", watching(Role::kPlanner));
  bus::Reader<msg::ArmState> kept(planner);
  bus::Participant guest(domain_.number(), "guest", options(stolen_, "guest-pc", Role::kViewer));
  bus::Reader<msg::ArmState> seen(guest);
  ASSERT_TRUE(write_until(states, seen, [&] { return states.matched() == 2 && !seen.take().empty(); }));

  services::revoke_host(keys_, "guest-pc");
  ASSERT_TRUE(write_until(states, kept, [&] { return states.matched() == 1 && refused(driver, "are revoked"); }));
  static_cast<void>(seen.take());
  static_cast<void>(kept.take());
  int received = 0;
  ASSERT_TRUE(write_until(states, kept, [&] { return (received += static_cast<int>(kept.take().size())) > 50; }));
  EXPECT_TRUE(seen.take().empty());

  // New identities of the host have another subject.
  services::add_host(keys_, "guest-pc", std::chrono::days(5));
  bus::Participant returned(domain_.number(), "returned", options(keys_, "guest-pc", Role::kViewer));
  bus::Reader<msg::ArmState> again(returned);
  EXPECT_TRUE(write_until(states, again, [&] { return !again.take().empty(); }));
  EXPECT_TRUE(seen.take().empty());
}

TEST_F(Revocation, RefusesTheHandshakeOfARevokedParticipant) {
  services::revoke_host(keys_, "guest-pc");
  bus::ParticipantOptions late = options(keys_, "cell-pc", Role::kDriver);
  late.revocations = services::revocations_file(keys_);
  bus::Participant driver(domain_.number(), "driver", late);
  bus::Writer<msg::ArmState> states(driver);
  late.identity = services::enclave_folder(keys_, "cell-pc", Role::kPlanner);
  bus::Participant planner(domain_.number(), "planner", late);
  bus::Reader<msg::ArmState> kept(planner);
  bus::Participant guest(domain_.number(), "guest", options(stolen_, "guest-pc", Role::kViewer));
  bus::Reader<msg::ArmState> seen(guest);
  EXPECT_TRUE(write_until(states, kept, [&] { return states.matched() == 1 && refused(driver, "revoked or of"); }));
  EXPECT_TRUE(seen.take().empty());
}

TEST_F(Revocation, RefusesTheHandshakeOfAnExpiredParticipant) {
  const fs::path enclave = services::enclave_folder(stolen_, "guest-pc", Role::kViewer);
  const auto end = shorten_certificate(enclave, std::chrono::seconds(5));
  bus::Participant guest(domain_.number(), "guest", options(stolen_, "guest-pc", Role::kViewer));
  bus::Reader<msg::ArmState> seen(guest);
  while (std::chrono::system_clock::now() <= end) static_cast<void>(seen.wait_for_data(std::chrono::milliseconds(100)));

  bus::Participant driver(domain_.number(), "driver", watching(Role::kDriver));
  bus::Writer<msg::ArmState> states(driver);
  bus::Participant planner(domain_.number(), "planner", watching(Role::kPlanner));
  bus::Reader<msg::ArmState> kept(planner);
  EXPECT_TRUE(write_until(states, kept, [&] { return states.matched() == 1 && refused(driver, "expired"); }))
      << states.matched() << " readers; refused: " << driver.refused(kPatience, 8).size();
  EXPECT_TRUE(seen.take().empty());
}

TEST_F(Revocation, LetsOldAndRenewedKeysWorkTogether) {
  bus::Participant driver(domain_.number(), "driver", watching(Role::kDriver));
  bus::Writer<msg::ArmState> states(driver);
  services::renew_host(keys_, "cell-pc", std::chrono::days(6));
  bus::Participant planner(domain_.number(), "planner", watching(Role::kPlanner));
  bus::Reader<msg::ArmState> seen(planner);
  EXPECT_TRUE(write_until(states, seen, [&] { return !seen.take().empty(); }));
}

TEST_F(Revocation, LetsPlannersOfAHostCommandItsArmsOnly) {
  services::add_host(keys_, "guest-pc", std::chrono::days(5), {"south"});
  services::renew_host(keys_, "guest-pc", std::chrono::days(6));
  bus::Participant planner(domain_.number(), "planner", options(keys_, "guest-pc", Role::kPlanner));
  EXPECT_THROW(bus::Writer<msg::ArmCommand>(planner, {.key = "north"}), std::runtime_error);
  EXPECT_THROW(bus::Writer<msg::ArmCommand>{planner}, std::runtime_error);
  bus::Participant driver(domain_.number(), "driver", options(keys_, "cell-pc", Role::kDriver));
  bus::Reader<msg::ArmCommand> reader(driver, nullptr, {.keys = {"south"}});
  bus::Writer<msg::ArmCommand> writer(planner, {.key = "south"});
  ASSERT_TRUE(writer.wait_matched(1, kPatience));
  msg::ArmCommand command;
  command.arm("south");
  ASSERT_TRUE(writer.write(command));
  const auto until = bus::Clock::now() + kPatience;
  while (reader.latest("south") == nullptr && bus::Clock::now() < until) {
    static_cast<void>(reader.wait_for_data(std::chrono::seconds(1)));
  }
  EXPECT_NE(reader.latest("south"), nullptr);
}

}  // namespace
}  // namespace hecaton::test
