#pragma once
/// Helpers of the model's tests: small URDFs, random joints.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "planner/model/robot_model.hpp"
#include "planner/model/urdf_loader.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {

inline const std::string kPuma = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";
inline const std::string kPuma5 = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560_5dof.urdf";

/// A link with one collision sphere.
inline std::string ball_link(const std::string& name, const std::string& origin = "0 0 0") {
  return "<link name=\"" + name + "\"><collision><origin xyz=\"" + origin +
         "\"/><geometry><sphere radius=\"0.05\"/></geometry></collision></link>";
}

inline std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& inside = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/>" + inside + "</joint>";
}

inline const std::string kLimit = R"(<limit lower="-2" upper="2" effort="1" velocity="1.5"/>)";

inline std::string robot(const std::string& inside) {
  return "<robot name=\"r\">" + inside + "</robot>";
}

/// Writes the URDF and loads it.
inline std::shared_ptr<const planner::RobotModel> load_text(const std::string& urdf,
                                                            const planner::UrdfOptions& options = {}) {
  const TemporaryFolder folder;
  return planner::load_urdf(folder.write("r.urdf", urdf), options);
}

/// The sentence with which loading fails; empty when it does not.
inline std::string error_of(const std::string& urdf, const planner::UrdfOptions& options = {}) {
  try {
    load_text(urdf, options);
  } catch (const planner::ModelError& error) {
    return error.what();
  }
  return "";
}

inline planner::JointVector random_joints(const planner::JointLimits& limits, std::mt19937_64& random) {
  planner::JointVector q(limits.lower.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    q[j] =
        std::uniform_real_distribution<double>(std::max(limits.lower[j], -4.0), std::min(limits.upper[j], 4.0))(random);
  }
  return q;
}

/// Names the cases of a parameterised test by their own `name`.
struct CaseName {
  template <typename Param>
  std::string operator()(const testing::TestParamInfo<Param>& one) const {
    return one.param.name;
  }
};

inline testing::AssertionResult has_note(const planner::RobotModel& model, const std::string& part) {
  std::string all;
  for (const auto* notes : {&model.notes, &model.details}) {
    for (const std::string& note : *notes) {
      if (note.find(part) != std::string::npos) return testing::AssertionSuccess();
      all += "\n  " + note;
    }
  }
  return testing::AssertionFailure() << "no note contains '" << part << "'; there are:" << all;
}

}  // namespace hecaton::test
