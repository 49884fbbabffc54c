#pragma once
/// Recomputes the recorded ticks of planners from their recorded inputs, and compares the set-points bit by bit.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"

namespace hecaton::services::replay {

/// A set-point that recomputation does not repeat.
struct TickDifference {
  std::uint64_t tick = 0;   ///< PlannerTick::sequence_number
  double time = 0.0;        ///< since the first message of the recording [s]
  std::string node;         ///< the planner
  std::string joint;        ///< first one that differs; empty: the memory of the planner, not the set-point
  bool velocity = false;    ///< q̇ differs, and q does not
  double recorded = 0.0;    ///< [rad | m] or [rad/s | m/s]
  double recomputed = 0.0;  ///< the same
};

/// The ticks of one arm. recorded = equal + differing + without_set_point + the sum of `unverified`.
struct ArmVerification {
  std::string arm;
  std::uint64_t recorded = 0;           ///< ticks in the recording
  std::uint64_t equal = 0;              ///< recomputed, with the same bits
  std::uint64_t differing = 0;          ///< recomputed, with other bits
  std::uint64_t without_set_point = 0;  ///< recomputed; the arm's state was unknown, so there is nothing to compare
  std::map<std::string, std::uint64_t> unverified;  ///< not recomputed: the reason, and how many
  std::uint64_t missing = 0;                        ///< gaps: ticks that the recorder has not received
  std::uint64_t memories = 0;                       ///< memories of the planner that were compared in addition
  std::uint64_t differing_memories = 0;
  std::uint64_t commands = 0;  ///< set-points that were compared with the recorded ArmCommand, too
  std::uint64_t differing_commands = 0;
  std::optional<TickDifference> first;

  [[nodiscard]] std::uint64_t recomputed() const { return equal + differing; }
  [[nodiscard]] bool differs() const { return differing + differing_memories + differing_commands > 0; }
};

struct Verification {
  std::vector<ArmVerification> arms;  ///< in the order of the cell
  std::vector<std::string> notes;     ///< what a reader must know, a sentence each
};

/// Reads the files, which follow each other in time. `cell`: that of the recording. `arms`: names of its arms; empty:
/// all. `progress`: called with the share that was read; empty: not called. Throws RecordingError with a sentence.
[[nodiscard]] Verification verify_recording(const std::vector<std::string>& paths, const planner::Cell& cell,
                                            const std::vector<std::string>& arms,
                                            const std::function<void(double share)>& progress = {});

}  // namespace hecaton::services::replay
