#pragma once
/// Decides which commands an arm may follow, and keeps the arm's lease beyond the driver's process.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <idl/arm.h>

#include "planner/trajectory/set_point_interpolator.hpp"
#include "services/bus/mailbox.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/atomic_file.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

enum class Verdict {
  kAccepted,
  kRepeated,      ///< a repetition, or overtaken within its term; not worth a report
  kStaleTerm,     ///< of an older term, or of a term that another planner has
  kUnusable,      ///< wrong number of joints, a value that is not finite, or no period
  kTooFar,        ///< the set-point is too far from the arm's position
  kSecondWriter,  ///< another participant commands the arm under the same term and name
  kNotGranted,    ///< of a newer term that neither the supervisor nor its sender proves
};

struct Judgement {
  Verdict verdict = Verdict::kAccepted;
  msg::Cause cause = {};  ///< of a refusal; its subject is the sender
};

/// Where a command comes from.
struct CommandOrigin {
  bus::EndpointId writer;
  bus::Clock::time_point at;  ///< of its arrival
  bool named = false;         ///< discovery knows no other participant with the name of this planner
};

struct CommandLimits {
  /// Longest period of a command [s]. The largest distance of a set-point grows with it.
  double longest_period = 10.0;
  /// A participant that was accepted within this time is the only one under its term.
  bus::Clock::duration hold{0};
};

/// Accepts commands that are complete, finite, in order, of the newest term and of the planner that has this term.
/// Under one term, and under a new one that names no planner, it follows one participant, until that has been silent
/// for `hold`.
class CommandGate {
 public:
  /// A sequence number that grows by more than this is refused, so that no command can end the sequence.
  static constexpr std::uint64_t kLeap = std::uint64_t{1} << 20U;
  static constexpr std::uint64_t kLargestNumber = std::uint64_t{1} << 53U;

  explicit CommandGate(int joints, const CommandLimits& limits = {});

  /// A message has proved that this lease exists: the gate refuses commands of older terms from now on.
  void observe_lease(const ArmLease& lease) { lease_.update(lease); }
  /// The greatest term that the supervisor has granted for this arm. Empty: the driver does not hear the supervisor.
  /// A command of the participant that the arm followed last, or of one that is `named`, then proves by itself that its
  /// term was granted.
  void set_granted(std::optional<std::uint64_t> term) { granted_ = term; }

  /// Judges a command, except for its distance from the arm (never kTooFar). With kAccepted, set_point() becomes the
  /// command's; otherwise it stays. `origin`: empty: unknown, and any participant may continue.
  [[nodiscard]] Judgement judge(const msg::ArmCommand& command, const std::optional<CommandOrigin>& origin = {});

  [[nodiscard]] const planner::TimedSetPoint& set_point() const { return set_point_; }
  [[nodiscard]] const ArmLease& lease() const { return lease_.newest(); }  ///< the one that commands must have
  [[nodiscard]] std::uint64_t term() const { return term_; }               ///< of the last accepted command
  [[nodiscard]] std::uint64_t sequence() const { return sequence_; }       ///< of the last accepted command
  [[nodiscard]] std::uint64_t stale_rejected() const { return stale_rejected_; }

 private:
  [[nodiscard]] std::optional<std::string> fence(const msg::ArmCommand& command) const;
  [[nodiscard]] std::optional<std::string> unusable(const msg::ArmCommand& command) const;
  /// Why the term of the command was not granted; empty when it was.
  [[nodiscard]] std::optional<std::string> not_granted(const msg::ArmCommand& command,
                                                       const std::optional<CommandOrigin>& origin) const;
  [[nodiscard]] bool held_by_another(const msg::ArmCommand& command, const std::optional<CommandOrigin>& origin) const;

  int joints_;
  CommandLimits limits_;
  planner::TimedSetPoint set_point_;
  NewestArmLease lease_;
  std::uint64_t term_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t stale_rejected_ = 0;
  std::optional<std::uint64_t> granted_;
  std::optional<CommandOrigin> followed_;  ///< origin of the last accepted command
};

/// The newest lease that a driver knows, in a mapped file: a restarted driver without it would follow a planner that
/// has been replaced (docs/explanation/0008-arm-leases.md). The file need not survive the machine.
class LeaseCheckpoint {
 public:
  /// An empty path keeps nothing. Throws std::runtime_error with a sentence when the file cannot be used.
  explicit LeaseCheckpoint(const std::string& path);

  /// The lease that was stored last. Its term is 0 if the stored one is not usable (wire_rules.hpp): the driver would
  /// refuse every other one.
  [[nodiscard]] std::optional<ArmLease> recall() const;
  /// Stores the lease. Of a planner with a name above 255 bytes it stores the term alone.
  void remember(const ArmLease& lease);

 private:
  struct Stored {
    std::uint64_t term;
    std::array<char, 256> planner;  ///< ends with 0
  };
  MappedRecord<Stored> record_;
};

}  // namespace hecaton::services
