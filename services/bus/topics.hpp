#pragma once
/// Every topic of a cell: one row of HECATON_TOPICS says its type, key, who writes, who reads, and its quality of
/// service. To add a topic: write its type in idl/, include the type's header in topics.cpp, add a row here.

#include <array>
#include <chrono>
#include <string>
#include <string_view>

namespace hecaton::bus {

using namespace std::chrono_literals;

/// How a topic is delivered. Unset durations mean "never".
struct Qos {
  bool reliable = false;                    ///< lost samples are sent again; otherwise the next one must do
  bool transient_local = false;             ///< who joins late gets what is there
  int depth = 1;                            ///< samples kept for each key
  bool exclusive = false;                   ///< of several writers of one key only the strongest living one is heard
  std::chrono::milliseconds deadline{0};    ///< for each key; whole milliseconds, as Fast DDS truncates the rest
  std::chrono::milliseconds lease{0};       ///< MANUAL_BY_TOPIC: only written samples show that a writer lives
  std::chrono::milliseconds heartbeat{20};  ///< of reliable writers while something is unacknowledged
  int instances = 512;                      ///< most keys at one time; the default of Fast DDS is 10
  int retained = 0;  ///< keys one writer leaves alive, the oldest is retired for a new one; 0: all
};

struct TopicInfo {
  std::string_view type;  ///< name of the type in hecaton::msg
  std::string_view name;  ///< on the wire
  std::string_view writers;
  std::string_view readers;
  Qos qos;
};

// Commands are not exclusive: the strongest writer that wakes up would own them again, and the driver would never learn
// of the others. Their terms decide, and the driver counts what it refuses. Replies are transient-local because the
// replying side may discover the asker's reader only after its request. They are unkeyed and everybody picks his own by
// client and request number.
// clang-format off: a table
#define HECATON_TOPICS(TOPIC)                                                                                          \
  /*    type               key                                   writers           readers                     QoS */  \
  TOPIC(ArmState, sample.arm(), "driver", "planner world supervisor", .deadline = 20ms)                                \
  TOPIC(ArmCommand, sample.arm(), "planner", "driver", .reliable = true, .lease = 20ms, .heartbeat = 5ms)              \
  TOPIC(ObstacleShapes, sample.name(), "world", "all", .reliable = true, .transient_local = true, .instances = 4096)   \
  TOPIC(ObstacleStates, "", "world", "all", .deadline = 50ms)                                                          \
  TOPIC(WorldEditRequest, "", "cli perception", "world", .reliable = true, .depth = 32)                                \
  TOPIC(WorldEditReply, "", "world", "cli perception", .reliable = true, .transient_local = true, .depth = 32)         \
  TOPIC(RangeScan, sample.sensor(), "world driver", "planner", .reliable = false)                                      \
  TOPIC(RefereeReport, "", "world", "supervisor cli", .reliable = true, .transient_local = true)                       \
  TOPIC(Goal, sample.arm() + "/" + sample.goal(), "cli clients", "planner", .reliable = true, .transient_local = true, \
        .instances = 4096, .retained = 256)                                                                            \
  TOPIC(GoalStatus, sample.arm() + "/" + sample.goal(), "planner", "planner cli clients supervisor", .reliable = true, \
        .transient_local = true, .instances = 4096, .retained = 8)                                                     \
  TOPIC(CoupledPlan, sample.arm(), "planner", "planner", .reliable = true, .transient_local = true)                    \
  TOPIC(CoupledPlanProgress, sample.arm(), "planner", "planner", .reliable = true, .transient_local = true,            \
        .heartbeat = 5ms)                                                                                              \
  TOPIC(Heartbeat, sample.node(), "all", "supervisor", .deadline = 20ms, .lease = 100ms)                               \
  TOPIC(Reachability, sample.host(), "agent", "agent supervisor")                                                      \
  TOPIC(ProcessEvent, sample.process(), "agent", "supervisor", .reliable = true, .transient_local = true, .depth = 8,  \
        .heartbeat = 5ms)                                                                                              \
  TOPIC(CellMode, "", "supervisor", "all", .reliable = true, .transient_local = true, .exclusive = true,               \
        .deadline = 100ms, .lease = 100ms, .heartbeat = 5ms)                                                           \
  TOPIC(Fault, sample.id(), "supervisor", "all", .reliable = true, .transient_local = true, .instances = 4096,         \
        .retained = 256)                                                                                               \
  TOPIC(SupervisorRequest, "", "cli supervisor", "supervisor", .reliable = true, .depth = 32)                          \
  TOPIC(SupervisorReply, "", "supervisor", "cli", .reliable = true, .transient_local = true, .depth = 4)
// clang-format on

}  // namespace hecaton::bus

#define HECATON_DECLARE(Type, ...) class Type;
namespace hecaton::msg {
HECATON_TOPICS(HECATON_DECLARE)
}  // namespace hecaton::msg
#undef HECATON_DECLARE

namespace hecaton::bus {

/// The row of a message type.
template <class T>
struct Topic;

#define HECATON_ROW(Type, key, writers, readers, ...)                                              \
  template <>                                                                                      \
  struct Topic<msg::Type> {                                                                        \
    static constexpr TopicInfo kInfo{#Type, "hecaton/" #Type, writers, readers, Qos{__VA_ARGS__}}; \
  };                                                                                               \
  /** Text of the key of a sample, "" for a topic without. */                                      \
  std::string key_of(const msg::Type& sample);
HECATON_TOPICS(HECATON_ROW)
#undef HECATON_ROW

#define HECATON_ENTRY(Type, ...) Topic<msg::Type>::kInfo,
inline constexpr std::array kTopics{HECATON_TOPICS(HECATON_ENTRY)};
#undef HECATON_ENTRY

}  // namespace hecaton::bus
