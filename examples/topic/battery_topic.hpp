#pragma once
/// Example of a topic: the charge of an arm's battery.

#include <string>

#include <examples/topic/battery.h>

#include "services/bus/topics.hpp"

template <>
struct hecaton::bus::Topic<example::BatteryState> {
  /// The newest state of each arm, also for readers that join later. A reader misses a gauge that is silent for 3 s.
  static constexpr TopicInfo kInfo{"BatteryState", "example/BatteryState", "battery_gauge", "battery_watch",
                                   Qos{.reliable = true, .transient_local = true, .deadline = 3s}};
  static std::string key_of(const example::BatteryState& sample) { return sample.arm(); }
};
