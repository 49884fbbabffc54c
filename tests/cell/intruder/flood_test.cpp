// An intruder floods all processes of a cell with forged samples of every topic, and with malformed datagrams. No arm
// moves, no process ends, memory does not grow, and the cell runs again when the flood has ceased. HECATON_FLOOD is the
// number of samples and of datagrams.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/supervisor.h>

#include "services/bus/raw_reader.hpp"
#include "services/bus/wire_rules.hpp"
#include "tests/cell/cli/live_cell.hpp"
#include "tests/cell/intruder/intruder.hpp"
#include "tests/support/rtps_datagram.hpp"
#include "tests/support/wiretap.hpp"

namespace hecaton::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kMostGrowth = 64U << 20U;  // of a process [byte]
constexpr double kStill = 1e-4;                    // [rad]

constexpr std::size_t kRead = 15;  // topics with readers in this cell

std::size_t flood_size() {
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

class Flood : public LiveCell {
 protected:
  struct Process {
    pid_t pid = 0;
    std::uint64_t memory = 0;  // [byte]
  };

  void SetUp() override {
    LiveCell::SetUp();
    bus::ParticipantOptions options;
    options.partition = "three_puma";
    watcher_.emplace(domain_.number(), "watcher", options);
    states_.emplace(*watcher_);
    modes_.emplace(*watcher_);
    for (const char* arm : {"north", "east", "west"}) reach(arm, "ready");
    ASSERT_TRUE(await([&] { return places_.size() == 3 && speed_ < 1e-6; }))
        << places_.size() << " arms, " << speed_ << " rad/s";
    at_rest_ = places_;
    for (const auto& [node, pid] : processes()) before_[node] = {pid, memory_of(pid)};
  }

  void reach(const std::string& arm, const std::string& named) const {
    const Ran ran = run({"goal", arm, "--named", named, "--wait", "--time-limit", "60s", "--cell", cell_file()});
    EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
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
    for (const auto& sample : modes_->take()) {
      if (!sample.disposed) mode_ = sample.value.mode();
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

  /// After the last of the flood.
  void expect_unharmed(std::size_t sent) {
    const auto last = bus::Clock::now();  // or after an order to resume
    arm_modes_.clear();
    mode_.reset();
    EXPECT_TRUE(await([&] {
      return mode_ == msg::Mode::MODE_RUN && arm_modes_.size() == 3 &&
             std::all_of(arm_modes_.begin(), arm_modes_.end(),
                         [](const auto& arm) { return arm.second == msg::ArmMode::ARM_RUNNING; });
    })) << "the cell does not run: ";
    const auto again = bus::Clock::now() - last;
    EXPECT_LE(farthest_, kStill) << "an arm has moved without a command of its planner";
    at_rest_.clear();
    std::uint64_t growth = 0;
    for (const auto& [node, process] : before_) {
      const std::uint64_t memory = memory_of(process.pid);
      EXPECT_GT(memory, 0U) << node << " has ended";
      if (memory > process.memory) growth = std::max(growth, memory - process.memory);
    }
    EXPECT_LE(growth, kMostGrowth);
    std::cout << sent << " sent; arms moved by " << farthest_ << " rad; the cell runs "
              << std::chrono::duration<double>(again).count()
              << " s after the last; memory of a process grew by at most " << static_cast<double>(growth) / 1e6
              << " MB\n";
    for (const char* arm : {"north", "east", "west"}) reach(arm, "home");
  }

  /// What the intruder's samples keep from answering at first is asked again.
  void insist(const std::vector<std::string>& words, std::string* out = nullptr) const {
    Ran ran;
    const auto until = bus::Clock::now() + kPatience;
    do {
      ran = run(words);
    } while (ran.code != 0 && bus::Clock::now() < until);
    ASSERT_EQ(ran.code, 0) << ran.err;
    if (out != nullptr) *out = ran.out;
  }

  [[nodiscard]] std::set<std::string> open_faults() const {
    std::set<std::string> kinds;
    std::string out;
    insist({"status", "-o", "json"}, &out);
    const Json status = Json::parse(out, nullptr, false);
    if (status.is_discarded()) return kinds;
    for (const Json& fault : status.at("faults")) kinds.insert(fault.at("kind").get<std::string>());
    return kinds;
  }

  std::optional<bus::Participant> watcher_;
  std::optional<bus::Reader<msg::ArmState>> states_;
  std::optional<bus::Reader<msg::CellMode>> modes_;
  std::map<std::string, std::vector<double>> places_;
  std::map<std::string, double> speeds_;  // [rad/s]
  double speed_ = 0.0;                    // of the fastest joint [rad/s]
  std::map<std::string, std::vector<double>> at_rest_;
  std::map<std::string, msg::ArmMode> arm_modes_;
  std::map<std::string, Process> before_;
  std::optional<msg::Mode> mode_;
  double farthest_ = 0.0;  // of an arm, from where it rested [rad]
};

/// Samples of each topic: those that the cell sends now, otherwise the seeds of the fuzz tests.
std::vector<std::vector<Bytes>> seeds(int domain) {
  constexpr std::size_t kMost = 40;
  std::vector<std::vector<Bytes>> samples(bus::kTopics.size());
  bus::ParticipantOptions options;
  options.partition = "three_puma";
  bus::Participant participant(domain, "recorder", options);
  bus::Mailbox mailbox;
  bus::RawReaders readers(participant, mailbox, 16U << 20U);
  for (const auto until = bus::Clock::now() + 3s; bus::Clock::now() < until;) {
    static_cast<void>(mailbox.wait(std::chrono::milliseconds(50)));
    static_cast<void>(mailbox.take_events());
    for (bus::RawSample& sample : readers.take()) {
      if (!sample.withdrawn && samples[sample.topic].size() < kMost) {
        samples[sample.topic].push_back(std::move(sample.bytes));
      }
    }
  }
  for (std::size_t topic = 0; topic < samples.size(); ++topic) {
    if (!samples[topic].empty()) continue;
    std::ifstream stream(std::string(HECATON_SOURCE_DIR) + "/tests/fuzz/corpus/samples/" +
                             std::string(bus::kTopics[topic].type) + "_full",
                         std::ios::binary);
    Bytes bytes{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_GT(bytes.size(), 1U) << bus::kTopics[topic].type;
    bytes.erase(bytes.begin());  // the topic's number
    samples[topic].push_back(std::move(bytes));
  }
  return samples;
}

#define HECATON_KEYED(Type, key, ...) std::string_view(#key) != "\"\"",
constexpr std::array kKeyed{HECATON_TOPICS(HECATON_KEYED)};
#undef HECATON_KEYED

/// In an open cell every program may write goals and orders as `hecaton` does: such samples are not forged.
bool is_for_everyone(const bus::TopicInfo& topic) {
  return topic.writers.find("cli") != std::string_view::npos;
}

TEST_F(Flood, OfForgedSamplesMovesNoArm) {
  const auto samples = seeds(domain_.number());
  RawParticipant intruder(domain_.number(), "");
  std::vector<std::unique_ptr<RawWriter>> writers;
  for (std::size_t topic = 0; topic < bus::kTopics.size(); ++topic) {
    const bus::TopicInfo& info = bus::kTopics[topic];
    writers.push_back(
        std::make_unique<RawWriter>(intruder, "*", std::string(info.type), info.qos, kKeyed[topic], true));
  }
  // The replies, the topics of devices and the ticks of planners have no readers here.
  std::string unread;
  ASSERT_TRUE(await([&] {
    unread.clear();
    std::size_t matched = 0;
    for (std::size_t topic = 0; topic < writers.size(); ++topic) {
      if (writers[topic]->matched())
        ++matched;
      else
        unread += std::string(bus::kTopics[topic].type) + " ";
    }
    return matched >= kRead;
  })) << unread;
  Mutator mutator(33);
  const std::size_t wanted = flood_size();
  for (std::size_t sent = 0; sent < wanted;) {
    const std::size_t topic = mutator.below(bus::kTopics.size());
    Bytes sample = samples[topic][mutator.below(samples[topic].size())];
    if (mutator.below(4) != 0) sample = mutator.mutated(std::move(sample));
    if (is_for_everyone(bus::kTopics[topic]) &&
        !bus::check_sample(*bus::topic_rule(bus::kTopics[topic].type), sample).refusal) {
      continue;
    }
    writers[topic]->write(std::string(sample.begin(), sample.end()));
    if (++sent % 256 == 0) watch();
  }
  watch();
  EXPECT_TRUE(open_faults().contains("input_refused"));
  // An open cell believes a forged contact, as it does an order to hold. Both last until a person resumes.
  insist({"resume"});
  expect_unharmed(wanted);
}

/// A HEARTBEAT of a stream that has sent millions of samples. From a writer that was not heard yet it may be true, and
/// then takes the middleware up to a minute (docs/explanation/security.md, What remains).
bool could_be_an_old_stream(const Bytes& datagram) {
  constexpr std::size_t kHeader = 20;
  constexpr std::uint8_t kHeartbeat = 7;
  for (std::size_t at = kHeader; at + 28 <= datagram.size();) {
    const bool little = (datagram[at + 1] & 1U) != 0;
    const auto number = [&](std::size_t from) {
      std::uint64_t value = 0;
      for (std::size_t i = 0; i < 8; ++i) {
        const std::size_t byte = i / 4 * 4 + (little ? 3 - i % 4 : i % 4);
        value = value << 8U | datagram[from + byte];
      }
      return value;
    };
    const auto is_old = [](std::uint64_t one) { return one > (1U << 22U) && one <= std::uint64_t{1} << 32U; };
    if (datagram[at] == kHeartbeat && (is_old(number(at + 12)) || is_old(number(at + 20)))) return true;
    const std::size_t length =
        little ? datagram[at + 2] | datagram[at + 3] << 8U : datagram[at + 2] << 8U | datagram[at + 3];
    if (length == 0) break;
    at += 4 + ((length + 3) & ~std::size_t{3});
  }
  return false;
}

class DatagramFlood : public Flood {};

TEST_F(DatagramFlood, StopsNoProcess) {
  const int first_port = 7400 + 250 * domain_.number();
  std::vector<Bytes> recorded;
  const Wiretap wiretap;
  ASSERT_TRUE(await([&] {
    for (Bytes& datagram : wiretap.take(first_port, first_port + 249)) recorded.push_back(std::move(datagram));
    return recorded.size() > 400 || !wiretap.listens();
  }));
  recorded.push_back(RtpsDatagram().data(1).heartbeat(1, 2).gap(1, 3).fragment(2, 1, 1, 100, 300).bytes());
  recorded.push_back(RtpsDatagram().announcement({{0x70, 7}, {0x15, 0xFFFFFFFF}}).bytes());
  Mutator mutator(34);
  const auto crafted = [&] {
    RtpsDatagram::Prefix sender = RtpsDatagram::prefix();
    const Bytes& real = recorded[mutator.below(recorded.size())];
    if (real.size() >= 20 && mutator.below(2) == 0) std::copy_n(real.begin() + 8, sender.size(), sender.begin());
    RtpsDatagram datagram(sender);
    constexpr std::array<std::uint32_t, 6> kWriters = {0x000002C2, 0x00000102, 0x00000103,
                                                       0x000003C2, 0x000004C2, 0x000100C2};
    constexpr std::array<std::int64_t, 5> kNumbers = {1, 1'000'000, std::int64_t{1} << 40, std::int64_t{1} << 62, -1};
    datagram.writer(kWriters.at(mutator.below(kWriters.size())));
    const auto number = [&] { return kNumbers.at(mutator.below(kNumbers.size())); };
    switch (mutator.below(6)) {
      case 0:
        return datagram.heartbeat(number(), number()).bytes();
      case 1:
        return datagram.gap(number(), number(), static_cast<std::uint32_t>(number())).bytes();
      case 2:
        return datagram.data(number(), mutator.random_bytes(200)).bytes();
      case 3:
        return datagram.fragment(number(), static_cast<std::uint32_t>(number()), 1, 60'000, 0xFFFFFFFF).bytes();
      case 4:
        return datagram.acknowledgement(number(), static_cast<std::uint32_t>(number())).bytes();
      default:
        return datagram.announcement({{static_cast<std::uint16_t>(mutator.below(0x80)), 0xFFFFFFFF}}).bytes();
    }
  };
  const DatagramSender sender(domain_.number());
  const std::size_t wanted = flood_size();
  for (std::size_t sent = 0; sent < wanted;) {
    const Bytes datagram =
        mutator.below(3) == 0 ? crafted() : mutator.mutated(recorded[mutator.below(recorded.size())]);
    if (could_be_an_old_stream(datagram)) continue;
    sender.send(datagram);
    if (++sent % 256 == 0) watch();
  }
  watch();
  EXPECT_TRUE(open_faults().contains("input_refused"));
  expect_unharmed(wanted);
}

}  // namespace
}  // namespace hecaton::test
