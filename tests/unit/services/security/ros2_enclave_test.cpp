#include "services/security/ros2_enclave.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "services/security/keystore.hpp"
#include "tests/support/sros2_keystore.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;
using test::Sros2Keystore;

constexpr const char* kFiles[] = {"cert.pem",       "key.pem",        "identity_ca.cert.pem", "permissions_ca.cert.pem",
                                  "governance.p7s", "permissions.p7s"};

std::string refusal(const fs::path& folder) {
  try {
    static_cast<void>(read_ros2_enclave(folder));
  } catch (const KeystoreError& error) {
    return error.what();
  }
  return "";
}

class Ros2EnclaveFiles : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  Sros2Keystore keystore_{folder_.path() / "keystore"};
  fs::path enclave_ = keystore_.add("hecaton");

  void replace(const char* file, const fs::path& by) const {
    fs::copy_file(by, enclave_ / file, fs::copy_options::overwrite_existing);
  }
};

TEST_F(Ros2EnclaveFiles, AreReadAsSros2MakesThem) {
  const Ros2Enclave enclave = read_ros2_enclave(enclave_);
  EXPECT_EQ(enclave.name, "/hecaton");
  EXPECT_TRUE(enclave.revocations.empty());
  EXPECT_GT(enclave.expires, std::chrono::system_clock::now() + std::chrono::hours(24 * 3600));
  // SROS2 links to the files of the keystore.
  fs::rename(enclave_ / "governance.p7s", enclave_ / "elsewhere");
  fs::create_symlink("elsewhere", enclave_ / "governance.p7s");
  EXPECT_EQ(refusal(enclave_), "");
}

TEST_F(Ros2EnclaveFiles, AreNamedWhenMissingOrBroken) {
  for (const char* file : kFiles) {
    const fs::path path = enclave_ / file;
    const fs::path aside = folder_.path() / "aside";
    fs::rename(path, aside);
    EXPECT_EQ(refusal(enclave_).find(path.string() + ": is missing"), 0U) << refusal(enclave_);
    std::ofstream(path) << "nothing of use\n";
    EXPECT_EQ(refusal(enclave_).find(path.string() + ": is no "), 0U) << refusal(enclave_);
    fs::rename(aside, path);
  }
  EXPECT_EQ(refusal(enclave_), "");
  EXPECT_NE(refusal(enclave_ / "nowhere").find("is no folder"), std::string::npos);
}

TEST_F(Ros2EnclaveFiles, AreNamedWhenTheyBelongToAnother) {
  const fs::path other = keystore_.add("other");
  const fs::path key = folder_.path() / "key";
  fs::copy_file(enclave_ / "key.pem", key);
  replace("key.pem", other / "key.pem");
  EXPECT_EQ(refusal(enclave_), (enclave_ / "key.pem").string() + ": is not the key of cert.pem beside it");
  replace("key.pem", key);

  const fs::path permissions = folder_.path() / "permissions";
  fs::copy_file(enclave_ / "permissions.p7s", permissions);
  replace("permissions.p7s", other / "permissions.p7s");
  EXPECT_EQ(refusal(enclave_), (enclave_ / "permissions.p7s").string() +
                                   ": has no grant for CN=/hecaton, the subject of cert.pem beside it");
  replace("permissions.p7s", permissions);

  Sros2Keystore foreign(folder_.path() / "foreign");
  const fs::path foreign_enclave = foreign.add("hecaton");
  for (const char* file : {"governance.p7s", "permissions.p7s"}) {
    const fs::path aside = folder_.path() / "own";
    fs::copy_file(enclave_ / file, aside, fs::copy_options::overwrite_existing);
    replace(file, foreign_enclave / file);
    EXPECT_EQ(refusal(enclave_), (enclave_ / file).string() + ": is not signed by permissions_ca.cert.pem beside it");
    replace(file, aside);
  }
  replace("identity_ca.cert.pem", foreign_enclave / "identity_ca.cert.pem");
  EXPECT_EQ(refusal(enclave_), (enclave_ / "cert.pem").string() + ": is not signed by identity_ca.cert.pem beside it");
}

TEST_F(Ros2EnclaveFiles, MustKeepParticipantsWithoutKeysOut) {
  Sros2Keystore open(folder_.path() / "open", "NONE");
  EXPECT_NE(refusal(open.add("hecaton")).find("governance.p7s: rtps_protection_kind = NONE must be SIGN or ENCRYPT"),
            std::string::npos);
  Sros2Keystore guests(folder_.path() / "guests", "SIGN", "true");
  EXPECT_NE(
      refusal(guests.add("hecaton")).find("governance.p7s: allow_unauthenticated_participants = true must be false"),
      std::string::npos);
}

}  // namespace
}  // namespace hecaton::services
