// `hecaton firewall`.

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "services/command_line/document.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

const std::string kThreeHosts = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_hosts.yaml";
const std::string kOneHost = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";

TEST(Firewall, LetsTheHostsOfTheCellAndAllowedMachinesSend) {
  const Ran ran = run_line({"firewall", kThreeHosts, "--allow", "10.43.0.99"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  EXPECT_NE(ran.out.find("elements = { 10.43.0.11, 10.43.0.12, 10.43.0.13, 10.43.0.14, 10.43.0.15, 10.43.0.99 }"),
            std::string::npos)
      << ran.out;
  // Domain 43: from 7400 + 250 · 43, for 250 ports.
  EXPECT_NE(ran.out.find("ip saddr @senders udp dport 18150-18399 accept\n    udp dport 18150-18399 counter drop"),
            std::string::npos)
      << ran.out;
}

TEST(Firewall, LetsNobodySendToACellOfOneHost) {
  const Ran ran = run_line({"--domain", "7", "firewall", kOneHost, "-o", "json"});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const Json json = Json::parse(ran.out);
  EXPECT_EQ(json.at("senders"), Json::array());
  EXPECT_EQ(json.at("ports").at("first"), 9150);
  const std::string rules = json.at("rules");
  EXPECT_EQ(rules.find("@senders"), std::string::npos);
  EXPECT_NE(rules.find("iif lo accept\n    udp dport 9150-9399 counter drop"), std::string::npos) << rules;
}

TEST(Firewall, RefusesAMachineWithoutAddress) {
  const Ran ran = run_line({"firewall", kThreeHosts, "--allow", "no-such-machine.invalid"});
  EXPECT_EQ(ran.code, ExitCode::kBadInput);
  EXPECT_NE(ran.err.find("--allow = no-such-machine.invalid has no IPv4 address"), std::string::npos) << ran.err;
}

// In a network namespace of its own; twice, because a call replaces the rules of the one before.
TEST(Firewall, PrintsRulesThatTheKernelTakes) {
  // Root may need no user namespace, which a changed root file system does not allow.
  std::string own_network;
  for (const std::string way : {"unshare --map-root-user --net ", "unshare --net "}) {
    if (std::system((way + "nft list ruleset > /dev/null 2>&1").c_str()) == 0) own_network = way;
  }
  if (own_network.empty()) {
    ASSERT_TRUE(test::may_skip()) << "no network namespace, or no nft";
    GTEST_SKIP() << "no network namespace, or no nft";
  }
  const test::TemporaryFolder folder;
  for (const std::string& cell : {kThreeHosts, kOneHost}) {
    const std::string rules = folder.path("rules");
    std::ofstream(rules) << run_line({"firewall", cell}).out;
    const std::string load = "nft -f " + rules;
    EXPECT_EQ(std::system((own_network + "sh -c '" + load + " && " + load + "'").c_str()), 0);
  }
}

}  // namespace
}  // namespace hecaton::services::cli
