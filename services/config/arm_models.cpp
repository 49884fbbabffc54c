#include "services/config/arm_models.hpp"

#include <algorithm>
#include <array>

#include "planner/collision/model_filter.hpp"
#include "planner/model/kinematics.hpp"
#include "services/config/fields.hpp"

namespace hecaton::config {
namespace {

constexpr std::size_t kMostPackages = 256;
constexpr std::array<std::string_view, 2> kMeshNames = {"hull", "capsule"};
constexpr std::array<planner::MeshGeometry, 2> kMeshes = {planner::MeshGeometry::kConvexHull,
                                                          planner::MeshGeometry::kCapsule};

// For joints to which the URDF gives no velocity: the largest that the cell file mentions; the single joints are
// limited to their own afterwards.
std::optional<double> fallback_velocity(const ArmView& arm) {
  const Bounds bounds{0.0, 1e3, "rad/s (m/s for a prismatic joint)", true};
  const auto view = arm.find("limits", section::kArmLimits, "velocity");
  if (!view) return std::nullopt;
  if (!view->is_sequence()) return view->number(bounds);
  double largest = 0.0;
  for (const YamlView& item : view->items(1, planner::kMaxJoints, "numbers, one for each joint")) {
    largest = std::max(largest, item.number(bounds));
  }
  return largest;
}

planner::UrdfOptions read_options(const ArmView& arm) {
  planner::UrdfOptions options;
  options.sources = &arm.own.view().sources();
  if (const auto tool_link = arm.find("tool_link")) options.tool_link = tool_link->text();
  if (const auto tool = arm.find("tool")) options.X_LT = read_pose(*tool);
  if (const auto srdf = arm.find("srdf")) options.srdf_path = beside(srdf->file(), srdf->text());
  if (const auto packages = arm.find("packages")) {
    for (const auto& [name, folder] : packages->named_items(kMostPackages)) {
      options.packages[name] = beside(folder.file(), folder.text());
    }
  }
  if (const auto meshes = arm.find("meshes")) options.meshes = kMeshes[meshes->choice(kMeshNames)];
  options.default_velocity = fallback_velocity(arm);
  options.name_of_default_velocity = arm.own.view().path() + ".limits.velocity";
  return options;
}

bool same(const planner::UrdfOptions& a, const planner::UrdfOptions& b) {
  return a.tool_link == b.tool_link && a.X_LT.matrix() == b.X_LT.matrix() && a.srdf_path == b.srdf_path &&
         a.packages == b.packages && a.meshes == b.meshes && a.default_velocity == b.default_velocity;
}

std::shared_ptr<const planner::RobotModel> load_model(const ArmView& arm, const std::string& path,
                                                      const planner::UrdfOptions& options) {
  const YamlView urdf = arm.at("urdf");
  std::shared_ptr<const planner::RobotModel> model;
  try {
    model = planner::load_arm_model(path, options);
  } catch (const planner::ModelError& error) {
    // Messages begin with the file that they are about.
    const std::string sentence = error.what();
    const bool of_srdf = !options.srdf_path.empty() && sentence.starts_with(options.srdf_path + ":");
    (of_srdf ? arm.at("srdf") : urdf).fail_with(sentence);
  }
  if (model->joints() < 1 || model->joints() > planner::kMaxJoints) {
    urdf.fail("the URDF of an arm of 1 to " + std::to_string(planner::kMaxJoints) + " joints, but this one has " +
              std::to_string(model->joints()));
  }
  if (static_cast<int>(model->links.size()) > planner::kMaxLinks) {
    urdf.fail("the URDF of an arm of at most " + std::to_string(planner::kMaxLinks) + " links, but this one has " +
              std::to_string(model->links.size()));
  }
  return model;
}

}  // namespace

std::shared_ptr<const planner::RobotModel> ArmModels::load(const ArmView& arm) {
  const YamlView urdf = arm.at("urdf");
  const std::string path = beside(urdf.file(), urdf.text());
  const planner::UrdfOptions options = read_options(arm);
  const auto known = std::find_if(loaded_.begin(), loaded_.end(), [&](const Loaded& loaded) {
    return loaded.path == path && same(loaded.options, options);
  });
  if (known != loaded_.end()) return known->model;
  loaded_.push_back({path, options, load_model(arm, path, options)});
  return loaded_.back().model;
}

}  // namespace hecaton::config
