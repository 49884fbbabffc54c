/// Every command against a running cell of three arms.

#include "tests/cell/cli/live_cell.hpp"

#include <filesystem>
#include <fstream>

#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

TEST_F(LiveCell, ReportsItsStatus) {
  const Json status = json({"status"});
  EXPECT_EQ(status["cell"], "three_puma");
  EXPECT_EQ(status["arms"].size(), 3U);
  for (const Json& arm : status["arms"]) {
    EXPECT_EQ(arm["state"]["q"].size(), 6U) << arm;
    EXPECT_TRUE(arm["state"]["age_s"].is_number()) << arm;
  }
  EXPECT_TRUE(status["contact_report"]["contacts"].is_number());
  EXPECT_EQ(json({"arms"}).size(), 3U);
  EXPECT_FALSE(entry(json({"obstacles"}), "name", "post").is_null());
  EXPECT_TRUE(json({"faults"}).is_array());
  // World, supervisor, and a driver and a planner for each arm.
  EXPECT_EQ(json({"hosts"})[0]["processes"].size(), 8U);

  EXPECT_NE(run({"status"}).out.find("cell three_puma"), std::string::npos);
  EXPECT_EQ(run({"status", "-o", "yaml"}).out.rfind("\"cell\": \"three_puma\"\n", 0), 0U);
  const Ran by_file = run({"status", "--cell", kThreePuma});
  EXPECT_EQ(by_file.code, 0) << by_file.err;
}

TEST_F(LiveCell, WatchesUntilInterrupted) {
  const auto watch = start({"status", "--watch", "--interval", "50ms", "-o", "json"});
  ASSERT_TRUE(watch->wait_for_output("}\n{")) << watch->err();
  watch->signal(SIGINT);
  EXPECT_EQ(watch->wait(), 0) << watch->err();
  std::istringstream lines(watch->out());
  int documents = 0;
  for (std::string line; std::getline(lines, line); ++documents)
    EXPECT_FALSE(Json::parse(line, nullptr, false).is_discarded());
  EXPECT_GE(documents, 2);
}

TEST_F(LiveCell, ReachesGoalsAndRejectsBadOnes) {
  const Ran reached = run({"goal", "north", "--named", "ready", "--wait", "--time-limit", "60s", "-o", "json"});
  EXPECT_EQ(reached.code, 0) << reached.err;
  EXPECT_EQ(Json::parse(reached.out)["state"], "reached");
  EXPECT_EQ(run({"wait", "north", "--for", "reached,blocked,fault"}).code, 0);
  EXPECT_EQ(run({"wait", "north", "--for", "cancelled"}).code, 1) << "the goal was reached";

  const Ran accepted = run({"goal", "west", "--named", "home"});
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  EXPECT_EQ(run({"wait", "west", "--timeout", "60s"}).code, 0);

  const Ran outside = run({"goal", "north", "--joints", "9 0 0 0 0 0"});
  EXPECT_EQ(outside.code, 1);
  EXPECT_NE(outside.out.find("rejected"), std::string::npos) << outside.out;
  EXPECT_NE(outside.out.find("joint1"), std::string::npos) << outside.out;
  EXPECT_EQ(run({"goal", "north", "--joints", "0 0 0"}).code, 1) << "three joints of six";
  EXPECT_EQ(run({"goal", "north", "--named", "nowhere", "--wait"}).code, 1);
  EXPECT_EQ(run({"wait", "north", "--for", "rejected"}).code, 0);

  const Ran unknown = run({"goal", "south", "--named", "home"});
  EXPECT_EQ(unknown.code, 3);
  EXPECT_NE(unknown.err.find("its arms: north, west and east"), std::string::npos) << unknown.err;
  EXPECT_EQ(run({"wait", "south"}).code, 3);
  EXPECT_EQ(run({"wait", "east", "--timeout", "100ms"}).code, 4) << "it has no goal";
}

TEST_F(LiveCell, PrintsEachStatusOfAWatchedGoal) {
  const Ran ran = run({"goal", "north", "--named", "ready", "--watch", "--time-limit", "60s", "-o", "json"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  std::istringstream lines(ran.out);
  std::vector<Json> statuses;
  for (std::string line; std::getline(lines, line);) statuses.push_back(Json::parse(line));
  ASSERT_GE(statuses.size(), 3U) << ran.out;
  EXPECT_EQ(statuses.back().at("state"), "reached");
  double farthest = 0.0;
  for (std::size_t i = 1; i < statuses.size(); ++i) {
    farthest = std::max(farthest, statuses[i].at("distance_to_goal").get<double>());
    EXPECT_NE(statuses[i - 1].at("state"), "reached");
    EXPECT_GE(statuses[i].at("elapsed_s"), statuses[i - 1].at("elapsed_s"));
  }
  EXPECT_LT(statuses[statuses.size() - 2].at("distance_to_goal"), farthest);
}

TEST_F(LiveCell, SeparatesTheStatusesOfAWatchedGoalInYaml) {
  const Ran ran = run({"goal", "east", "--named", "ready", "--watch", "--time-limit", "60s", "-o", "yaml"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  const auto count = [&](const std::string& line) {
    std::istringstream lines(ran.out);
    std::size_t found = 0;
    for (std::string one; std::getline(lines, one);) found += one == line ? 1 : 0;
    return found;
  };
  const std::size_t documents = count("---");
  EXPECT_GE(documents, 2U) << ran.out;
  EXPECT_EQ(count("\"arm\": \"east\""), documents) << ran.out;
  EXPECT_EQ(count("\"state\": \"reached\""), 1U) << ran.out;
}

TEST_F(LiveCell, ReachesAToolPose) {
  const Ran ran = run({"goal", "east", "--pose", "-0.1 -0.15 0.85 3.14159 0 0", "--wait", "--time-limit", "60s"});
  EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
  EXPECT_NE(ran.out.find("east: reached (tool "), std::string::npos) << ran.out;
  const Ran far = run({"goal", "east", "--pose", "0 0 5 0 0 0"});
  EXPECT_EQ(far.code, 1) << far.out;
}

TEST_F(LiveCell, HoldsStopsAndResumes) {
  EXPECT_EQ(json({"hold", "north"})["held_arms"], Json{"north"});
  EXPECT_EQ(run({"goal", "north", "--named", "ready"}).code, 0) << "goals are kept while held";
  EXPECT_EQ(run({"wait", "north", "--timeout", "300ms"}).code, 4);
  EXPECT_NE(entry(json({"arms"}), "name", "north")["waiting_for"]["text"].get<std::string>().find("hold"),
            std::string::npos);
  EXPECT_EQ(run({"resume", "north"}).code, 0);
  EXPECT_EQ(run({"wait", "north", "--timeout", "60s"}).code, 0);

  EXPECT_EQ(json({"stop"})["mode"], "stop");
  EXPECT_EQ(run({"hold"}).code == 0 ? json({"status"})["mode"] : Json("stop"), "stop") << "hold does not weaken stop";
  EXPECT_EQ(json({"resume"})["mode"], "run");
  EXPECT_EQ(run({"hold", "south"}).code, 3);

  EXPECT_EQ(run({"stop", "west"}).code, 0);
  EXPECT_EQ(run({"stop"}).code, 0);
  const Ran resumed = run({"resume"});
  EXPECT_EQ(resumed.code, 0);
  EXPECT_EQ(resumed.err, "arms stopped by name stay stopped: west; resume them with 'hecaton resume west'\n");
  EXPECT_EQ(json({"status"})["stopped_arms"], Json{"west"});
  EXPECT_EQ(run({"resume", "west"}).err, "");
}

TEST_F(LiveCell, SetsAndShowsTheSpeed) {
  EXPECT_EQ(json({"speed"})["speed"], 1.0);
  EXPECT_EQ(json({"speed", "30%"})["speed"], 0.3);
  EXPECT_EQ(entry(json({"speed", "50", "north"})["arms"], "name", "north")["speed"], 0.3) << "the cell's is lower";
  const Json north = json({"speed", "12.5%", "north"});
  ASSERT_EQ(north["arms"].size(), 1U);
  EXPECT_EQ(north["arms"][0]["own_speed"], 0.125);
  EXPECT_EQ(entry(json({"arms"}), "name", "north")["speed"], 0.125);
  EXPECT_EQ(json({"status"})["speed"], 0.3);
  EXPECT_NE(run({"status"}).out.find("speed 30 %, north 12.5 %"), std::string::npos) << run({"status"}).out;
  EXPECT_EQ(run({"speed", "north"}).out.substr(run({"speed", "north"}).out.find('\n') + 1),
            "north: 12.5 % (its own 12.5 %)\n");

  for (const auto* bad : {"0.5%", "101%", "30x", "0"}) {
    const Ran refused = run({"speed", bad});
    EXPECT_EQ(refused.code, 3) << bad;
    EXPECT_NE(refused.err.find("must be a percentage from 1% to 100%"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(run({"speed", "50%", "south"}).code, 3);
  EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait", "--time-limit", "60s"}).code, 0);
  EXPECT_EQ(run({"speed", "100%", "north"}).code, 0);
  EXPECT_EQ(run({"speed", "100%"}).code, 0);
  EXPECT_EQ(run({"status"}).out.find("speed 1"), std::string::npos);
}

TEST_F(LiveCell, PrintsDeathAndRestartOfTheSupervisor) {
  const pid_t supervisor = processes().at("supervisor");
  ASSERT_TRUE(signal_process(supervisor, SIGKILL));
  EXPECT_TRUE(up_->wait_for_message("the supervisor died (process " + std::to_string(supervisor) + ", signal 9)"));
  EXPECT_TRUE(up_->wait_for_message("the supervisor was restarted"));
  EXPECT_NE(processes().at("supervisor"), supervisor);
}

TEST_F(LiveCell, EditsTheWorld) {
  ASSERT_EQ(run({"goal", "north", "--named", "home", "--wait", "--time-limit", "60s"}).code, 0);
  EXPECT_EQ(run({"obstacle", "add", "crate", "--box", "0.1 0.1 0.1", "--pose", "0 0 2.5 0 0 0"}).code, 0);
  EXPECT_NE(run({"obstacle", "add", "crate", "--sphere", "0.1", "--pose", "0 0 3 0 0 0"}).code, 0)
      << "the name is not unique";
  EXPECT_EQ(run({"obstacle", "replace", "crate", "--box", "0.1 0.1 0.1", "--pose", "0 0 3 0 0 0"}).out, "put crate\n");
  EXPECT_EQ(run({"obstacle", "move", "crate", "--pose", "0.1 0 2.5 0 0 0"}).code, 0);
  EXPECT_EQ(run({"obstacle", "move", "box", "--pose", "0 0 0 0 0 0"}).code, 3);

  // The supervisor receives the edit a moment later.
  const auto crate = [&] { return entry(json({"obstacles"}), "name", "crate"); };
  const auto until = [&](const auto& condition) {
    const auto limit = std::chrono::steady_clock::now() + kPatience;
    while (!condition(crate())) ASSERT_LT(std::chrono::steady_clock::now(), limit) << crate();
  };
  until([](const Json& now) {
    return !now.is_null() && now["xyz_rpy"].is_array() && std::abs(now["xyz_rpy"][0].get<double>() - 0.1) < 1e-6;
  });
  const Ran far = run({"attach", "north", "crate"});
  EXPECT_EQ(far.code, 1) << "the world service rejects it";
  EXPECT_NE(far.err.find("must be at most 0.1 m from the tool"), std::string::npos) << far.err;
  const Ran on_top = run({"obstacle", "add", "hat", "--box", "0.1 0.1 0.1", "--pose", "0.4806 -0.15 1.4507 0 0 0"});
  EXPECT_EQ(on_top.code, 1) << "the tool is there in pose home";
  EXPECT_NE(on_top.err.find("must be clear of the arms, but north/"), std::string::npos) << on_top.err;
  EXPECT_EQ(run({"obstacle", "add", "north", "--sphere", "0.1", "--pose", "0 0 3 0 0 0"}).code, 3);
  EXPECT_EQ(run({"obstacle", "add", "", "--sphere", "0.1", "--pose", "0 0 3 0 0 0"}).code, 3);

  // 0.1 m ahead of the tool, which points along (−0.964, 0, 0.267).
  EXPECT_EQ(run({"obstacle", "move", "crate", "--pose", "0.3842 -0.15 1.4775 0 0 0"}).code, 0);
  EXPECT_EQ(run({"attach", "north", "crate"}).code, 0);
  until([](const Json& now) { return now["attached_to"] == "north"; });
  // Beside both: 0.07 m from the tool's axis, whose flange has a radius of 0.03 m.
  EXPECT_EQ(run({"obstacle", "add", "lid", "--sphere", "0.01", "--pose", "0.4806 -0.08 1.4507 0 0 0"}).code, 0);
  EXPECT_EQ(run({"attach", "north", "lid"}).code, 0);
  const auto carried = [&] { return entry(json({"arms"}), "name", "north")["state"]["carried"]; };
  until([&](const Json&) { return carried() == Json{"crate", "lid"}; });
  EXPECT_NE(run({"arms"}).out.find("crate, lid"), std::string::npos);
  EXPECT_EQ(run({"detach", "north", "lid"}).code, 0);
  EXPECT_EQ(run({"obstacle", "remove", "lid"}).code, 0);
  EXPECT_EQ(run({"detach", "west", "crate"}).code, 3) << "another arm carries it";
  EXPECT_EQ(run({"detach", "north", "crate"}).code, 0);
  until([](const Json& now) { return now["attached_to"].get<std::string>().empty(); });
  EXPECT_EQ(run({"obstacle", "remove", "crate"}).code, 0);
  until([](const Json& now) { return now.is_null(); });
  EXPECT_EQ(run({"obstacle", "remove", "crate"}).code, 3);
  EXPECT_EQ(run({"attach", "north", "crate"}).code, 3);
}

TEST_F(LiveCell, ReportsAKilledPlannerAndRestartsIt) {
  const pid_t planner = processes().at("planner/north");
  const auto waiting = start({"wait", "north", "--for", "fault", "--timeout", "60s"});
  // Repeats until the client has received the fault: it may still be connecting.
  const test::Watched client(waiting->pid());
  pid_t victim = planner;
  do {
    ASSERT_TRUE(signal_process(victim, SIGKILL));
    while (!client.wait_for_end(1s) && processes().at("planner/north") == victim) {
    }
    victim = processes().at("planner/north");
  } while (!client.wait_for_end(0s));
  EXPECT_EQ(waiting->wait(), 0) << waiting->err();
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  Json fault;
  while (fault.is_null() && std::chrono::steady_clock::now() < limit) {
    for (const Json& known : json({"faults"})) {
      if (known["kind"] == "process_died" && known["subject"] == "planner/north") fault = known;
    }
  }
  ASSERT_TRUE(fault.is_object());
  EXPECT_NE(fault["description"].get<std::string>().find("9"), std::string::npos) << "the signal: " << fault;
  // The agent restarts the planner.
  EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait", "--time-limit", "100s"}).code, 0);
  EXPECT_NE(processes().at("planner/north"), planner);
}

TEST_F(LiveCell, DeliversAGoalWhenItsPlannerContinues) {
  const pid_t planner = processes().at("planner/west");
  ASSERT_TRUE(signal_process(planner, SIGSTOP));
  const auto goal = start({"goal", "west", "--named", "ready", "--wait", "--time-limit", "100s"});
  EXPECT_TRUE(goal->wait_for_message("its planner has not answered yet"));
  ASSERT_TRUE(signal_process(planner, SIGCONT));
  EXPECT_EQ(goal->wait(), 0) << goal->err();
}

TEST_F(LiveCell, KeepsTheArmInPlaceWhenItsDriverIsKilled) {
  ASSERT_EQ(run({"goal", "north", "--named", "ready", "--wait", "--time-limit", "60s"}).code, 0);
  const auto state = [&] { return entry(json({"arms"}), "name", "north")["state"]; };
  const Json before = state();
  const pid_t driver = processes().at("driver/north");
  ASSERT_TRUE(signal_process(driver, SIGKILL));
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  Json after;
  do {
    after = state();
  } while ((processes().at("driver/north") == driver || after["mode"] != "running") &&
           std::chrono::steady_clock::now() < limit);
  ASSERT_EQ(after["mode"], "running") << after;
  for (std::size_t j = 0; j < before["q"].size(); ++j) {
    EXPECT_NEAR(after["q"][j].get<double>(), before["q"][j].get<double>(), 0.01) << "joint " << j;
  }
}

/// A cell with its own copy of the cell file.
class EditedCell : public LiveCell {
 protected:
  EditedCell() {
    const std::filesystem::path original(kThreePuma);
    std::filesystem::create_directories(folder_);
    std::filesystem::copy(original.parent_path() / "urdf", folder_ / "urdf", std::filesystem::copy_options::recursive);
    std::filesystem::copy(original, file_);
  }
  ~EditedCell() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string cell_file() const override { return file_.string(); }

  std::filesystem::path folder_ = testing::TempDir() + "hecaton_edited_" + std::to_string(getpid());
  std::filesystem::path file_ = folder_ / "cell.yaml";
};

TEST_F(EditedCell, KeepsTheFilesOfItsStart) {
  std::ofstream(file_) << "colour: red\n";
  std::filesystem::remove_all(folder_ / "urdf");
  const pid_t planner = processes().at("planner/north");
  ASSERT_TRUE(signal_process(planner, SIGKILL));
  const Ran goal = run({"goal", "north", "--named", "ready", "--wait", "--time-limit", "100s"});
  EXPECT_EQ(goal.code, 0) << goal.err;
  EXPECT_NE(processes().at("planner/north"), planner);
}

TEST_F(LiveCell, RejectsASecondUpInItsDomain) {
  const auto before = processes();
  const Ran second = run_hecaton({"up", kThreePuma, "--domain", domain(), "--headless"});
  EXPECT_EQ(second.code, 3);
  EXPECT_NE(second.err.find("another cell 'three_puma' runs in DDS domain " + domain()), std::string::npos)
      << second.err;

  const std::string broken = testing::TempDir() + "hecaton_broken_" + std::to_string(getpid()) + ".yaml";
  std::ofstream(broken) << "name: three_puma\narms: 3\n";
  const Ran bad = run_hecaton({"up", broken, "--domain", domain(), "--headless"});
  EXPECT_EQ(bad.code, 3);
  EXPECT_NE(bad.err.find(broken), std::string::npos) << bad.err;
  std::remove(broken.c_str());

  EXPECT_EQ(processes(), before);
  EXPECT_EQ(run({"goal", "west", "--named", "ready", "--wait", "--time-limit", "60s"}).code, 0);
}

}  // namespace
}  // namespace hecaton::test
