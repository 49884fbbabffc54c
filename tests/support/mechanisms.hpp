#pragma once
/// Robots whose chain contains followers, each with an equivalent robot whose links all have joints of their own.

#include <string>
#include <vector>

#include "tests/unit/planner/model/support.hpp"

namespace hecaton::test {

/// A moving link of a mechanism: the joint that carries it. It follows joint `joint` at multiplier · q + offset.
struct MechanismJoint {
  std::string name;
  std::string type;
  std::string origin;
  std::string axis;
  int joint = 0;  ///< index of the independent joint
  bool follows = false;
  double multiplier = 1.0;
  double offset = 0.0;
};

struct Mechanism {
  std::string name;
  std::vector<std::string> joint_names;
  std::vector<MechanismJoint> moving;  ///< base to tip

  /// `independent`: all moving joints are free, without narrow limits.
  [[nodiscard]] std::shared_ptr<const planner::RobotModel> load(bool independent) const {
    const std::string box =
        R"(<collision><origin xyz="0.1 0.02 -0.03"/><geometry><box size="0.2 0.08 0.1"/></geometry>)";
    std::string urdf = ball_link("base");
    std::string parent = "base";
    for (const MechanismJoint& one : moving) {
      const std::string link = "link_" + one.name;
      const std::string limit = independent   ? R"(<limit lower="-5" upper="5" effort="1" velocity="9"/>)"
                                : one.follows ? R"(<limit lower="0" upper="0" effort="0" velocity="0"/>)"
                                              : R"(<limit lower="-1.2" upper="1" effort="1" velocity="1.5"/>)";
      const std::string mimic = "<mimic joint=\"" + joint_names[one.joint] + "\" multiplier=\"" +
                                std::to_string(one.multiplier) + "\" offset=\"" + std::to_string(one.offset) + "\"/>";
      urdf += "<link name=\"" + link + "\">" + box + "</collision></link>";
      urdf += test::joint(one.name, one.type, parent, link,
                          "<origin xyz=\"" + one.origin + "\" rpy=\"0.1 -0.2 0.3\"/><axis xyz=\"" + one.axis + "\"/>" +
                              limit + (independent || !one.follows ? "" : mimic));
      parent = link;
    }
    urdf += "<link name=\"tip\"/>" + test::joint("flange", "fixed", parent, "tip", R"(<origin xyz="0.1 0 0.05"/>)");
    return load_text(robot(urdf));
  }

  /// Positions of all moving joints.
  [[nodiscard]] planner::JointVector positions(const planner::JointVector& q) const {
    planner::JointVector all(static_cast<Eigen::Index>(moving.size()));
    for (std::size_t i = 0; i < moving.size(); ++i) {
      all[static_cast<Eigen::Index>(i)] = moving[i].multiplier * q[moving[i].joint] + moving[i].offset;
    }
    return all;
  }

  /// ∂ positions / ∂ q
  [[nodiscard]] Eigen::MatrixXd gains() const {
    Eigen::MatrixXd gains =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(moving.size()), static_cast<Eigen::Index>(joint_names.size()));
    for (std::size_t i = 0; i < moving.size(); ++i) {
      gains(static_cast<Eigen::Index>(i), moving[i].joint) = moving[i].multiplier;
    }
    return gains;
  }
};

/// A palletiser with parallelograms, a telescope whose first stage follows the second, and gears of every kind.
inline std::vector<Mechanism> mechanisms() {
  return {{"Palletiser",
           {"turn", "upper", "fore", "wrist"},
           {{"turn", "revolute", "0 0 0.3", "0 0 1", 0},
            {"upper", "revolute", "0.1 0 0.2", "0 1 0", 1},
            {"fore", "revolute", "0.1 0 0.6", "0 1 0", 2},
            {"rod", "revolute", "0.6 0 0", "0 1 0", 1, true, -1.0},
            {"level", "revolute", "0 0 0", "0 1 0", 2, true, -1.0, 0.25},
            {"wrist", "continuous", "0.1 0 -0.1", "0 0 1", 3}}},
          {"Telescope",
           {"turn", "outer"},
           {{"inner", "prismatic", "0.1 0.2 0.3", "1 0 0", 1, true, 0.5, 0.1},
            {"turn", "revolute", "0.1 0 0.2", "0 0.6 0.8", 0},
            {"outer", "prismatic", "0.3 0 0", "1 1 0", 1}}},
          {"Gears",
           {"slide", "crank"},
           {{"slide", "prismatic", "0.1 0 0.2", "0 0.6 0.8", 0},
            {"pinion", "revolute", "0.2 0 0.1", "0 1 0", 0, true, 3.0, -0.4},
            {"crank", "revolute", "0.1 0.1 0.2", "1 0 0", 1},
            {"double", "revolute", "0.2 0 0", "0 1 0", 1, true, -2.0},
            {"screw", "prismatic", "0 0 0.1", "0 0 1", 1, true, 0.2}}}};
}

}  // namespace hecaton::test
