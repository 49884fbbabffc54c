/// Commands that need a running cell, without one.

#include <cstdlib>
#include <optional>

#include "tests/cell/cli/live_cell.hpp"

namespace hecaton::test {
namespace {

TEST(NoCell, EveryCommandExitsWithFive) {
  const std::vector<std::vector<std::string>> lines{
      {"status"},
      {"status", "--watch"},
      {"arms", "-o", "json"},
      {"faults"},
      {"obstacles"},
      {"hosts"},
      {"goal", "north", "--named", "home"},
      {"goal", "north", "--joints", "0 0 0 0 0 0", "--wait"},
      {"wait", "north", "--for", "reached"},
      {"hold"},
      {"resume"},
      {"device", "north", "on"},
      {"stop", "north"},
      {"obstacle", "add", "x", "--sphere", "0.1", "--pose", "0 0 1 0 0 0"},
      {"obstacle", "move", "x", "--pose", "0 0 1 0 0 0"},
      {"obstacle", "remove", "x"},
      {"attach", "north", "x"},
      {"detach", "north", "x"},
  };
  const FreeDomain free;
  const std::string domain = std::to_string(free.number());
  for (std::vector<std::string> words : lines) {
    words.insert(words.end(), {"--domain", domain, "--connect-timeout", "100ms"});
    const Ran ran = run_hecaton(words);
    EXPECT_EQ(ran.code, 5) << words[0] << ": " << ran.err;
    EXPECT_EQ(ran.out, "");
    EXPECT_NE(ran.err.find("no cell answers in DDS domain " + domain), std::string::npos) << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
}

TEST(NoCell, AnOrderNamesTheNodesThatItLookedFor) {
  const FreeDomain free;
  const std::vector<std::string> nowhere{"--domain", std::to_string(free.number()), "--connect-timeout", "100ms"};
  const auto stop = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "stop");
    words.insert(words.end(), nowhere.begin(), nowhere.end());
    const Ran ran = run_hecaton(words);
    EXPECT_EQ(ran.code, 5);
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    return ran.err;
  };
  EXPECT_NE(
      stop({}).find("the order was not obeyed, and arms may still move: looked for the supervisor of any cell, but "
                    "no cell answers in DDS domain"),
      std::string::npos);
  EXPECT_NE(stop({"--cell", kThreePuma}).find("looked for the node supervisor, but no cell answers"),
            std::string::npos);
  const std::string standby = std::string(HECATON_SOURCE_DIR) + "/tests/cell/supervision/standby_cell.yaml";
  EXPECT_NE(stop({"--cell", standby}).find("looked for the nodes supervisor and supervisor@beta, but"),
            std::string::npos);
}

TEST(NoCell, UsesTheNameOfTheCellFile) {
  const FreeDomain free;
  const Ran ran = run_hecaton(
      {"status", "--cell", kThreePuma, "--domain", std::to_string(free.number()), "--connect-timeout", "100ms"});
  EXPECT_EQ(ran.code, 5);
  EXPECT_NE(ran.err.find("under the name 'three_puma'"), std::string::npos) << ran.err;
}

const std::string kThreeHosts = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_hosts.yaml";

TEST(Agent, RejectsAnUnknownHost) {
  const FreeDomain domain;
  for (const std::string host : {"", "south-pc"}) {
    const Ran ran = run_hecaton({"agent", kThreeHosts, "--host", host, "--domain", std::to_string(domain.number())});
    EXPECT_EQ(ran.code, 3);
    EXPECT_EQ(ran.err, "hecaton: " + kThreeHosts + ": --host '" + host +
                           "' must be one of north-pc, west-pc, east-pc, world-pc, supervisor-pc\n");
  }
}

/// Sets TMPDIR during its life.
class Tmpdir {
 public:
  explicit Tmpdir(const char* value) {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    setenv("TMPDIR", value, 1);
  }
  ~Tmpdir() { before_ ? setenv("TMPDIR", before_->c_str(), 1) : unsetenv("TMPDIR"); }
  Tmpdir(const Tmpdir&) = delete;
  Tmpdir& operator=(const Tmpdir&) = delete;

 private:
  std::optional<std::string> before_;
};

TEST(Tmpdir, IsRejectedWhenMissing) {
  const FreeDomain free;
  const std::string domain = std::to_string(free.number());
  const Tmpdir nowhere("/nonexistent");
  const Ran agent = run_hecaton({"agent", kThreePuma, "--log-level", "error", "--domain", domain});
  EXPECT_EQ(agent.code, 3);
  EXPECT_EQ(agent.err, "hecaton: the folder of the run, /nonexistent/hecaton-" + domain +
                           "-three_puma@localhost, cannot be used: No such file or directory; set TMPDIR to another "
                           "folder\n");
  const Ran up = run_hecaton({"up", kThreePuma, "--domain", domain});
  EXPECT_EQ(up.code, 3);
  EXPECT_EQ(up.err,
            "hecaton: a log folder cannot be created in /nonexistent: No such file or directory; name another place by "
            "--log-dir or TMPDIR\n");
}

TEST(Output, ExitsWithOneWhenItCannotBeWritten) {
  const std::string command = std::string(HECATON_BIN_DIR) + "/hecaton man > /dev/full 2> /dev/null";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace hecaton::test
