#include "services/replay/verification.hpp"

#include <algorithm>
#include <bit>
#include <deque>
#include <filesystem>
#include <memory>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include <idl/arm.h>
#include <idl/planner.h>

#include "services/bus/recorded_sample.hpp"
#include "services/recorder/current_messages.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/recording.hpp"
#include "services/tick_log/cell_changes.hpp"
#include "services/tick_log/program.hpp"
#include "services/tick_log/tick_reader.hpp"

namespace hecaton::services::replay {
namespace {

using recorder::McapMessage;

constexpr const char* kNoSnapshot = "the recording began, or goes on, between two snapshots of the planner";
constexpr const char* kGap = "ticks before them are missing in the recording";
constexpr const char* kBroken = "a tick cannot be read";
constexpr const char* kOtherPlanner = "the memory of the planner cannot be loaded by this program";

/// Why the memory in a snapshot of `program` cannot be used.
std::string other_memory(const std::string& program) {
  return "the memory of the planner has layout " + std::to_string(planner_memory_of(program)) + ", of program " +
         program + ", and this program, " + program_text() + ", continues from layout " +
         std::to_string(kPlannerMemory) + " only; verify with the Hecaton that recorded it";
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// The first joint that differs; empty: none.
std::optional<std::size_t> first_difference(const std::vector<double>& recorded, const planner::JointVector& computed) {
  for (std::size_t j = 0; j < recorded.size(); ++j) {
    if (static_cast<Eigen::Index>(j) >= computed.size()) return j;
    if (!same_bits(recorded[j], computed[static_cast<Eigen::Index>(j)])) return j;
  }
  return std::nullopt;
}

/// A set-point that was sent.
struct SentSetPoint {
  std::string process;       ///< of the planner
  std::uint64_t number = 0;  ///< grows as long as the planner lives
  bool operator==(const SentSetPoint&) const = default;
};

/// Set-points of ticks and of commands that wait for each other: they come on two topics.
class CommandComparison {
 public:
  /// `what`: q, then q̇.
  void tick(const SentSetPoint& key, std::vector<double> what, ArmVerification& report) {
    match(ticks_, commands_, key, std::move(what), report);
  }
  void command(const SentSetPoint& key, std::vector<double> what, ArmVerification& report) {
    match(commands_, ticks_, key, std::move(what), report);
  }
  /// A new planner of this process sends its first set-point: numbers begin anew, as in each episode of a simulation.
  void begin_anew(const SentSetPoint& first) {
    const auto is_former = [&](const auto& waiting) {
      return waiting.first.process == first.process && waiting.first.number > first.number;
    };
    std::erase_if(ticks_, is_former);
    std::erase_if(commands_, is_former);
  }

 private:
  static constexpr std::size_t kMostWaiting = 512;
  using Waiting = std::deque<std::pair<SentSetPoint, std::vector<double>>>;

  static void match(Waiting& own, Waiting& other, const SentSetPoint& key, std::vector<double> what,
                    ArmVerification& report) {
    const auto found = std::find_if(other.begin(), other.end(), [&](const auto& entry) { return entry.first == key; });
    if (found == other.end()) {
      own.emplace_back(key, std::move(what));
      if (own.size() > kMostWaiting) own.pop_front();
      return;
    }
    ++report.commands;
    const bool same = std::equal(what.begin(), what.end(), found->second.begin(), found->second.end(), same_bits);
    if (!same) ++report.differing_commands;
    other.erase(found);
  }

  Waiting ticks_;
  Waiting commands_;
};

/// The planner of one process. Its messages follow each other, and numbers begin anew with each process.
class Stream {
 public:
  Stream(const planner::Cell& cell, int self) : arm_(cell.arms[self].arm), reader_(cell, self) {}

  void take(const msg::PlannerTick& tick, double time, ArmVerification& report) {
    // Numbers begin anew with 1 after periods that the planner has not published.
    const std::uint64_t number = tick.sequence_number();
    const bool anew = last_ && number <= *last_;
    const std::uint64_t expected = anew ? 1 : last_ ? *last_ + 1 : number;
    report.missing += number - std::min(number, expected);
    if (number != expected) {
      lose(kGap);
    } else if (anew) {
      lose(kNoSnapshot);
    }
    last_ = number;
    if (!planner_ && !tick.snapshot()) return skip(report);
    if (auto error = reader_.take(tick)) {
      lose(kBroken);
      return skip(report);
    }
    if (tick.snapshot() && !begin(tick, time, report)) return skip(report);
    recompute(tick, time, report);
  }

 private:
  void lose(std::string reason) {
    planner_.reset();
    reason_ = std::move(reason);
  }
  void skip(ArmVerification& report) const { ++report.unverified[reason_]; }

  /// The planner continues from the recorded memory. One that was recomputed up to here must have the same.
  bool begin(const msg::PlannerTick& tick, double time, ArmVerification& report) {
    const bool other = planner_memory_of(tick.program()) != kPlannerMemory;
    // A planner that has just been built has no memory, but options.
    std::unique_ptr<planner::ArmPlanner> planner;
    if (!other || tick.memory().empty()) planner = reader_.planner(tick);
    if (!planner) {
      lose(other ? other_memory(tick.program()) : kOtherPlanner);
      return false;
    }
    if (planner_ && !tick.memory().empty()) {
      ++report.memories;
      if (planner_->save() != tick.memory()) {
        ++report.differing_memories;
        if (!report.first) report.first = TickDifference{tick.sequence_number(), time, tick.node(), {}, {}, {}, {}};
      }
    }
    planner_ = std::move(planner);
    return true;
  }

  void recompute(const msg::PlannerTick& tick, double time, ArmVerification& report) {
    planner_->receive(reader_.events());
    if (!tick.planned()) {
      ++report.without_set_point;
      return;
    }
    const planner::TickResult result = planner_->step(reader_.inputs());
    static_cast<void>(planner_->plan_ahead(reader_.inputs(), result));
    const auto q = first_difference(tick.q(), result.q);
    const auto qd = first_difference(tick.qd(), result.qd);
    const bool sizes = static_cast<Eigen::Index>(tick.q().size()) == result.q.size() &&
                       static_cast<Eigen::Index>(tick.qd().size()) == result.qd.size();
    if (!q && !qd && sizes) {
      ++report.equal;
      return;
    }
    ++report.differing;
    if (report.first) return;
    TickDifference& first = report.first.emplace();
    first.tick = tick.sequence_number();
    first.time = time;
    first.node = tick.node();
    first.velocity = !q && qd;
    const std::size_t joint = q.value_or(qd.value_or(0));
    const auto index = static_cast<Eigen::Index>(joint);
    first.joint = "beyond those of the arm";
    if (!sizes) return;
    first.joint = arm_.model->joint_names[joint];
    first.recorded = first.velocity ? tick.qd()[joint] : tick.q()[joint];
    first.recomputed = first.velocity ? result.qd[index] : result.q[index];
  }

  const planner::Arm& arm_;
  TickReader reader_;
  std::unique_ptr<planner::ArmPlanner> planner_;  ///< null: its memory is not known
  std::optional<std::uint64_t> last_;             ///< number of the last message
  std::string reason_ = kNoSnapshot;              ///< why the memory is not known
};

class Verifier {
 public:
  /// `live`: recorded in a running cell, not in a simulation.
  Verifier(const planner::Cell& cell, bool live, const std::vector<std::string>& arms)
      : cell_(cell), live_(live), commands_(cell.arms.size()) {
    for (const planner::PlannedArm& planned : cell.arms) {
      result_.arms.emplace_back().arm = planned.arm.name;
      const auto named = std::find(arms.begin(), arms.end(), planned.arm.name);
      wanted_.push_back(arms.empty() || named != arms.end());
    }
  }

  void take(const McapMessage& message) {
    if (!message.channel->schema) return;
    if (!began_) began_ = message.log_time;
    if (message.channel->topic == bus::Topic<msg::PlannerTick>::kInfo.name) {
      take_tick(message);
    } else if (message.channel->topic == bus::Topic<msg::ArmCommand>::kInfo.name) {
      take_command(message);
    }
  }

  void note(std::string sentence) {
    const auto known = std::find(result_.notes.begin(), result_.notes.end(), sentence);
    if (known == result_.notes.end()) result_.notes.push_back(std::move(sentence));
  }

  Verification finish() {
    if (undecoded_ > 0) {
      note(std::to_string(undecoded_) + " ticks break a rule of the wire: they are not verified");
    }
    for (std::string& sentence : current_.notes()) note(std::move(sentence));
    for (const auto& [sentence, count] : refused_) {
      note(std::to_string(count) + " messages are not verified: " + sentence);
    }
    Verification result;
    result.notes = std::move(result_.notes);
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (wanted_[i]) result.arms.push_back(std::move(result_.arms[i]));
    }
    return result;
  }

 private:
  [[nodiscard]] int index_of(const std::string& arm) const {
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (result_.arms[i].arm == arm && wanted_[i]) return static_cast<int>(i);
    }
    return -1;
  }

  /// The message in this program's version; empty: it is refused.
  template <class T>
  std::optional<T> decoded(const recorder::CurrentMessage& current) {
    constexpr std::size_t kMostSentences = 20;
    if (current.refusal.empty()) return bus::decode_recorded<T>(current.data).value;
    if (refused_.size() < kMostSentences || refused_.count(current.refusal) > 0) ++refused_[current.refusal];
    return std::nullopt;
  }

  void take_tick(const McapMessage& message) {
    const recorder::CurrentMessage current = current_.of(message);
    const auto value = decoded<msg::PlannerTick>(current);
    if (!value) {
      if (current.refusal.empty()) ++undecoded_;
      return;
    }
    const msg::PlannerTick& tick = *value;
    const int arm = index_of(tick.arm());
    if (arm < 0) return;
    ArmVerification& report = result_.arms[static_cast<std::size_t>(arm)];
    ++report.recorded;
    if (!current.lack.empty()) {
      // A default is not what the planner had.
      ++report.unverified[std::string(current.lack) + " of a tick; verify with the Hecaton that recorded it"];
      return;
    }
    if (tick.snapshot() && tick.program() != program_text()) {
      note("recorded by program " + tick.program() + ", and recomputed by " + program_text() +
           ": differences may come from that");
    }
    // Writers beyond Recording::kMostChannels share a channel, and two planners of an arm overlap when one takes over.
    Stream& stream = streams_.try_emplace({arm, writer_of(message), tick.node()}, cell_of(arm), arm).first->second;
    stream.take(tick, seconds(message.log_time), report);
    const auto key = set_point_of(message, tick.number());
    if (!key) return;
    CommandComparison& commands = commands_[static_cast<std::size_t>(arm)];
    if (tick.snapshot() && tick.memory().empty()) commands.begin_anew(*key);
    if (tick.planned()) commands.tick(*key, joined(tick.q(), tick.qd()), report);
  }

  void take_command(const McapMessage& message) {
    const auto value = decoded<msg::ArmCommand>(current_.of(message));
    if (!value) return;
    const msg::ArmCommand& command = *value;
    const int arm = index_of(command.arm());
    if (arm < 0) return;
    const auto key = set_point_of(message, command.sequence_number());
    if (!key) return;
    commands_[static_cast<std::size_t>(arm)].command(*key, joined(command.q(), command.qd()),
                                                     result_.arms[static_cast<std::size_t>(arm)]);
  }

  static std::string writer_of(const McapMessage& message) {
    const auto writer = message.channel->metadata.find("writer");
    return writer == message.channel->metadata.end() ? std::string() : writer->second;
  }
  /// Empty: the writer is unknown, or the set-point was not sent.
  static std::optional<SentSetPoint> set_point_of(const McapMessage& message, std::uint64_t number) {
    constexpr std::size_t kProcess = 24;  // digits
    std::string process = writer_of(message).substr(0, kProcess);
    const bool known = process.find_first_not_of('0') != std::string::npos;
    if (!known || number == 0) return std::nullopt;
    return SentSetPoint{std::move(process), number};
  }
  static std::vector<double> joined(std::vector<double> q, const std::vector<double>& qd) {
    q.insert(q.end(), qd.begin(), qd.end());
    return q;
  }

  [[nodiscard]] double seconds(std::uint64_t log_time) const {
    return log_time < *began_ ? 0.0 : 1e-9 * static_cast<double>(log_time - *began_);
  }

  /// The cell with which the planner of the arm worked.
  [[nodiscard]] const planner::Cell& cell_of(int arm) {
    return cells_.try_emplace(arm, live_ ? planner::live_cell(cell_, arm) : cell_).first->second;
  }

  const planner::Cell& cell_;
  bool live_;
  std::map<int, planner::Cell> cells_;  ///< by arm
  Verification result_;
  std::vector<bool> wanted_;
  std::map<std::tuple<int, std::string, std::string>, Stream> streams_;  ///< by arm, writer and node
  std::vector<CommandComparison> commands_;
  std::optional<std::uint64_t> began_;
  std::uint64_t undecoded_ = 0;
  recorder::CurrentMessages current_;
  std::map<std::string, std::uint64_t> refused_;  ///< messages, by sentence
};

/// Makes the changes of a simulation. False: it is the recording of a live cell.
bool apply_changes(const std::string& path, planner::Cell& cell) {
  std::optional<std::string> text;
  recorder::McapVisitor visitor;
  visitor.attachment = [&](const recorder::McapAttachment& file) {
    if (file.name == recorder::Recording::kSimulation) text = std::string(file.data.begin(), file.data.end());
  };
  visitor.chunk = [](std::uint64_t) { return false; };
  recorder::read_mcap(path, visitor);
  if (!text) return false;
  const std::optional<CellChanges> changes = CellChanges::from_json(*text);
  if (!changes) throw recorder::RecordingError(path + ": its attachment simulation.json cannot be read");
  if (const auto objection = changes->apply(cell)) throw recorder::RecordingError(path + ": " + *objection);
  return true;
}

}  // namespace

Verification verify_recording(const std::vector<std::string>& paths, const planner::Cell& cell,
                              const std::vector<std::string>& arms, const std::function<void(double share)>& progress) {
  planner::Cell changed = cell;
  const bool simulated = apply_changes(paths.front(), changed);
  Verifier verifier(changed, !simulated, arms);
  double total = 0.0;
  for (const std::string& path : paths) {
    std::error_code error;
    total += static_cast<double>(std::filesystem::file_size(path, error));
  }
  double before = 0.0;
  for (const std::string& path : paths) {
    recorder::McapVisitor visitor;
    visitor.message = [&](const McapMessage& message) { verifier.take(message); };
    visitor.chunk = [&](std::uint64_t at) {
      if (progress && total > 0.0) progress((before + static_cast<double>(at)) / total);
      return true;
    };
    const recorder::McapReport report = recorder::read_mcap(path, visitor);
    before += static_cast<double>(report.bytes);
    if (report.cut)
      verifier.note(path + " has no end: its recorder was killed, had no room on the disk, or still writes");
    for (const std::string& damage : report.damages) verifier.note(path + ": " + damage);
  }
  return verifier.finish();
}

}  // namespace hecaton::services::replay
