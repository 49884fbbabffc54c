#pragma once
/// A row's Qos in the terms of Fast DDS. Private to services/bus.

#include <chrono>

#include "services/bus/fastdds.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// 0 stays 0; see `or_infinite` for what "never" means.
[[nodiscard]] Duration duration(std::chrono::nanoseconds value);

[[nodiscard]] dds::DataWriterQos writer_qos(const Qos& qos, bool keyed, int strength);
[[nodiscard]] dds::DataReaderQos reader_qos(const Qos& qos, bool keyed);

}  // namespace hecaton::bus
