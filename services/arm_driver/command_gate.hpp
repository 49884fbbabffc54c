#pragma once
/// Decides which commands an arm may follow: whole, finite, of the newest term, of the one planner that has it, in
/// order.

#include <cstdint>
#include <optional>
#include <string>

#include <idl/arm.h>

#include "planner/trajectory/set_point_interpolator.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

enum class Verdict {
  kAccepted,
  kRepeated,   ///< sent twice or overtaken within its term: nothing to tell
  kStaleTerm,  ///< its sender has been replaced, or another has its term
  kUnusable,   ///< wrong number of joints, not finite, no period
  kTooFar,     ///< the arm is somewhere else than its sender believes
};

struct Judgement {
  Verdict verdict = Verdict::kAccepted;
  msg::Cause cause = {};  ///< of a refusal; its subject is the sender
};

class CommandGate {
 public:
  explicit CommandGate(int joints);

  /// Some message proved that this lease exists: commands of older terms are refused from now on.
  void saw(const ArmLease& lease) { lease_.hear(lease); }

  /// Judges all but the distance to the arm: never kTooFar. On kAccepted set_point() is the command's; otherwise it
  /// stays what it was.
  [[nodiscard]] Judgement judge(const msg::ArmCommand& command);

  [[nodiscard]] const planner::TimedSetPoint& set_point() const { return set_point_; }
  [[nodiscard]] const ArmLease& lease() const { return lease_.newest(); }  ///< that commands must have
  [[nodiscard]] std::uint64_t term() const { return term_; }               ///< of the last accepted command
  [[nodiscard]] std::uint64_t sequence() const { return sequence_; }       ///< of the last accepted command
  [[nodiscard]] std::uint64_t stale_rejected() const { return stale_rejected_; }
  [[nodiscard]] std::uint64_t unusable() const { return unusable_; }

 private:
  [[nodiscard]] std::optional<std::string> fence(const msg::ArmCommand& command) const;

  int joints_;
  planner::TimedSetPoint set_point_;
  NewestArmLease lease_;
  std::uint64_t term_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t stale_rejected_ = 0;
  std::uint64_t unusable_ = 0;
};

}  // namespace hecaton::services
