#pragma once
/// Names of the policies for which a peer is refused. Private to services/bus.

#include <string>

#include "services/bus/fastdds.hpp"

namespace hecaton::bus {

inline std::string policy_name(dds::QosPolicyId_t id) {
  switch (id) {
    case dds::RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case dds::DURABILITY_QOS_POLICY_ID:
      return "durability";
    case dds::DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case dds::LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    case dds::OWNERSHIP_QOS_POLICY_ID:
      return "ownership";
    case dds::PARTITION_QOS_POLICY_ID:
      return "partition";
    default:
      return "policy " + std::to_string(static_cast<int>(id));
  }
}

}  // namespace hecaton::bus
