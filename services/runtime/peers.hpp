#pragma once
/// To whom the processes of a cell announce themselves where multicast is not routed.

#include <string>
#include <vector>

#include "services/bus/participant.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services {

/// With network.discovery = unicast: this machine (`interfaces`: its addresses that are used; empty: all), the cell's
/// hosts with as many participants as the cell file places on each, and network.peers. Otherwise none: multicast.
/// A host whose name cannot be resolved now is left out with a warning: it will find us, and a cell that runs must not
/// hang on its name server.
[[nodiscard]] std::vector<bus::Peer> peers_of(const config::CellFile& file, const std::vector<std::string>& interfaces);

}  // namespace hecaton::services
