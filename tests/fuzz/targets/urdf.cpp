// A URDF as a robot model. The last byte chooses options.

#include "planner/model/kinematics.hpp"
#include "planner/model/urdf_loader.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace hecaton;

void require_sound(const planner::RobotModel& model) {
  fuzz::require(model.joints() >= 1 && model.limits.lower.size() == model.joints() &&
                    (model.limits.lower.array() < model.limits.upper.array()).all() &&
                    (model.limits.velocity.array() > 0.0).all(),
                "a model has joints, each with a range and a velocity");
  const planner::JointVector q = model.limits.lower.cwiseMax(-1.0).cwiseMin(model.limits.upper);
  planner::Kinematics kinematics;
  planner::forward_kinematics(model, planner::Pose::Identity(), q, kinematics);
  fuzz::require(kinematics.X_WT.matrix().allFinite(), "the tool of a model has a finite pose");
  for (const planner::LinkGeometry& geometry : model.geometry) {
    fuzz::require(geometry.X_LS.matrix().allFinite() && world::bounding_sphere(geometry.shape).radius > 0.0,
                  "a shape of a model has a finite pose and a size");
  }
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(urdf)(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.last_byte();
  planner::UrdfOptions options;
  options.allow_bare_links = (choice & 1U) != 0;
  if ((choice & 2U) != 0) options.default_velocity = 1.0;
  if ((choice & 4U) != 0) options.meshes = planner::MeshGeometry::kCapsule;
  if ((choice & 8U) != 0) options.default_acceleration.reset();
  if ((choice & 16U) != 0) options.base_link = "link1";
  static const std::string kMesh = fuzz::folder().write("mesh.obj",
                                                        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                                        "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const std::string path = fuzz::folder().write("robot.urdf", fuzz::text_of(input.rest()));
  try {
    require_sound(*planner::load_urdf(path, options));
  } catch (const planner::ModelError& error) {
    fuzz::require_sentence(error.what());
  }
  return 0;
}
