#pragma once
/// How a service joins its cell's DDS domain.

#include <string>
#include <vector>

#include "services/bus/participant.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/security/keystore.hpp"

namespace hecaton::services {

/// Index in the cell of the arm that --arm names. Throws std::runtime_error with a sentence when there is none.
[[nodiscard]] int find_arm(const config::CellFile& file, const std::string& name);

/// The addresses of the interface `wanted`, a name or an address; empty for an empty text, which means all. `key`: of
/// the cell file, for the sentence of the std::runtime_error when this machine has no such interface.
[[nodiscard]] std::vector<std::string> interface_addresses(const config::CellFile& file, const std::string& key,
                                                           const std::string& wanted);

/// Throws std::runtime_error with a sentence that lists this machine's interfaces when the cell's network.interface is
/// none of them.
void require_interface(const config::CellFile& file);

/// The machines to which a participant announces itself when network.discovery is unicast; empty with multicast. They
/// are this machine, the cell's hosts with the participants that the cell file places on each, and network.peers.
/// `interfaces`: this machine's addresses in use; empty: all. A host whose name cannot be resolved is left out with a
/// warning, because a running cell must not wait for its name server. That host finds this process by itself.
[[nodiscard]] std::vector<bus::Peer> peers_of(const config::CellFile& file, const std::vector<std::string>& interfaces);

/// The folder with the keys of a role on `host`, in the keystore of the cell file; empty when the cell is open. Without
/// a host it is the first one of the keystore that has this role. Throws std::runtime_error with a sentence when the
/// keys cannot be used.
[[nodiscard]] std::filesystem::path identity_of(const config::CellFile& file, const std::string& host, Role role);

/// The participant's options from the cell file's sections network and security. Throws std::runtime_error with a
/// sentence when the interface is unknown or the keys cannot be used.
[[nodiscard]] bus::ParticipantOptions participant_options(const config::CellFile& file, const std::string& host,
                                                          Role role);

/// Joins the domain that the options choose with these participant_options(). Throws std::runtime_error with a sentence
/// when the interface is unknown or the domain out of range.
[[nodiscard]] bus::Participant make_participant(const config::CellFile& file, const ServiceOptions& options, Role role,
                                                const std::string& node, bus::Mailbox* mailbox = nullptr);

/// The same for a service that only shows the cell: its threads give way to those of other processes (give_way()), and
/// take what has arrived in batches (bus::ParticipantOptions::reception_pause).
[[nodiscard]] bus::Participant make_watching_participant(const config::CellFile& file, const ServiceOptions& options,
                                                         Role role, const std::string& node,
                                                         bus::Mailbox* mailbox = nullptr);

/// Heartbeat timing from the cell file's supervision section, at most the deadline and lease of the topic's row.
[[nodiscard]] HeartbeatTiming heartbeat_timing(const config::CellFile& file, const ServiceOptions& options);

}  // namespace hecaton::services
