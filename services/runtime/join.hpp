#pragma once
/// How a service joins its cell's DDS domain.

#include <string>

#include "services/bus/participant.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/pulse.hpp"

namespace hecaton::services {

/// Index in the cell of the arm that --arm names. Throws std::runtime_error with a sentence when there is none.
[[nodiscard]] int find_arm(const config::CellFile& file, const std::string& name);

/// Throws std::runtime_error, naming those that exist, when the cell's network.interface is none of this machine's.
void require_interface(const config::CellFile& file);

/// What the cell file's network section says. Throws std::runtime_error with a sentence: unknown interface.
[[nodiscard]] bus::ParticipantOptions participant_options(const config::CellFile& file);

/// The same, joined, in the domain that the options may override. Throws std::runtime_error with a sentence:
/// unknown interface, domain out of range.
[[nodiscard]] bus::Participant make_participant(const config::CellFile& file, const ServiceOptions& options,
                                                const std::string& node, bus::Mailbox* mailbox = nullptr);

/// Heartbeat timing as the cell file's supervision section says, never laxer than readers of the topic ask by default;
/// and who else waits for signs of life.
[[nodiscard]] PulseTiming pulse_timing(const config::CellFile& file, const ServiceOptions& options);

}  // namespace hecaton::services
