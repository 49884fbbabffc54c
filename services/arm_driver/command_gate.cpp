#include "services/arm_driver/command_gate.hpp"

#include <algorithm>
#include <cmath>

#include "services/bus/convert.hpp"

namespace hecaton::services {

CommandGate::CommandGate(int joints) : joints_(joints) {}

void CommandGate::saw_term(std::uint64_t term) {
  newest_term_ = std::max(newest_term_, term);
}

// The contents are judged before the term counts as seen: a broken sender must not fence off a sound one.
Verdict CommandGate::judge(const msg::ArmCommand& command) {
  if (command.term() < newest_term_) {
    ++stale_rejected_;
    complaint_ = "commands of " + command.node() + " carry term " + std::to_string(command.term()) +
                 ", which is older than " + std::to_string(newest_term_);
    return Verdict::kStaleTerm;
  }
  const auto q = bus::joints_from_message(command.q(), "command of " + command.node() + ": q", joints_);
  const auto qd = bus::joints_from_message(command.qd(), "command of " + command.node() + ": qd", joints_);
  const bool period_usable = std::isfinite(command.period()) && command.period() > 0.0;
  if (!q || !qd || !period_usable) {
    ++unusable_;
    complaint_ = !q    ? q.error
                 : !qd ? qd.error
                       : "command of " + command.node() + ": period = " + std::to_string(command.period()) +
                             " must be above 0 s";
    return Verdict::kUnusable;
  }
  if (command.term() == term_ && command.sequence_number() <= sequence_) return Verdict::kRepeated;
  newest_term_ = command.term();
  term_ = command.term();
  sequence_ = command.sequence_number();
  q_ = *q;
  qd_ = *qd;
  period_ = command.period();
  complaint_.clear();
  return Verdict::kAccepted;
}

}  // namespace hecaton::services
