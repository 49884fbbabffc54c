#pragma once
/// What tests that flood a cell have in common: the cell, what an intruder makes of samples and datagrams, and what
/// must hold afterwards. HECATON_FLOOD is the number of samples or datagrams. HECATON_FLOOD_SCALE multiplies the 2 s
/// within which the cell must run again.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/health.h>
#include <idl/supervisor.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"
#include "tests/cell/cli/live_cell.hpp"

namespace hecaton::test {

using Bytes = std::vector<std::uint8_t>;

inline std::size_t flood_size() {
  const char* chosen = std::getenv("HECATON_FLOOD");
  return chosen == nullptr ? 20'000 : std::stoul(chosen);
}

/// What a sample or a datagram becomes.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::size_t below(std::size_t end) { return static_cast<std::size_t>(random_() % end); }

  Bytes random_bytes(std::size_t most) {
    Bytes bytes(below(most + 1));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random_());
    return bytes;
  }

  Bytes mutated(Bytes bytes) {
    if (bytes.empty()) return random_bytes(kLongest);
    switch (below(6)) {
      case 0:
        for (std::size_t flips = 1 + below(8); flips > 0; --flips) {
          bytes[below(bytes.size())] ^= static_cast<std::uint8_t>(1U << below(8));
        }
        break;
      case 1:
        bytes.resize(below(bytes.size()));
        break;
      case 2: {
        const Bytes more = random_bytes(kLongest);
        bytes.insert(bytes.end(), more.begin(), more.end());
        break;
      }
      case 3:
        put(bytes, kNumbers.at(below(kNumbers.size())));
        break;
      case 4:
        put(bytes, kCounts.at(below(kCounts.size())));
        break;
      default:
        return random_bytes(kLongest);
    }
    return bytes;
  }

 private:
  static constexpr std::size_t kLongest = 600;
  static constexpr std::array<double, 6> kNumbers = {
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
      -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::max(),
      -std::numeric_limits<double>::max(),      std::numeric_limits<double>::denorm_min()};
  static constexpr std::array<std::uint32_t, 4> kCounts = {0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x00010000};

  /// Where a field of this size may begin.
  template <class T>
  void put(Bytes& bytes, T value) {
    if (bytes.size() < sizeof value) return;
    const std::size_t at = below((bytes.size() - sizeof value) / 4 + 1) * 4;
    std::memcpy(bytes.data() + at, &value, sizeof value);
  }

  std::mt19937_64 random_;
};

/// A cell whose arms stand at "ready".
class Flood : public LiveCell {
 protected:
  static constexpr std::uint64_t kMostGrowth = 64U << 20U;  // of a process [byte]
  static constexpr double kStill = 1e-4;                    // [rad]

  /// Until the cell runs again, with the order to resume.
  static constexpr std::chrono::seconds kRunsAgain{2};
  /// For a machine that runs other work beside: HECATON_FLOOD_SCALE.
  static int scale() {
    const char* chosen = std::getenv("HECATON_FLOOD_SCALE");
    return chosen == nullptr ? 10 : std::max(1, std::atoi(chosen));
  }

  struct Memory {
    pid_t pid = 0;
    std::uint64_t bytes = 0;  // resident
  };

  [[nodiscard]] virtual std::vector<std::string> arms() const { return {"north", "east", "west"}; }
  /// Of a participant that reads what the cell says.
  [[nodiscard]] virtual bus::ParticipantOptions watching() const {
    bus::ParticipantOptions options;
    options.partition = "three_puma";
    return options;
  }

  void SetUp() override {
    LiveCell::SetUp();
    watcher_.emplace(domain_.number(), "watcher", watching());
    states_.emplace(*watcher_);
    modes_.emplace(*watcher_);
    faults_.emplace(*watcher_);
    for (const std::string& arm : arms()) insist({"goal", arm, "--named", "ready", "--wait", "--time-limit", "60s"});
    ASSERT_TRUE(await([&] { return places_.size() == arms().size() && speed_ < 1e-6 && supervisor_; }))
        << places_.size() << " arms, " << speed_ << " rad/s";
    at_rest_ = places_;
    named_.clear();
    const Json nodes = status();
    ASSERT_FALSE(nodes.is_discarded());
    for (const Json& node : nodes.at("nodes")) {
      const auto pid = node.at("pid").get<pid_t>();
      before_[node.at("node").get<std::string>()] = {pid, memory_of(pid)};
    }
  }

  /// Resident memory [byte]; 0: the process has ended.
  [[nodiscard]] static std::uint64_t memory_of(pid_t pid) {
    std::ifstream statm("/proc/" + std::to_string(pid) + "/statm");
    std::uint64_t size = 0;
    std::uint64_t resident = 0;
    statm >> size >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  }

  /// Reads what the arms and the supervisor say.
  void watch() {
    for (const auto& sample : states_->take()) {
      if (sample.disposed) continue;
      const msg::ArmState& state = sample.value;
      places_[state.arm()] = state.q();
      speeds_[state.arm()] = std::accumulate(state.qd().begin(), state.qd().end(), 0.0,
                                             [](double most, double one) { return std::max(most, std::abs(one)); });
      speed_ = 0.0;
      for (const auto& [arm, speed] : speeds_) speed_ = std::max(speed_, speed);
      arm_modes_[state.arm()] = state.mode();
      const auto from = at_rest_.find(state.arm());
      if (from == at_rest_.end()) continue;
      for (std::size_t i = 0; i < from->second.size(); ++i) {
        farthest_ = std::max(farthest_, std::abs(state.q()[i] - from->second[i]));
      }
    }
    for (const auto& sample : faults_->take()) {
      const bool forged = !supervisor_ || !sample.writer.same_participant(*supervisor_);
      if (!sample.disposed && !forged) named_.insert(sample.value.cause().kind());
    }
    for (const auto& sample : modes_->take()) {
      if (sample.disposed) continue;
      mode_ = sample.value.mode();
      if (!supervisor_) supervisor_ = sample.writer;  // before the flood
    }
  }

  bool await(const std::function<bool()>& event) {
    const auto until = bus::Clock::now() + kPatience;
    while (bus::Clock::now() < until) {
      watch();
      if (event()) return true;
      static_cast<void>(states_->wait_for_data(std::chrono::milliseconds(20)));
    }
    return false;
  }

  /// After the last of the flood. `resume`: an open cell believes a forged contact, as it does an order to hold. Both
  /// last until a person resumes.
  void expect_unharmed(std::size_t sent, bool resume = false) {
    const auto last = bus::Clock::now();
    if (resume) insist({"resume"});
    arm_modes_.clear();
    mode_.reset();
    EXPECT_TRUE(await([&] {
      return mode_ == msg::Mode::MODE_RUN && arm_modes_.size() == arms().size() &&
             std::all_of(arm_modes_.begin(), arm_modes_.end(),
                         [](const auto& arm) { return arm.second == msg::ArmMode::ARM_RUNNING; });
    })) << "the cell does not run: ";
    const auto again = bus::Clock::now() - last;
    EXPECT_LE(again, kRunsAgain * scale());
    EXPECT_LE(farthest_, kStill) << "an arm has moved without a command of its planner";
    at_rest_.clear();
    std::uint64_t growth = 0;
    for (const auto& [node, process] : before_) {
      const std::uint64_t memory = memory_of(process.pid);
      EXPECT_GT(memory, 0U) << node << " has ended";
      if (memory > process.bytes) growth = std::max(growth, memory - process.bytes);
    }
    EXPECT_LE(growth, kMostGrowth);
    std::cout << sent << " sent; arms moved by " << farthest_ << " rad; the cell runs "
              << std::chrono::duration<double>(again).count()
              << " s after the last; memory of a process grew by at most " << static_cast<double>(growth) / 1e6
              << " MB\n";
    for (const std::string& arm : arms()) insist({"goal", arm, "--named", "home", "--wait", "--time-limit", "60s"});
  }

  /// What is not answered at first is asked again: because of the intruder's samples, or because a busy machine takes
  /// longer than --connect-timeout to exchange keys.
  void insist(std::vector<std::string> words, std::string* out = nullptr) const {
    words.insert(words.end(), {"--cell", cell_file()});
    Ran ran;
    const auto until = bus::Clock::now() + kPatience;
    do {
      ran = run(words);
    } while (ran.code != 0 && bus::Clock::now() < until);
    ASSERT_EQ(ran.code, 0) << ran.err;
    if (out != nullptr) *out = ran.out;
  }

  [[nodiscard]] Json status() const {
    std::string out;
    insist({"status", "-o", "json"}, &out);
    return Json::parse(out, nullptr, false);
  }
  std::optional<bus::Participant> watcher_;
  std::optional<bus::Reader<msg::ArmState>> states_;
  std::optional<bus::Reader<msg::CellMode>> modes_;
  std::optional<bus::Reader<msg::Fault>> faults_;
  std::optional<bus::EndpointId> supervisor_;
  std::set<msg::CauseKind> named_;  // by faults since the arms rest
  std::map<std::string, std::vector<double>> places_;
  std::map<std::string, double> speeds_;  // [rad/s]
  double speed_ = 0.0;                    // of the fastest joint [rad/s]
  std::map<std::string, std::vector<double>> at_rest_;
  std::map<std::string, msg::ArmMode> arm_modes_;
  std::map<std::string, Memory> before_;
  std::optional<msg::Mode> mode_;
  double farthest_ = 0.0;  // of an arm, from where it rested [rad]
};

}  // namespace hecaton::test
