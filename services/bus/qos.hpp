#pragma once
/// A topic's Qos in the terms of Fast DDS. Private to services/bus.

#include <chrono>
#include <string>

#include "services/bus/fastdds.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// 0 stays 0.
[[nodiscard]] Duration duration(std::chrono::nanoseconds value);

[[nodiscard]] dds::DataWriterQos writer_qos(const Qos& qos, bool keyed);
[[nodiscard]] dds::DataReaderQos reader_qos(const Qos& qos, bool keyed);

/// The name of the policy for which an endpoint was refused: "reliability".
[[nodiscard]] std::string policy_name(dds::QosPolicyId_t id);

}  // namespace hecaton::bus
