#pragma once
/// All topics of a cell. A row of HECATON_TOPICS has the topic's type, key, writers, readers and quality of service. To
/// add a topic, write its type in idl/, include the type's header in type_support.hpp, and add a row. Programs outside
/// of services/ define topics of their own (docs/how-to/add-a-topic.md).

#include <array>
#include <chrono>
#include <string>
#include <string_view>

namespace hecaton::bus {

using namespace std::chrono_literals;

/// Quality of service. Durations of 0 mean "never".
struct Qos {
  bool reliable = false;                    ///< lost samples are sent again
  bool transient_local = false;             ///< late joiners get the samples that the writer keeps
  int depth = 1;                            ///< number of samples kept for each key
  int reader_depth = 0;                     ///< the same of a reader, where writers compete for a key; 0: depth
  std::chrono::milliseconds deadline{0};    ///< of a reader, for each key: longer silence is an event
  std::chrono::milliseconds heartbeat{20};  ///< of reliable writers with unacknowledged samples
  int instances = 512;                      ///< most keys at a time (Fast DDS has 10 by default)
  int retained = 0;                         ///< most living keys of a writer; a new one retires the oldest; 0: no limit
  /// A participant that has written a key within this time is the key's only writer: readers refuse the samples of
  /// others and report a second writer (stream_holder.hpp). 0: several participants may write a key.
  std::chrono::milliseconds hold{0};
  /// Each arm has a partition of its own, so a sample is sent only to the readers of its arm (WriterOptions::key).
  bool partition_per_key = false;
  bool other_arms_read = false;  ///< with that: with keys, the nodes of an arm may read what those of others write
  bool reports_writers = false;  ///< readers report two writers of a key, but refuse none: terms or rules decide
};

/// A row of the table of topics.
struct TopicInfo {
  std::string_view type;     ///< name of the message type, without its namespace
  std::string_view name;     ///< on the wire
  std::string_view writers;  ///< kinds of nodes
  std::string_view readers;  ///< kinds of nodes
  Qos qos;                   ///< of writers and readers
};

// No topic has exclusive ownership: a writer of greater strength, also a forged one, would hide all other writers from
// the readers. Terms decide between writers of commands and of cell modes. Readers keep several cell modes, so that one
// of an old leader replaces none of the new leader before it is taken. Replies are transient-local because the replying
// side may discover the client's reader only after the request. They have no key; clients select theirs by client and
// request number.
// clang-format off: a table
#define HECATON_TOPICS(TOPIC)                                                                                          \
  /*    type               key                                   writers           readers                     QoS */  \
  TOPIC(ArmState, sample.arm(), "driver", "planner world supervisor", .deadline = 50ms, .hold = 200ms,                 \
        .partition_per_key = true, .other_arms_read = true)                                                            \
  TOPIC(ArmCommand, sample.arm(), "planner", "driver", .reliable = true, .heartbeat = 5ms, .partition_per_key = true)  \
  TOPIC(DeviceRequest, "", "cli", "driver", .reliable = true, .depth = 32)                                             \
  TOPIC(DeviceCommand, sample.arm(), "driver", "driver program", .hold = 200ms, .partition_per_key = true)             \
  TOPIC(DeviceState, sample.arm(), "driver program", "driver", .hold = 200ms, .partition_per_key = true)               \
  TOPIC(DeviceReply, "", "driver", "cli", .reliable = true, .transient_local = true, .depth = 4)                       \
  TOPIC(ToolState, sample.arm(), "driver", "world cli", .reliable = true, .transient_local = true, .hold = 500ms)      \
  TOPIC(ObstacleShapes, sample.name(), "world", "all", .reliable = true, .transient_local = true, .instances = 4096)   \
  TOPIC(ObstacleStates, "", "world", "all", .deadline = 50ms, .hold = 200ms)                                           \
  TOPIC(WorldEditRequest, "", "cli perception", "world", .reliable = true, .depth = 32)                                \
  TOPIC(WorldEditReply, "", "world", "cli perception", .reliable = true, .transient_local = true, .depth = 32)         \
  TOPIC(RangeScan, sample.sensor(), "world driver", "planner", .hold = 500ms)                                          \
  TOPIC(ContactReport, "", "world", "supervisor cli", .reliable = true, .transient_local = true)                       \
  TOPIC(Goal, sample.arm() + "/" + sample.goal(), "cli clients", "planner", .reliable = true, .transient_local = true, \
        .instances = 4096, .retained = 256)                                                                            \
  TOPIC(GoalStatus, sample.arm() + "/" + sample.goal(), "planner", "planner cli clients supervisor", .reliable = true, \
        .transient_local = true, .instances = 4096, .retained = 8, .partition_per_key = true, .other_arms_read = true) \
  TOPIC(CoupledPlan, sample.arm(), "planner", "planner", .reliable = true, .transient_local = true)                    \
  TOPIC(CoupledPlanProgress, sample.arm(), "planner", "planner", .reliable = true, .transient_local = true,            \
        .heartbeat = 5ms)                                                                                              \
  TOPIC(Heartbeat, sample.node(), "all", "supervisor", .deadline = 20ms, .reports_writers = true)                      \
  TOPIC(Reachability, sample.host(), "agent", "agent supervisor", .hold = 200ms)                                       \
  TOPIC(ProcessEvent, sample.process(), "agent", "supervisor", .reliable = true, .transient_local = true, .depth = 8,  \
        .heartbeat = 5ms)                                                                                              \
  TOPIC(CellMode, "", "supervisor", "all", .reader_depth = 32, .deadline = 100ms, .reports_writers = true)             \
  TOPIC(Fault, sample.id(), "supervisor", "all", .reliable = true, .transient_local = true, .instances = 4096,         \
        .retained = 256)                                                                                               \
  TOPIC(SupervisorRequest, "", "cli supervisor", "supervisor", .reliable = true, .depth = 32)                          \
  TOPIC(SupervisorReply, "", "supervisor", "cli", .reliable = true, .transient_local = true, .depth = 4)               \
  TOPIC(RecorderRequest, "", "cli", "recorder", .reliable = true, .depth = 32)                                         \
  TOPIC(RecorderReply, "", "recorder", "cli", .reliable = true, .transient_local = true, .depth = 4)                   \
  TOPIC(PlannerTick, sample.arm(), "planner", "recorder", .reliable = true, .depth = 64)                               \
  TOPIC(PlannedMotion, sample.arm(), "planner", "view recorder", .reliable = true)
// clang-format on

}  // namespace hecaton::bus

#define HECATON_DECLARE(Type, ...) class Type;
namespace hecaton::msg {
HECATON_TOPICS(HECATON_DECLARE)
}  // namespace hecaton::msg
#undef HECATON_DECLARE

namespace hecaton::bus {

/// The row of a message type T. A specialisation has two static members, kInfo and key_of(). Each type has a field
/// `schema`, an unsigned long with a default above 0: readers drop samples of another value.
template <class T>
struct Topic;

#define HECATON_ROW(Type, key, writers, readers, ...)                                              \
  template <>                                                                                      \
  struct Topic<msg::Type> {                                                                        \
    static constexpr TopicInfo kInfo{#Type, "hecaton/" #Type, writers, readers, Qos{__VA_ARGS__}}; \
    static std::string key_of(const msg::Type& sample);                                            \
  };
HECATON_TOPICS(HECATON_ROW)
#undef HECATON_ROW

#define HECATON_ENTRY(Type, ...) Topic<msg::Type>::kInfo,
inline constexpr std::array kTopics{HECATON_TOPICS(HECATON_ENTRY)};
#undef HECATON_ENTRY

/// The sample's key as text; "" for a topic without a key.
template <class T>
[[nodiscard]] std::string key_of(const T& sample) {
  return Topic<T>::key_of(sample);
}

}  // namespace hecaton::bus
