#include "services/config/method_rules.hpp"

#include "planner/cspace/arm_planes.hpp"

namespace hecaton::config {

std::string complain_about_method(const planner::PlannedArm& planned) {
  if (!planned.parameters.by_cspace()) return {};
  const bool senses = planned.parameters.method == planner::Method::kSensedCspace;
  const std::string method = senses ? "sensed_cspace" : "known_cspace";
  const std::string objection = planner::cspace::ArmPlanes::why_not(*planned.arm.model);
  if (!objection.empty()) {
    return method +
           " must be given to an arm of two links that turn in a plane, which a joint may turn about the base; "
           "of robot " +
           planned.arm.model->name + ", " + objection;
  }
  if (senses && planned.sensors.empty()) return method + " must be given to an arm with sensors";
  return {};
}

}  // namespace hecaton::config
