#include "services/arm_driver/command_gate.hpp"

#include <cmath>
#include <utility>

#include "services/messages/convert.hpp"

namespace hecaton::services {

CommandGate::CommandGate(int joints) : joints_(joints) {}

// Why its sender is not, or no longer, the one to command; nothing when it is.
std::optional<std::string> CommandGate::fence(const msg::ArmCommand& command) const {
  const ArmLease& newest = lease_.newest();
  const auto claim = [&] { return "commands of " + command.node() + " carry term " + std::to_string(command.term()); };
  if (command.term() < newest.term) return claim() + ", which is older than " + std::to_string(newest.term);
  const bool taken = command.term() == newest.term && !newest.planner.empty() && newest.planner != command.node();
  if (taken) return claim() + ", which is that of " + newest.planner;
  return std::nullopt;
}

// The contents are judged before the term counts as seen: a broken sender must not fence off a sound one.
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
    ++unusable_;
    return refuse(Verdict::kUnusable, !q    ? q.error
                                      : !qd ? qd.error
                                            : "command of " + command.node() + ": period = " +
                                                  std::to_string(command.period()) + " must be above 0 s");
  }
  if (command.term() == term_ && command.sequence_number() <= sequence_) return {Verdict::kRepeated};
  lease_.hear({command.node(), command.term()});
  term_ = command.term();
  sequence_ = command.sequence_number();
  set_point_ = {{*q, *qd}, command.period()};
  return {Verdict::kAccepted};
}

}  // namespace hecaton::services
