#pragma once
/// Shells in which people use ROS 2 may name a Discovery Server. Fast DDS would make every participant of such a shell
/// a client of it, whom no other participant of the cell hears (docs/design/0014-discovery.md).

#include <string>
#include <vector>

namespace hecaton::bus {

/// Takes what names a server out of this process's environment and of those that it will start: ROS_DISCOVERY_SERVER,
/// and FASTDDS_ENVIRONMENT_FILE, a file of Fast DDS that may set the former. Returns what was taken out, "NAME=value";
/// nothing when there was nothing, or when it was done before. Every Participant does it before it joins.
std::vector<std::string> ignore_discovery_servers();

}  // namespace hecaton::bus
