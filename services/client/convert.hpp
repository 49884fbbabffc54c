#pragma once
/// Conversions between messages and the public values of <hecaton/types.hpp>.

#include <hecaton/client.hpp>
#include <idl/cause.h>
#include <idl/supervisor.h>
#include <idl/world.h>

namespace hecaton::client {

[[nodiscard]] Cause to_public(const msg::Cause& cause);
/// Throws InvalidArgument for wrong numbers of values and numbers that are not finite.
[[nodiscard]] msg::TimedTrajectory to_message(const Trajectory& trajectory);
[[nodiscard]] Progress to_public(const msg::GoalStatus& status, Seconds age = {});
[[nodiscard]] Fault to_public(const msg::Fault& fault);
[[nodiscard]] ToolState to_public(const msg::ToolState& state, Seconds age);
[[nodiscard]] ArmState to_public(const msg::ArmState& state, Seconds age);
[[nodiscard]] CellStatus to_public(const msg::CellStatus& status);
[[nodiscard]] Pose to_public(const msg::Pose& pose);

[[nodiscard]] msg::Vec3 to_message(const Vector3& vector);
[[nodiscard]] msg::Pose to_message(const Pose& pose);
[[nodiscard]] msg::Obstacle to_message(const std::string& name, const Shape& shape, const Pose& pose,
                                       const Motion& motion);

}  // namespace hecaton::client
