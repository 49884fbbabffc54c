/// The command line without a network: usage errors, bad input, `check`, completion and man page.

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "services/command_line/program.hpp"
#include "services/security/keystore.hpp"
#include "tests/support/sros2_keystore.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

const std::string kCell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
const std::string kUrdf = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";

using Words = std::vector<std::string>;

using Lines = std::vector<std::pair<Words, std::string>>;

/// Each command line ends with `code` and prints one sentence that contains the text.
void expect_refusals(const Lines& lines, ExitCode code) {
  for (const auto& [words, piece] : lines) {
    const Ran ran = run_line(words);
    EXPECT_EQ(ran.code, code) << ran.err;
    EXPECT_NE(ran.err.find(piece), std::string::npos) << "expected \"" << piece << "\" in:\n" << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    EXPECT_EQ(ran.out, "");
  }
}

TEST(CommandLine, RejectsWrongUsage) {
  expect_refusals(
      {
          {{}, "A subcommand is required; see 'hecaton --help'"},
          {{"sttus"}, "no command 'sttus'; did you mean 'status'? See 'hecaton --help'"},
          {{"bogus"}, "no command 'bogus'; allowed are up, agent, status"},
          {{"-o", "json", "bogus"}, "no command 'bogus'"},
          {{"obstacle", "ad"}, "no command 'ad'; did you mean 'add'? See 'hecaton obstacle --help'"},
          {{"status", "--wach"}, "no option '--wach'; did you mean '--watch'?"},
          {{"status", "more"}, "not expected: more"},
          {{"status", "-o", "xml"}, "'xml' must be table, json or yaml"},
          {{"status", "--domain"}, "--domain"},
          {{"goal", "north"}, "--joints"},
          {{"goal", "north", "--named", "home", "--joints", "0"}, "Exactly 1 option"},
          {{"wait", "north", "--for", "reached,done"},
           "'done' must be reached, blocked, rejected, cancelled, timed_out, replaced or fault"},
          {{"obstacle"}, "A subcommand is required"},
          {{"obstacle", "add", "x", "--pose", "0 0 0 0 0 0"}, "--box,--sphere,--capsule,--cylinder"},
          {{"attach", "north"}, "OBJECT is required"},
          {{"simulate"}, "CELL is required"},
          {{"simulate", kCell, "--method", "magic"},
           "'magic' must be local, single_subspace, boundary_following, sensed_cspace, known_cspace, "
           "potential_field, strategy or strategy_step"},
          {{"up"}, "CELL is required"},
          {{"check", kCell, "--tool", "flange"}, "--tool is for a URDF"},
          {{"check", kCell, "--joint", "finger=0"}, "--joint is for a URDF"},
          {{"completion", "fish"}, "fish"},
      },
      ExitCode::kUsage);
}

/// "agent driver(north)" for each host of the keystore.
std::map<std::string, std::string> roles_in(const std::filesystem::path& keystore) {
  std::map<std::string, std::string> roles;
  for (const IdentityState& one : identities_in(keystore)) {
    EXPECT_FALSE(one.problem) << *one.problem;
    std::string& text = roles[one.host];
    text += (text.empty() ? "" : " ") + one.role;
    for (const std::string& arm : one.arms) text += "(" + arm + ")";
  }
  return roles;
}

TEST(CommandLine, MakesTheKeysOfWhatACellFilePlacesOnEachHost) {
  const test::TemporaryFolder folder;
  const std::string keys = folder.path() / "keys";
  const std::string cell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_hosts.yaml";
  EXPECT_EQ(run_line({"keystore", "create", keys}).code, ExitCode::kDone);
  expect_refusals({{{"keystore", "add", keys, "south-pc", "--for", cell},
                    "HOST 'south-pc' must be one of north-pc, west-pc, east-pc, world-pc, supervisor-pc"},
                   {{"keystore", "add", keys, "--for", cell, "--days", "4000"}, "give fewer --days"}},
                  ExitCode::kBadInput);
  EXPECT_TRUE(roles_in(keys).empty());
  expect_refusals({{{"keystore", "add", keys}, "name a HOST"},
                   {{"keystore", "add", keys, "north-pc", "--for", cell, "--arms", "north"}, "excludes"}},
                  ExitCode::kUsage);

  const Ran one = run_line({"keystore", "add", keys, "north-pc", "--for", cell, "-o", "json"});
  EXPECT_EQ(one.code, ExitCode::kDone) << one.err;
  EXPECT_EQ(nlohmann::json::parse(one.out)["added"].size(), 1U) << one.out;
  const std::map<std::string, std::string> north{{"north-pc", "agent driver(north) planner(north)"}};
  EXPECT_EQ(roles_in(keys), north);
  // No other host gets identities.
  expect_refusals({{{"keystore", "add", keys, "--for", cell}, "north-pc/agent: exists already"}}, ExitCode::kBadInput);
  EXPECT_EQ(roles_in(keys), north);
  EXPECT_EQ(run_line({"keystore", "revoke", keys, "north-pc"}).code, ExitCode::kDone);

  const Ran all = run_line({"keystore", "add", keys, "--for", cell});
  EXPECT_EQ(all.code, ExitCode::kDone) << all.err;
  EXPECT_NE(all.out.find("agent, driver (west), planner (west)"), std::string::npos) << all.out;
  const std::map<std::string, std::string> wanted{{"north-pc", "agent driver(north) planner(north)"},
                                                  {"west-pc", "agent driver(west) planner(west)"},
                                                  {"east-pc", "agent driver(east) planner(east)"},
                                                  {"world-pc", "agent world"},
                                                  {"supervisor-pc", "agent supervisor"},
                                                  {"people", "operator viewer"}};
  EXPECT_EQ(roles_in(keys), wanted);
  EXPECT_NE(all.out.find("crl.pem to each"), std::string::npos) << all.out;
}

// A standby needs the arms of its planner, and a page or a recorder what it reads and orders.
TEST(CommandLine, MakesTheKeysOfStandbysPagesAndRecorders) {
  const test::TemporaryFolder folder;
  const std::string cell = folder.path() / "cell.yaml";
  const auto roles_with = [&](const std::string& view, const std::string& keys) {
    std::ofstream(cell) << "name: two\nhosts: {a: 10.0.0.1, b: 10.0.0.2}\n"
                           "supervision: {host: a, standby_host: b}\n"
                           "world: {host: a}\n"
                           "record: {host: b, folder: /tmp/recordings}\n"
                        << view
                        << "defaults: {robot: ur5e}\n"
                           "arms:\n"
                           "  - {name: north, host: a, standby_host: b, base: {xyz: [0, 0.8, 0]}}\n"
                           "  - {name: south, host: b, base: {xyz: [0, -0.8, 0]}}\n";
    EXPECT_EQ(run_line({"keystore", "create", keys}).code, ExitCode::kDone);
    const Ran ran = run_line({"keystore", "add", keys, "--for", cell});
    EXPECT_EQ(ran.code, ExitCode::kDone) << ran.err;
    return roles_in(keys);
  };
  std::map<std::string, std::string> wanted{{"a", "agent driver(north) planner(north) supervisor world"},
                                            {"b", "agent driver(south) planner(north)(south) supervisor viewer"},
                                            {"people", "operator viewer"}};
  EXPECT_EQ(roles_with("view: {host: b, no_stop: true}\n", folder.path("watching")), wanted);
  wanted["b"] = "agent driver(south) operator planner(north)(south) supervisor viewer";
  EXPECT_EQ(roles_with("view: {host: b}\n", folder.path("stopping")), wanted);
  wanted["a"] = "agent driver(north) operator planner(north) supervisor viewer world";
  wanted["b"] = "agent driver(south) planner(north)(south) supervisor viewer";
  EXPECT_EQ(roles_with("ros2: {host: a}\n", folder.path("ros2")), wanted);
}

// Persons would get the keys of the services, and the host those of persons.
TEST(CommandLine, RejectsKeysOfAHostThatIsCalledLikePersons) {
  const test::TemporaryFolder folder;
  const std::string keys = folder.path("keys");
  const std::string cell = folder.write("cell.yaml",
                                        "name: one\nhosts: {people: 10.0.0.1}\ndefaults: {robot: ur5e}\n"
                                        "arms: [{name: north}]\n");
  EXPECT_EQ(run_line({"keystore", "create", keys}).code, ExitCode::kDone);
  expect_refusals({{{"keystore", "add", keys, "--for", cell}, "hosts: 'people' must have another name"}},
                  ExitCode::kBadInput);
  EXPECT_TRUE(roles_in(keys).empty());
}

TEST(CommandLine, RejectsInvalidValues) {
  const Words add{"obstacle", "add", "x", "--pose", "0 0 0 0 0 0"};
  const auto with = [&](std::initializer_list<std::string> more) {
    Words words = add;
    words.insert(words.end(), more);
    return words;
  };
  expect_refusals(
      {
          {{"status", "--domain", "200"}, "--domain = '200' must be a whole number from 0 to 199"},
          {{"status", "--domain", "x"}, "--domain = 'x' must be a whole number"},
          {{"status", "--interval", "5"}, "must be a number with its unit"},
          {{"status", "--connect-timeout", "-1s"}, "must be a number with its unit"},
          {{"goal", "north", "--joints", "0 nan"}, "'nan' must be a finite number"},
          {{"goal", "north", "--joints", "0", "-inf"}, "'-inf' must be a finite number"},
          {{"goal", "north", "--joints", "0 a"}, "'a' must be a finite number"},
          {{"goal", "north", "--pose", "0 0 1"}, "3 numbers given, must be 6"},
          {{"goal", "north", "--pose", "0 0 1e9 0 0 0"}, "--pose z = '1e+09' must be between -100 and 100 m"},
          {{"goal", "north", "--named", "home", "--time-limit", "3"}, "must be a number with its unit"},
          {{"wait", "north", "--timeout", "30"}, "must be a number with its unit"},
          {with({"--sphere", "-1"}), "--sphere radius = -1 m must be between 0.0001 and 100 m"},
          {with({"--sphere", "nan"}), "--sphere radius = nan m must be a finite number"},
          {with({"--box", "1 0 1"}), "--box size[1] = 0 m must be between 0.0001 and 100 m"},
          {with({"--sphere", "1", "--mass", "-1"}), "--mass = -1 kg must be above 0 and at most 100000 kg"},
          {with({"--sphere", "1", "--conveyor", "0 0 0 1"}), "--conveyor speed = 0 m/s must be above 0"},
          {with({"--sphere", "1", "--sine", "1 0 0 0"}), "--sine period = 0 s must be between 0.01 and 3600 s"},
          {{"obstacle", "add", "", "--sphere", "1", "--pose", "0 0 0 0 0 0"}, "NAME = \"\" must be a name of 1 to 64"},
          {{"obstacle", "add", "a b", "--sphere", "1", "--pose", "0 0 0 0 0 0"}, "NAME = \"a b\" must be a name"},
          {{"obstacle", "move", "x", "--pose", "0 0 inf 0 0 0"}, "'inf' must be a finite number"},
          {{"simulate", kCell, "--tasks", "0"}, "--tasks = '0' must be a whole number from 1 to 100000000"},
          {{"simulate", kCell, "--seed", "-1"}, "--seed = '-1' must be a whole number from 0"},
          {{"simulate", kCell, "--loss", "1"}, "--loss = '1' must be a number between 0 and 0.999999"},
          {{"simulate", kCell, "--threads", "0"}, "--threads = '0'"},
          {{"simulate", kCell, "--jitter", "20ms"}, "--jitter = 20 ms must be at most --age = 0 s"},
          {{"check", kUrdf, "--package", "x"}, "must be NAME=DIR"},
          {{"check", kUrdf, "--joint", "x"}, "--joint = 'x' must be NAME=VALUE"},
          {{"check", kUrdf, "--joint", "x=up"}, "must be NAME=VALUE with a number"},
          {{"check", kUrdf, "--joint", "x=1"}, "joint 'x' = 1: the robot has no such joint"},
          {{"check", kUrdf, "--xacro", "=x"}, "--xacro = '=x' must be NAME=VALUE"},
          {{"check", kUrdf, "--base", "x"}, "base link 'x' must be one of its links"},
          {{"check", kUrdf, "--default-velocity", "0"}, "--default-velocity = '0' must be a number above 0"},
      },
      ExitCode::kBadInput);
}

/// A temporary cell file.
class CellBeside {
 public:
  explicit CellBeside(const std::string& text)
      : path_(testing::TempDir() + "hecaton_cell_" + std::to_string(getpid()) + ".yaml") {
    std::ofstream(path_) << "name: x\n"
                         << text << "arms:\n  - name: a\n    urdf: " << kUrdf
                         << "\n    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n";
  }
  ~CellBeside() { std::remove(path_.c_str()); }
  CellBeside(const CellBeside&) = delete;
  CellBeside& operator=(const CellBeside&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(CommandLine, SimulatesACellWithoutTaskArea) {
  const CellBeside cell("");
  const Ran ran = run_line({"simulate", cell.path(), "--tasks", "3", "-o", "json"});
  EXPECT_EQ(ran.code, ExitCode::kDone) << ran.err;
  EXPECT_EQ(nlohmann::json::parse(ran.out)["tasks"], 3);
}

TEST(CommandLine, CheckRefusesWhatSimulateRefuses) {
  // The area lies within reach, inside a wall that the start is clear of.
  const CellBeside cell(
      "tasks: {centre: [0, 0.6, 0.5], radius: 0.05, half_height: 0.05}\n"
      "obstacles: [{name: wall, shapes: [{type: box, size: [0.4, 0.4, 0.4]}], pose: {xyz: [0, 0.6, 0.5]}}]\n");
  const Ran checked = run_line({"check", cell.path()});
  const Ran simulated = run_line({"simulate", cell.path(), "--tasks", "3"});
  EXPECT_EQ(simulated.code, ExitCode::kBadInput);
  EXPECT_EQ(checked.code, simulated.code) << checked.out;
  for (const std::string& said : {checked.out, simulated.err}) {
    EXPECT_NE(said.find("and wall are too near"), std::string::npos) << said;
    EXPECT_NE(said.find("are needed"), std::string::npos) << said;
  }
}

// Each tool stays on a surface, because each arm has two joints.
TEST(CommandLine, ChecksACellOfTwoArmsOfOneRobotWithoutTaskArea) {
  const std::string urdf = std::string(HECATON_SOURCE_DIR) + "/tests/data/robots/two_arms.urdf";
  const std::string path = testing::TempDir() + "two_arms_" + std::to_string(getpid()) + ".yaml";
  std::ofstream(path) << "name: dual\ndefaults: {urdf: " << urdf << "}\narms:\n"
                      << "  - {name: left, chain: [torso, left_tool]}\n"
                      << "  - {name: right, chain: [torso, right_tool]}\n";
  const Ran checked = run_line({"check", path});
  EXPECT_EQ(checked.code, ExitCode::kDone) << checked.out;
  EXPECT_EQ(checked.out.find("warning"), std::string::npos) << checked.out;
  EXPECT_EQ(run_line({"simulate", path, "--tasks", "6"}).code, ExitCode::kDone);
}

TEST(CommandLine, RejectsAnUnknownNetworkInterface) {
  const CellBeside cell("network: {interface: nosuch0}\n");
  const std::string piece =
      "network.interface = nosuch0 must be the name or the address of a network interface of this "
      "machine: ";
  expect_refusals({{{"check", cell.path()}, piece}, {{"up", cell.path(), "--headless"}, piece}}, ExitCode::kBadInput);
  EXPECT_NE(run_line({"check", cell.path()}).err.find("lo (127.0.0.1)"), std::string::npos);
  EXPECT_EQ(run_line({"check", CellBeside("network: {interface: lo}\n").path()}).code, ExitCode::kDone);
}

TEST(CommandLine, RejectsAnUnknownInterfaceOfRos2) {
  const CellBeside cell("ros2: {interface: nosuch0}\n");
  expect_refusals(
      {{{"check", cell.path()},
        cell.path() + ": ros2.interface = nosuch0 must be the name or the address of a network interface of "
                      "this machine: "}},
      ExitCode::kBadInput);
  EXPECT_EQ(run_line({"check", CellBeside("ros2: {interface: lo}\n").path()}).code, ExitCode::kDone);
}

TEST(CommandLine, RejectsAnEnclaveOfRos2WithoutItsKeys) {
  const test::TemporaryFolder folder;
  const auto refusal = [&](const std::filesystem::path& enclave, const std::string& what) {
    const CellBeside cell("ros2: {enclave: " + enclave.string() + "}\n");
    expect_refusals({{{"check", cell.path()},
                      cell.path() + ": ros2.enclave = " + enclave.string() +
                          " must be a folder with valid keys of ROS 2, but " + what}},
                    ExitCode::kBadInput);
  };
  const std::filesystem::path nowhere = folder.path() / "nowhere";
  refusal(nowhere, nowhere.string() + " is no folder; `ros2 security create_enclave` makes an enclave\n");
  test::Sros2Keystore keystore(folder.path() / "keystore");
  const std::filesystem::path enclave = keystore.add("hecaton");
  EXPECT_EQ(run_line({"check", CellBeside("ros2: {enclave: " + enclave.string() + "}\n").path()}).code,
            ExitCode::kDone);
  for (const char* file : {"cert.pem", "key.pem", "permissions.p7s"}) {
    std::filesystem::rename(enclave / file, folder.path() / "aside");
    refusal(enclave, (enclave / file).string() + " is missing, ");
    std::filesystem::rename(folder.path() / "aside", enclave / file);
  }
}

// 192.0.2.0/24 is kept for documentation: no machine has it.
TEST(CommandLine, NotesKeysThatOnlyTheHostOfRos2MayHave) {
  const std::string path = testing::TempDir() + "hecaton_two_hosts_" + std::to_string(getpid()) + ".yaml";
  std::ofstream(path) << "name: x\nhosts: {alpha: 127.0.0.1, beta: 192.0.2.1}\nworld: {host: alpha}\n"
                      << "supervision: {host: alpha}\nros2: {host: beta, enclave: /nonexistent/hecaton}\n"
                      << "arms:\n  - name: a\n    host: alpha\n    urdf: " << kUrdf
                      << "\n    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n";
  const Ran checked = run_line({"check", path});
  EXPECT_EQ(checked.code, ExitCode::kDone) << checked.err;
  EXPECT_NE(checked.out.find("note: ros2.host = beta is another machine; check the cell there"), std::string::npos)
      << checked.out;
  EXPECT_NE(checked.out.find("/nonexistent/hecaton is no folder"), std::string::npos) << checked.out;
  std::remove(path.c_str());
}

TEST(Check, TellsAUrdfByItsExtension) {
  const std::string path = testing::TempDir() + "hecaton_no_xml_" + std::to_string(getpid()) + ".urdf";
  for (const char* text : {"", "robot: yes\n",
                           "\x7f"
                           "ELF"}) {
    std::ofstream(path) << text;
    expect_refusals({{{"check", path}, path}}, ExitCode::kBadInput);
    EXPECT_EQ(run_line({"check", path}).err.find("YAML"), std::string::npos) << text;
  }
  std::remove(path.c_str());
}

TEST(Check, NamesTheOptionsThatAcceptARobot) {
  const std::string path = testing::TempDir() + "hecaton_bare_" + std::to_string(getpid()) + ".urdf";
  const auto write = [&](const std::string& velocity) {
    std::ofstream(path) << "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'><parent "
                           "link='a'/><child link='b'/><axis xyz='0 0 1'/><limit effort='1' velocity='"
                        << velocity << "'/></joint></robot>";
  };
  write("0");
  EXPECT_NE(run_line({"check", path, "--allow-bare-links"}).err.find("or give --default-velocity"), std::string::npos);
  write("1");
  EXPECT_NE(run_line({"check", path}).err.find("or set --allow-bare-links"), std::string::npos);
  EXPECT_EQ(run_line({"check", path, "--allow-bare-links"}).code, ExitCode::kDone);
  write("0");
  EXPECT_EQ(run_line({"check", path, "--allow-bare-links", "--default-velocity", "2"}).code, ExitCode::kDone);
  std::remove(path.c_str());
}

TEST(CommandLine, RejectsBadInputWithOneSentence) {
  const std::string broken = testing::TempDir() + "hecaton_broken_cell.yaml";
  std::ofstream(broken) << "name: x\nbogus: 1\n";
  for (const char* command : {"check", "simulate", "up"}) {
    for (const std::string& file : {broken, std::string("/nowhere/cell.yaml")}) {
      const Ran ran = run_line({command, file});
      EXPECT_EQ(ran.code, ExitCode::kBadInput) << command << " " << file;
      EXPECT_NE(ran.err.find(file), std::string::npos) << ran.err;
      EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
      EXPECT_EQ(ran.out, "");
    }
  }
  const Ran status = run_line({"status", "--cell", broken});
  EXPECT_EQ(status.code, ExitCode::kBadInput) << status.err;
  std::remove(broken.c_str());
}

TEST(CommandLine, PrintsHelpOfEveryCommand) {
  Session session;
  const auto app = make_application(hecaton_program(), session);
  for (const CLI::App* command : subcommands_of(*app)) {
    const Ran ran = run_line({command->get_name(), "--help"});
    EXPECT_EQ(ran.code, ExitCode::kDone) << command->get_name();
    EXPECT_NE(ran.out.find(command->get_description()), std::string::npos);
  }
}

TEST(Check, DescribesACell) {
  const Ran table = run_line({"check", kCell});
  EXPECT_EQ(table.code, ExitCode::kDone) << table.err;
  EXPECT_NE(table.out.find("this cell can start"), std::string::npos);
  EXPECT_NE(table.out.find("--details"), std::string::npos) << table.out;
  EXPECT_EQ(table.out.find("collision shape"), std::string::npos) << "tables of shapes are details: " << table.out;
  EXPECT_EQ(table.out.find("self-collision is not checked"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("\narm north: tool frame on link"), std::string::npos) << table.out;
  const Ran details = run_line({"check", kCell, "--details"});
  EXPECT_NE(details.out.find("collision shape"), std::string::npos) << details.out;
  EXPECT_NE(details.out.find("self-collision is not checked"), std::string::npos) << details.out;
  const Ran json = run_line({"check", kCell, "-o", "json"});
  const auto cell = nlohmann::json::parse(json.out);
  EXPECT_EQ(cell["cell"], "three_puma");
  ASSERT_EQ(cell["arms"].size(), 3U);
  EXPECT_EQ(cell["arms"][0]["model"]["joints"].size(), 6U);
}

TEST(Check, ReportsWarningsAndErrors) {
  const std::string path = ::testing::TempDir() + "doubtful.yaml";
  const auto check = [&](const std::string& more, const std::string& output) {
    std::ofstream(path) << "name: doubtful\narms:\n  - name: left\n    urdf: " << HECATON_SOURCE_DIR
                        << "/deploy/cells/urdf/puma560.urdf\n    poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}\n"
                        << "    limits: {velocity: 1.5, acceleration: 10}\n"
                        << more;
    return run_line({"check", path, "-o", output});
  };
  const std::string steep = "    damper: {convergence_speed: 50, influence_distance: 0.12}\n";
  const Ran table = check(steep, "table");
  EXPECT_EQ(table.code, ExitCode::kDone) << table.err;
  EXPECT_NE(table.out.find("warning: arms[0].damper.influence_distance"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("this cell can start, with"), std::string::npos) << table.out;
  const auto json = nlohmann::json::parse(check(steep, "json").out);
  ASSERT_FALSE(json["findings"].empty());
  EXPECT_EQ(json["findings"][0]["severity"], "warning");
  const Ran impossible = check("tasks: {centre: [9, 9, 9], radius: 0.1, half_height: 0}\n", "table");
  EXPECT_EQ(impossible.code, ExitCode::kBadInput);
  EXPECT_NE(impossible.out.find("error: tasks"), std::string::npos) << impossible.out;
  std::filesystem::remove(path);
}

TEST(Check, DescribesARobot) {
  const Ran ran = run_line({"-o", "json", "check", kUrdf});
  ASSERT_EQ(ran.code, ExitCode::kDone) << ran.err;
  const auto robot = nlohmann::json::parse(ran.out);
  EXPECT_EQ(robot["name"], "puma560");
  EXPECT_EQ(robot["joints"].size(), 6U);
  // Seven links have one shape each (see the URDF): 7 · 6 / 2 pairs.
  EXPECT_EQ(robot["geometry"].size(), 7U);
  EXPECT_TRUE(std::any_of(robot["findings"].begin(), robot["findings"].end(), [](const auto& finding) {
    return finding["sentence"].template get<std::string>().find("velocity limit in 0.25 s") != std::string::npos;
  })) << robot["findings"];
  EXPECT_EQ(robot["self_pairs"]["all"], 21);
  EXPECT_EQ(robot["self_pairs"]["checked"].get<int>() + robot["self_pairs"]["filtered"].get<int>(), 21);
}

std::string output_of(const std::string& command) {
  std::string out;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::array<char, 4096> buffer{};
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) out += buffer.data();
  return out;
}

/// The completions by bash of the last of `words`.
std::vector<std::string> completions(const std::string& words) {
  const std::string script = testing::TempDir() + "hecaton_completion_" + std::to_string(getpid()) + ".bash";
  std::ofstream(script) << run_line({"completion", "bash"}).out << "hecaton() { :; }\nCOMP_WORDS=(" << words
                        << ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_hecaton\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
  std::istringstream lines(output_of("bash --norc " + script + " 2>&1"));
  std::vector<std::string> found;
  for (std::string line; std::getline(lines, line);) found.push_back(line);
  std::remove(script.c_str());
  return found;
}

TEST(Completion, OffersCommands) {
  EXPECT_EQ(completions("hecaton obs"), (Words{"obstacles", "obstacle"}));
  EXPECT_EQ(completions("hecaton obstacle m"), Words{"move"});
}

TEST(Completion, OffersOptionsOfTheCommandAndGlobalOnes) {
  EXPECT_EQ(completions("hecaton goal north --jo"), Words{"--joints"});
  EXPECT_EQ(completions("hecaton goal north --ou"), Words{"--output"});
  EXPECT_EQ(completions("hecaton status --wa"), Words{"--watch"});
}

TEST(Completion, OffersChoices) {
  EXPECT_EQ(completions("hecaton status -o j"), Words{"json"});
  EXPECT_EQ(completions("hecaton wait north --for bl"), Words{"blocked"});
  EXPECT_EQ(completions("hecaton simulate x --method bo"), Words{"boundary_following"});
  EXPECT_EQ(completions("hecaton plan x --method rrt_"), Words{"rrt_connect"});
}

TEST(ManPage, HasEveryCommandAndOption) {
  Session session;
  const auto app = make_application(hecaton_program(), session);
  const std::string page = man_page(*app, "moves arms", "1.2.3");
  EXPECT_EQ(page.rfind(".TH HECATON 1", 0), 0U);
  const auto escaped = [](const std::string& text) {
    std::string all;
    for (const char c : text) all += c == '-' ? std::string("\\-") : std::string(1, c);
    return all;
  };
  for (const CLI::App* command : subcommands_of(*app)) {
    const std::string name = command->get_name();
    EXPECT_NE(page.find(".SS \\fBhecaton " + escaped(name)), std::string::npos) << name;
    for (const CLI::Option* option : options_of(*command)) {
      for (const std::string& word : option->get_lnames()) {
        EXPECT_NE(page.find(escaped("--" + word)), std::string::npos) << word;
      }
    }
  }
}

TEST(ManPage, IsPrintedByItsCommand) {
  EXPECT_EQ(run_line({"man"}).out.rfind(".TH HECATON 1", 0), 0U);
}

}  // namespace
}  // namespace hecaton::services::cli
