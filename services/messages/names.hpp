#pragma once
/// Words for the enumerations of messages, the same in logs, on the command line and in JSON. They are in the namespace
/// of the messages, so that `text(status.state())` finds them from everywhere. Unknown values give "unknown".

#include <string>

#include <idl/supervisor.h>

namespace hecaton::msg {

[[nodiscard]] std::string text(Mode mode);          ///< "run", "hold", "stop"
[[nodiscard]] std::string text(ArmMode mode);       ///< "starting", "running", "braking", "stopped", "failed"
[[nodiscard]] std::string text(DeviceOrder order);  ///< "on", "off", "unlock"
[[nodiscard]] std::string text(GoalState state);    ///< "accepted", …, "timed_out"
[[nodiscard]] std::string text(NodeKind kind);      ///< "planner", …
[[nodiscard]] std::string text(NodeState state);    ///< "starting", …
[[nodiscard]] std::string text(Severity severity);  ///< "info", …
[[nodiscard]] std::string text(ContactKind kind);   ///< "arm-arm", …
[[nodiscard]] std::string text(MotionKind kind);    ///< "static", "waypoints", …
/// "box 0.4 × 0.4 × 0.2 m" (full sizes)
[[nodiscard]] std::string text(const PlacedShape& shape);

}  // namespace hecaton::msg
