#pragma once
/// Decides which commands an arm may follow: whole, finite, of the newest term, of the one planner that has it, in
/// order.

#include <cstdint>
#include <string>

#include <idl/arm.h>

#include "planner/model/limits.hpp"
#include "services/runtime/arm_lease.hpp"

namespace hecaton::services {

enum class Verdict {
  kAccepted,
  kRepeated,   ///< sent twice or overtaken within its term: nothing to tell
  kStaleTerm,  ///< its sender has been replaced, or another has its term
  kUnusable,   ///< wrong number of joints, not finite, no period
  kTooFar,     ///< the arm is somewhere else than its sender believes
};

class CommandGate {
 public:
  explicit CommandGate(int joints);

  /// Some message proved that this mandate exists: commands of older terms are refused from now on.
  void saw(const ArmLease& mandate) { mandate_.hear(mandate); }

  /// On kAccepted q(), qd() and period() are the command's; otherwise they stay what they were.
  Verdict judge(const msg::ArmCommand& command);

  [[nodiscard]] const planner::JointVector& q() const { return q_; }    ///< [rad | m]
  [[nodiscard]] const planner::JointVector& qd() const { return qd_; }  ///< [rad/s | m/s]
  [[nodiscard]] double period() const { return period_; }               ///< [s]

  [[nodiscard]] const ArmLease& mandate() const { return mandate_.newest(); }  ///< that commands must have
  [[nodiscard]] std::uint64_t term() const { return term_; }                   ///< of the last accepted command
  [[nodiscard]] std::uint64_t sequence() const { return sequence_; }           ///< of the last accepted command
  [[nodiscard]] std::uint64_t stale_rejected() const { return stale_rejected_; }
  [[nodiscard]] std::uint64_t unusable() const { return unusable_; }
  /// Why the last refused command was refused, a sentence; empty after an accepted one.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  [[nodiscard]] std::string fence(const msg::ArmCommand& command) const;

  int joints_;
  planner::JointVector q_;
  planner::JointVector qd_;
  double period_ = 0.0;
  NewestArmLease mandate_;
  std::uint64_t term_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t stale_rejected_ = 0;
  std::uint64_t unusable_ = 0;
  std::string complaint_;
};

}  // namespace hecaton::services
