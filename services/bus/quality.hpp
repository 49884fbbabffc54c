#pragma once
/// A row's Qos in the terms of Fast DDS. Private to services/bus.

#include <chrono>

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// 0 stays 0; see `or_infinite` for what "never" means.
[[nodiscard]] eprosima::fastrtps::Duration_t duration(std::chrono::nanoseconds value);

[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(const Qos& qos, bool keyed, int strength);
[[nodiscard]] eprosima::fastdds::dds::DataReaderQos reader_qos(const Qos& qos, bool keyed);

}  // namespace hecaton::bus
