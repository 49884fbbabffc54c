#include "services/arm_driver/command_gate.hpp"

#include <algorithm>
#include <utility>

#include "services/bus/wire_rules.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services {

CommandGate::CommandGate(int joints, const CommandLimits& limits) : joints_(joints), limits_(limits) {}

// Why the sender may not, or no longer, command the arm; empty when it may.
std::optional<std::string> CommandGate::fence(const msg::ArmCommand& command) const {
  const ArmLease& newest = lease_.newest();
  const auto term = [&] { return "commands of " + command.node() + " have term " + std::to_string(command.term()); };
  if (command.term() < newest.term) return term() + ", older than term " + std::to_string(newest.term);
  const bool taken = command.term() == newest.term && !newest.planner.empty() && newest.planner != command.node();
  if (taken) return term() + ", which belongs to " + newest.planner;
  return std::nullopt;
}

// Without the supervisor a command proves a new lease. An intruder would only have to take a greater term.
std::optional<std::string> CommandGate::not_granted(const msg::ArmCommand& command,
                                                    const std::optional<CommandOrigin>& origin) const {
  const auto term = [&] { return "commands of " + command.node() + " have term " + std::to_string(command.term()); };
  if (granted_) {
    if (command.term() <= *granted_) return std::nullopt;
    return term() + ", but the supervisor has granted only " + std::to_string(*granted_);
  }
  const std::uint64_t newest = lease_.newest().term;
  if (!origin || origin->named || newest == 0 || command.term() <= newest) return std::nullopt;
  if (followed_ && origin->writer.same_participant(followed_->writer)) return std::nullopt;
  return term() + ", the supervisor is silent, and their sender is not known as this planner";
}

// A term that names no planner is that of the planner that the arm follows, while it commands: an intruder may be
// faster to take it.
bool CommandGate::held_by_another(const msg::ArmCommand& command, const std::optional<CommandOrigin>& origin) const {
  const bool unnamed = granted_ && lease_.newest() == ArmLease{{}, command.term()};
  return origin && followed_ && (command.term() == term_ || unnamed) &&
         !origin->writer.same_participant(followed_->writer) && origin->at - followed_->at <= limits_.hold;
}

// Why the contents cannot be followed.
std::optional<std::string> CommandGate::unusable(const msg::ArmCommand& command) const {
  const auto what = [&] { return "command of " + command.node() + ": "; };
  const auto q = messages::joints_from_message(command.q(), {"command of ", command.node(), ": q"}, joints_);
  if (!q) return q.error;
  const auto qd = messages::joints_from_message(command.qd(), {"command of ", command.node(), ": qd"}, joints_);
  if (!qd) return qd.error;
  if (!(command.period() > 0.0 && command.period() <= limits_.longest_period)) {
    return what() + "period = " + std::to_string(command.period()) + " must be above 0 s and at most " +
           std::to_string(limits_.longest_period) + " s";
  }
  const bool leaps = command.term() == term_ && command.sequence_number() > sequence_ + kLeap;
  if (leaps || command.sequence_number() > kLargestNumber) {
    return what() + "sequence_number = " + std::to_string(command.sequence_number()) + " leaps from " +
           std::to_string(sequence_);
  }
  return std::nullopt;
}

// The contents are judged before the term counts: a broken planner must not fence off a sound one.
Judgement CommandGate::judge(const msg::ArmCommand& command, const std::optional<CommandOrigin>& origin) {
  const auto refuse = [&](Verdict verdict, std::string why) {
    return Judgement{verdict, make_cause(msg::CauseKind::CAUSE_COMMAND_REFUSED, command.node(), std::move(why))};
  };
  if (auto stale = fence(command)) {
    ++stale_rejected_;
    return refuse(Verdict::kStaleTerm, std::move(*stale));
  }
  if (auto why = not_granted(command, origin)) return refuse(Verdict::kNotGranted, std::move(*why));
  if (held_by_another(command, origin)) {
    return refuse(Verdict::kSecondWriter, "two participants command the arm as " + command.node() + " under term " +
                                              std::to_string(command.term()));
  }
  if (auto why = unusable(command)) return refuse(Verdict::kUnusable, std::move(*why));
  if (command.term() == term_ && command.sequence_number() <= sequence_) return {Verdict::kRepeated};
  lease_.update({command.node(), command.term()});
  term_ = command.term();
  sequence_ = command.sequence_number();
  followed_ = origin;
  set_point_ = {{*messages::joints_from_message(command.q(), "q", joints_),
                 *messages::joints_from_message(command.qd(), "qd", joints_)},
                command.period()};
  return {Verdict::kAccepted};
}

LeaseCheckpoint::LeaseCheckpoint(const std::string& path) : record_(path, 0, "the driver's lease") {}

std::optional<ArmLease> LeaseCheckpoint::recall() const {
  const auto stored = record_.recall();
  if (!stored || stored->planner.back() != 0) return std::nullopt;
  if (!bus::is_usable_term(stored->term)) return ArmLease{};
  return ArmLease{stored->planner.data(), stored->term};
}

void LeaseCheckpoint::remember(const ArmLease& lease) {
  Stored stored{lease.term, {}};
  if (lease.planner.size() < stored.planner.size()) std::ranges::copy(lease.planner, stored.planner.begin());
  record_.remember(stored);
}

}  // namespace hecaton::services
