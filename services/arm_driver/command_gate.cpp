#include "services/arm_driver/command_gate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/messages/convert.hpp"

namespace hecaton::services {

CommandGate::CommandGate(int joints) : joints_(joints) {}

// Why the sender may not, or no longer, command the arm; empty when it may.
std::optional<std::string> CommandGate::fence(const msg::ArmCommand& command) const {
  const ArmLease& newest = lease_.newest();
  const auto term = [&] { return "commands of " + command.node() + " have term " + std::to_string(command.term()); };
  if (command.term() < newest.term) return term() + ", older than term " + std::to_string(newest.term);
  const bool taken = command.term() == newest.term && !newest.planner.empty() && newest.planner != command.node();
  if (taken) return term() + ", which belongs to " + newest.planner;
  return std::nullopt;
}

// The contents are judged before the term counts: a broken planner must not fence off a sound one.
Judgement CommandGate::judge(const msg::ArmCommand& command) {
  const auto refuse = [&](Verdict verdict, std::string why) {
    return Judgement{verdict, make_cause(msg::CauseKind::CAUSE_COMMAND_REFUSED, command.node(), std::move(why))};
  };
  if (auto stale = fence(command)) {
    ++stale_rejected_;
    return refuse(Verdict::kStaleTerm, std::move(*stale));
  }
  const auto q = messages::joints_from_message(command.q(), {"command of ", command.node(), ": q"}, joints_);
  const auto qd = messages::joints_from_message(command.qd(), {"command of ", command.node(), ": qd"}, joints_);
  const bool period_usable = std::isfinite(command.period()) && command.period() > 0.0;
  if (!q || !qd || !period_usable) {
    return refuse(Verdict::kUnusable, !q    ? q.error
                                      : !qd ? qd.error
                                            : "command of " + command.node() + ": period = " +
                                                  std::to_string(command.period()) + " must be above 0 s");
  }
  if (command.term() == term_ && command.sequence_number() <= sequence_) return {Verdict::kRepeated};
  lease_.update({command.node(), command.term()});
  term_ = command.term();
  sequence_ = command.sequence_number();
  set_point_ = {{*q, *qd}, command.period()};
  return {Verdict::kAccepted};
}

LeaseCheckpoint::LeaseCheckpoint(const std::string& path) : record_(path, 0, "the driver's lease") {}

std::optional<ArmLease> LeaseCheckpoint::recall() const {
  const auto stored = record_.recall();
  if (!stored || stored->planner.back() != 0) return std::nullopt;
  return ArmLease{stored->planner.data(), stored->term};
}

void LeaseCheckpoint::remember(const ArmLease& lease) {
  Stored stored{lease.term, {}};
  if (lease.planner.size() < stored.planner.size()) std::ranges::copy(lease.planner, stored.planner.begin());
  record_.remember(stored);
}

}  // namespace hecaton::services
