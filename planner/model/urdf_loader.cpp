#include "planner/model/urdf_loader.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include "planner/model/capsules.hpp"
#include "planner/model/collision_filter.hpp"
#include "planner/model/fixed_links.hpp"
#include "planner/model/followers.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/mesh_shape.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/srdf.hpp"
#include "planner/model/urdf_chain.hpp"
#include "planner/model/urdf_document.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

/// Captures what urdfdom prints to stderr. Its channel is global to the process: one capture at a time, under a lock.
class UrdfdomMessages : console_bridge::OutputHandler {
 public:
  UrdfdomMessages() : lock_(mutex()), previous_(console_bridge::getOutputHandler()) {
    console_bridge::useOutputHandler(this);
  }
  ~UrdfdomMessages() override { console_bridge::useOutputHandler(previous_); }
  UrdfdomMessages(const UrdfdomMessages&) = delete;
  UrdfdomMessages& operator=(const UrdfdomMessages&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/, int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) text_ += (text_.empty() ? "" : ", ") + text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  static std::mutex& mutex() {
    static std::mutex shared;
    return shared;
  }
  std::unique_lock<std::mutex> lock_;
  console_bridge::OutputHandler* previous_;
  std::string text_;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& path, const std::string& text) {
  const UrdfdomMessages messages;
  urdf::ModelInterfaceSharedPtr model;
  std::string reason;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (model == nullptr || model->getRoot() == nullptr) {
    throw ModelError(path + ": urdfdom refuses this URDF: " + in_quotes(messages.text() + reason, kLongestReason));
  }
  return model;
}

std::string number_text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

Pose to_pose(const urdf::Pose& pose) {
  Pose result = Pose::Identity();
  result.translation() << pose.position.x, pose.position.y, pose.position.z;
  const urdf::Rotation& r = pose.rotation;
  result.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
  return result;
}

JointType to_joint_type(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
      return JointType::kRevolute;
    case urdf::Joint::CONTINUOUS:
      return JointType::kContinuous;
    case urdf::Joint::PRISMATIC:
      return JointType::kPrismatic;
    default:
      return JointType::kFixed;
  }
}

TreeLink to_tree_link(const urdf::Link& link, int parent) {
  TreeLink entry;
  entry.link.name = link.name;
  entry.link.parent = parent;
  entry.has_collision = !link.collision_array.empty();
  if (parent < 0) return entry;
  const urdf::Joint& joint = *link.parent_joint;
  entry.link.joint_type = to_joint_type(joint);
  entry.link.joint_name = joint.name;
  entry.link.X_PJ = to_pose(joint.parent_to_joint_origin_transform);
  if (entry.link.joint_type == JointType::kFixed) return entry;
  entry.link.axis = Eigen::Vector3d(joint.axis.x, joint.axis.y, joint.axis.z).normalized();
  if (joint.limits != nullptr) {
    entry.lower = joint.limits->lower;
    entry.upper = joint.limits->upper;
    entry.velocity = joint.limits->velocity;
    entry.effort = joint.limits->effort;
  }
  if (joint.mimic != nullptr) {
    entry.mimic = TreeLink::Mimic{joint.mimic->joint_name, joint.mimic->multiplier, joint.mimic->offset};
  }
  return entry;
}

/// Parents before children, and the urdfdom link of each entry with its collision elements.
using Tree = std::pair<std::vector<TreeLink>, std::vector<urdf::LinkConstSharedPtr>>;

Tree flatten(const urdf::ModelInterface& model) {
  Tree tree;
  auto& [entries, links] = tree;
  std::vector<std::pair<urdf::LinkConstSharedPtr, int>> waiting{{model.getRoot(), -1}};
  while (!waiting.empty()) {
    const auto [link, parent] = waiting.back();
    waiting.pop_back();
    const int index = static_cast<int>(entries.size());
    entries.push_back(to_tree_link(*link, parent));
    links.push_back(link);
    for (auto child = link->child_links.rbegin(); child != link->child_links.rend(); ++child) {
      waiting.emplace_back(*child, index);
    }
  }
  return tree;
}

class ModelBuilder {
 public:
  ModelBuilder(const std::string& path, const UrdfOptions& options, SourceFiles& sources)
      : path_(path), options_(options), sources_(sources) {}

  std::shared_ptr<const RobotModel> build() {
    const UrdfDocument document = read_urdf_document(
        path_, sources_,
        {options_.xacro_arguments, options_.packages, options_.names.xacro_arguments, options_.names.packages});
    model_->notes = document.notes;
    const urdf::ModelInterfaceSharedPtr urdf = parse(path_, document.text);
    auto [tree, urdf_links] = flatten(*urdf);
    fix_locked_joints(tree);
    model_->name = urdf->getName();
    ChainRequest request{path_,
                         options_.base_link,
                         options_.tool_link,
                         options_.held_joints,
                         options_.moving_joints,
                         options_.names.tool_link,
                         options_.names.held_joints};
    if (request.tool_link.empty()) request.tool_link = tool_of_srdf(tree, request.base_link);
    model_->tool_link = find_tool_link(tree, request, model_->notes);
    model_->X_LT = options_.X_LT;
    refuse_faulty_joints(tree, document.faulty_joints);
    leave_out_other_arms(tree, urdf_links, request);
    const Chain chain = number_chain(tree, model_->tool_link, request, model_->notes);
    model_->held = chain.held;
    const std::string& option = options_.names.allow_bare_links;
    check_bare_links(tree, options_.allow_bare_links, option.empty() ? "" : ", or set " + option, path_, model_->notes);
    set_limits(tree, chain);
    set_masses(tree, chain, document.masses);
    for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
      model_->links.push_back(tree[i].link);
      model_->has_followers = model_->has_followers || tree[i].link.follows;
      add_geometry(i, *urdf_links[i]);
    }
    limit_endless_joints();
    note_unlikely_sizes();
    note_unlikely_angles();
    note_tool_on_last_axis();
    model_->self_pairs = pairs_of_separate_bodies(*model_);
    enclose_followers(chain.followers, chain.ranges, path_, *model_, chain.range_names);
    if (!options_.srdf_path.empty()) apply_srdf(options_.srdf_path, left_out_, *model_, sources_);
    merge_fixed_links(kMaxLinks, *model_);
    return model_;
  }

 private:
  /// A joint whose limits are equal does not move.
  void fix_locked_joints(std::vector<TreeLink>& tree) {
    for (TreeLink& entry : tree) {
      Link& link = entry.link;
      const bool has_range = link.joint_type == JointType::kRevolute || link.joint_type == JointType::kPrismatic;
      if (!has_range || entry.mimic || entry.lower != entry.upper) continue;
      if (link.joint_type == JointType::kPrismatic) {
        link.X_PJ.translate(entry.lower * link.axis);
      } else {
        link.X_PJ.rotate(Eigen::AngleAxisd(entry.lower, link.axis));
      }
      link.joint_type = JointType::kFixed;
      model_->notes.push_back("joint " + in_quotes(link.joint_name) + " is fixed: both its limits are " +
                              std::to_string(entry.lower));
    }
  }

  /// The tool link that the SRDF names, if it names one of the tree's below the base.
  std::string tool_of_srdf(const std::vector<TreeLink>& tree, const std::string& base_link) {
    if (options_.srdf_path.empty()) return {};
    std::string link = srdf_tool_link(options_.srdf_path, tree, base_link, sources_);
    if (index_of_link(tree, link) < 0) return {};
    model_->notes.push_back("link " + in_quotes(link) + " is taken as the tool, because the SRDF names it");
    return link;
  }

  /// Faulty joints are an error on the way to the tool, elsewhere a note.
  void refuse_faulty_joints(const std::vector<TreeLink>& tree, const std::map<std::string, std::string>& faulty) {
    for (int i = model_->tool_link; i > 0; i = tree[i].link.parent) {
      const auto fault = faulty.find(tree[i].link.joint_name);
      if (fault != faulty.end()) throw ModelError(fault->second);
    }
    for (const auto& [name, sentence] : faulty) {
      model_->notes.push_back(sentence.substr(path_.size() + 2) +
                              "; it is outside the chain to the tool and held at 0");
    }
  }

  /// Removes what joints of the robot's other arms carry: from the first moving joint of each that does not move this
  /// arm's tool. The request loses positions of joints there, which a note tells.
  void leave_out_other_arms(std::vector<TreeLink>& tree, std::vector<urdf::LinkConstSharedPtr>& urdf_links,
                            ChainRequest& request) {
    std::vector<bool> on_way(tree.size(), false);
    for (int i = model_->tool_link; i >= 0; i = tree[i].link.parent) on_way[i] = true;
    std::vector<bool> removed(tree.size(), false);
    for (const std::string& tool : options_.other_arms) {
      int first = -1;  // nearest to the root
      for (int i = index_of_link(tree, tool); i > 0 && !on_way[i]; i = tree[i].link.parent) {
        if (tree[i].link.joint_type != JointType::kFixed) first = i;
      }
      if (first >= 0) removed[first] = true;
    }
    std::vector<int> place(tree.size(), -1);
    std::vector<TreeLink> kept;
    std::vector<urdf::LinkConstSharedPtr> kept_links;
    std::string without_effect;  // joints
    for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
      const int parent = tree[i].link.parent;
      if (parent >= 0 && removed[parent]) removed[i] = true;
      if (removed[i]) {
        left_out_.insert(tree[i].link.name);
        const std::string& joint = tree[i].link.joint_name;
        if (request.held.erase(joint) + request.ranges.erase(joint) > 0)
          without_effect += (without_effect.empty() ? "" : ", ") + in_quotes(joint);
        continue;
      }
      place[i] = static_cast<int>(kept.size());
      kept.push_back(tree[i]);
      if (parent >= 0) kept.back().link.parent = place[parent];
      kept_links.push_back(urdf_links[i]);
    }
    if (!without_effect.empty() && !options_.joints_of_all_arms) {
      const std::string& option = options_.names.held_joints;
      model_->notes.push_back((option.empty() ? "" : option + ": ") + "positions of " + without_effect +
                              " have no effect here, because these joints belong to another arm of the robot; give "
                              "them at that arm");
    }
    model_->tool_link = place[model_->tool_link];
    tree = std::move(kept);
    urdf_links = std::move(kept_links);
  }

  void set_limits(const std::vector<TreeLink>& tree, const Chain& chain) {
    JointLimits& limits = model_->limits;
    const auto n = static_cast<Eigen::Index>(chain.joints.size());
    limits.lower.resize(n);
    limits.upper.resize(n);
    limits.velocity.resize(n);
    std::vector<std::string> without_velocity;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (int j = 0; j < n; ++j) {
      const auto [link, type] = chain.joints[j];
      const TreeLink& entry = tree[link];
      const bool endless = type == JointType::kContinuous;
      limits.lower[j] = endless ? -kInfinity : entry.lower;
      limits.upper[j] = endless ? kInfinity : entry.upper;
      if (endless && (entry.lower != 0.0 || entry.upper != 0.0)) note_ignored_range(entry);
      limits.velocity[j] = velocity_limit(entry);
      if (!(entry.velocity > 0.0)) without_velocity.push_back(in_quotes(entry.link.joint_name));
      model_->joint_names.push_back(entry.link.joint_name);
      if (entry.link.joint < 0) model_->beside[entry.link.joint_name] = type;
    }
    for (const TreeLink& entry : tree) {
      if (entry.link.follows) keep_limits_of_follower(entry);
    }
    limits.acceleration = options_.default_acceleration ? JointVector::Constant(n, *options_.default_acceleration)
                                                        : assumed_acceleration(limits.velocity);
    note_default_velocity(without_velocity);
  }

  /// Each link counts with the body that a joint of the chain moves. Links beside the chain count where they are held.
  void set_masses(const std::vector<TreeLink>& tree, const Chain& chain, const std::vector<BodyMass>& masses) {
    auto result = std::make_shared<MassModel>();
    result->effort.resize(static_cast<Eigen::Index>(chain.joints.size()));
    for (std::size_t j = 0; j < chain.joints.size(); ++j) result->effort[j] = tree[chain.joints[j].link].effort;
    std::map<int, std::size_t> bodies;  // by the link that moves them
    for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
      Pose X_ML = Pose::Identity();  // M: the frame of the link that moves
      int moved = i;
      while (moved >= 0 && tree[moved].link.joint < 0) {
        X_ML = tree[moved].link.X_PJ * X_ML;
        moved = tree[moved].link.parent;
      }
      if (moved < 0) continue;
      const auto [body, is_new] = bodies.try_emplace(moved, result->bodies.size());
      if (is_new) result->bodies.emplace_back().link = tree[moved].link.name;
      const std::string& name = tree[i].link.name;
      const auto mass =
          std::find_if(masses.begin(), masses.end(), [&](const BodyMass& link) { return link.link == name; });
      if (mass != masses.end()) result->bodies[body->second].add(*mass, X_ML);
    }
    model_->masses = std::move(result);
  }

  void note_default_velocity(const std::vector<std::string>& joints) {
    if (joints.empty()) return;
    std::string names;
    for (const std::string& joint : joints) names += (names.empty() ? "" : ", ") + joint;
    model_->notes.push_back((joints.size() == 1 ? "joint " + names + " has" : "joints " + names + " have") +
                            " no velocity limit; the default " + number_text(*options_.default_velocity) + " is used");
  }

  struct Range {
    double lower, upper;  // [rad | m]
    [[nodiscard]] Range within(double low, double high) const { return {std::max(lower, low), std::min(upper, high)}; }
    [[nodiscard]] bool is_empty() const { return !(lower < upper); }
  };

  /// The range of the joint that a link follows, with which the link stays from `lower` to `upper`.
  [[nodiscard]] static Range range_of_leader(const Link& link, double lower, double upper) {
    const double one = (lower - link.offset) / link.multiplier;
    const double two = (upper - link.offset) / link.multiplier;
    return {std::min(one, two), std::max(one, two)};
  }

  /// Narrows the limits of the joint that a link follows to those with which the link keeps its own.
  void keep_limits_of_follower(const TreeLink& entry) {
    const Link& link = entry.link;
    JointLimits& limits = model_->limits;
    double& lower = limits.lower[link.joint];
    double& upper = limits.upper[link.joint];
    if (entry.velocity > 0.0) {
      double& velocity = limits.velocity[link.joint];
      velocity = std::min(velocity, entry.velocity / std::abs(link.multiplier));
    }
    if (link.joint_type == JointType::kContinuous || entry.lower == entry.upper) return;
    if (is_whole_turn(entry, upper - lower)) return;
    const std::string& name = model_->joint_names[link.joint];
    Range narrowed = range_of_leader(link, entry.lower, entry.upper).within(lower, upper);
    // Files of grippers often give both fingers the same limits although one turns the other way.
    if (narrowed.is_empty() && link.multiplier < 0.0) {
      narrowed = range_of_leader(link, -entry.upper, -entry.lower).within(lower, upper);
      if (!narrowed.is_empty()) {
        model_->notes.push_back("joint " + in_quotes(link.joint_name) + " follows joint " + in_quotes(name) +
                                " in the opposite direction; its limits, " + number_text(entry.lower) + " to " +
                                number_text(entry.upper) + ", are used with the opposite sign");
      }
    }
    if (narrowed.is_empty()) {
      throw ModelError(path_ + ": joint " + in_quotes(link.joint_name) + " follows joint " + in_quotes(name) +
                       ", and its limits, " + number_text(entry.lower) + " to " + number_text(entry.upper) +
                       ", leave no range of that joint; correct them, or remove them and keep those of " +
                       in_quotes(name));
    }
    const bool narrows = narrowed.lower > lower + kLimitRounding || narrowed.upper < upper - kLimitRounding;
    if (!narrows) return;
    lower = narrowed.lower;
    upper = narrowed.upper;
    model_->notes.push_back("joint " + in_quotes(name) + " is narrowed to " + number_text(lower) + " … " +
                            number_text(upper) + " by the limits of joint " + in_quotes(link.joint_name) +
                            ", which follows it");
  }

  /// True if the range of a link that turns and follows is a whole turn, and the link never turns farther: URDF asks
  /// for a range, and a whole turn is what files give when there is none.
  [[nodiscard]] static bool is_whole_turn(const TreeLink& entry, double range_of_joint) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    constexpr double kRounded = 0.01;  // [rad]
    return entry.link.joint_type == JointType::kRevolute && std::abs(entry.upper - entry.lower - kTurn) < kRounded &&
           std::abs(entry.link.multiplier) * range_of_joint <= kTurn + kRounded;
  }

  /// A whole turn of a joint must leave the arm as it is if the joint has no limits.
  void limit_endless_joints() {
    JointLimits& limits = model_->limits;
    for (int j = 0; j < model_->joints(); ++j) {
      if (std::isfinite(limits.lower[j]) || repeats_after_turn(*model_, j)) continue;
      limits.lower[j] = -std::numbers::pi;
      limits.upper[j] = std::numbers::pi;
      model_->notes.push_back("joint " + in_quotes(model_->joint_names[j]) +
                              " has no limits, but its followers are elsewhere after a whole turn; it moves within "
                              "half a turn from 0");
    }
  }

  void note_ignored_range(const TreeLink& entry) {
    model_->notes.push_back("joint " + in_quotes(entry.link.joint_name) +
                            " is continuous, therefore its limits lower = " + number_text(entry.lower) +
                            " and upper = " + number_text(entry.upper) +
                            " are ignored; type=\"revolute\" in the URDF makes them count");
  }

  /// A factor of 1000 between metres and millimetres, forgotten or applied twice.
  void note_unlikely_sizes() {
    constexpr double kLargest = 10.0;   // across [m]
    constexpr double kSmallest = 0.01;  // across, of the largest shape [m]
    double largest = 0.0;
    std::string links;
    for (const LinkGeometry& geometry : model_->geometry) {
      const double across = 2.0 * world::bounding_sphere(geometry.shape).radius;
      largest = std::max(largest, across);
      if (across <= kLargest) continue;
      const std::string size = in_quotes(model_->links[geometry.link].name) + " (" + number_text(across) + " m)";
      if (links.find(size) == std::string::npos) links += (links.empty() ? "" : ", ") + size;
    }
    if (!links.empty()) {
      model_->notes.push_back("unlikely size: the collision geometry of " + links + " is more than " +
                              number_text(kLargest) +
                              " m across; a mesh in millimetres needs scale=\"0.001 0.001 0.001\" in the URDF");
    } else if (!model_->geometry.empty() && largest < kSmallest) {
      model_->notes.push_back("unlikely size: no collision shape is more than " + number_text(1e3 * largest) +
                              " mm across; the URDF must give metres, and a mesh may have a wrong scale");
    }
  }

  /// Limits in degrees: no arm turns that often, or that fast.
  void note_unlikely_angles() {
    constexpr double kMost = 15.0 * std::numbers::pi;  // from 0 [rad]; 90°, taken as radians, are more
    constexpr double kFastest = 60.0;                  // [rad/s]
    const JointLimits& limits = model_->limits;
    std::string joints;
    for (int j = 0; j < model_->joints(); ++j) {
      if (joint_type(*model_, j) == JointType::kPrismatic) continue;
      const double lower = limits.lower[j];
      const double upper = limits.upper[j];
      const bool bounded = std::isfinite(lower);
      const bool far = bounded && std::max(std::abs(lower), std::abs(upper)) > kMost;
      if (!far && limits.velocity[j] <= kFastest) continue;
      joints += (joints.empty() ? "" : ", ") + in_quotes(model_->joint_names[j]) + " (" +
                (bounded ? number_text(lower) + " to " + number_text(upper) + " rad, " : "") +
                number_text(limits.velocity[j]) + " rad/s)";
    }
    if (joints.empty()) return;
    model_->notes.push_back("unlikely limits: " + joints + "; a URDF has radians, not degrees");
  }

  /// Few joints, of which the last one only turns the tool where it is: the URDF has no link at the arm's tip.
  void note_tool_on_last_axis() {
    constexpr int kFewJoints = 3;
    constexpr double kNear = 1e-3;  // [m]
    const int moved = moved_link(*model_, model_->tool_link);
    if (moved < 0 || model_->joints() > kFewJoints || model_->links[moved].joint_type == JointType::kPrismatic) return;
    Pose X_MT = model_->X_LT;  // M: the moved link's frame
    for (int i = model_->tool_link; i != moved; i = model_->links[i].parent) X_MT = model_->links[i].X_PJ * X_MT;
    if (X_MT.translation().cross(model_->links[moved].axis).norm() > kNear) return;
    model_->notes.push_back("joint " + in_quotes(model_->links[moved].joint_name) +
                            " only turns the tool about its own origin; if the arm's tip is elsewhere, give its place "
                            "in the frame of link " +
                            in_quotes(model_->links[model_->tool_link].name) + " with the cell file's key 'tool'");
  }

  double velocity_limit(const TreeLink& entry) {
    if (entry.velocity > 0.0) return entry.velocity;
    if (!options_.default_velocity) {
      const std::string& option = options_.names.default_velocity;
      throw ModelError(path_ + ": joint " + in_quotes(entry.link.joint_name) +
                       " has no velocity limit above 0; correct it" + (option.empty() ? "" : ", or give " + option));
    }
    return *options_.default_velocity;
  }

  void add_geometry(int index, const urdf::Link& link) {
    const std::string where = path_ + ": link " + in_quotes(link.name);
    std::vector<world::PlacedShape> primitives;
    for (const urdf::CollisionSharedPtr& collision : link.collision_array) {
      const urdf::Geometry& geometry = *collision->geometry;
      const Pose X_LC = to_pose(collision->origin);
      if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
        primitives.push_back({world::Box{0.5 * Eigen::Vector3d(box->dim.x, box->dim.y, box->dim.z)}, X_LC});
      } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
        primitives.push_back({world::Cylinder{cylinder->radius, 0.5 * cylinder->length}, X_LC});
      } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
        primitives.push_back({world::Sphere{sphere->radius}, X_LC});
      } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
        add_mesh(index, *mesh, X_LC, where);
      }
    }
    for (const world::PlacedShape& placed : merge_capsules(primitives)) {
      model_->geometry.push_back({index, placed.shape, placed.X_BS, 0.0, link_capsule(placed.shape)});
    }
  }

  void add_mesh(int index, const urdf::Mesh& mesh, const Pose& X_LC, const std::string& where) {
    const std::string file =
        resolve_resource(mesh.filename, path_, options_.packages, where, sources_, options_.names.packages);
    const Eigen::Vector3d scale(mesh.scale.x, mesh.scale.y, mesh.scale.z);
    MeshShape shape = mesh_shape(file, scale, options_.meshes, where, sources_);
    shape.geometry.link = index;
    shape.geometry.capsule = link_capsule(shape.geometry.shape);
    shape.geometry.X_LS = X_LC * shape.geometry.X_LS;
    model_->geometry.push_back(std::move(shape.geometry));
    if (!shape.note.empty()) model_->details.push_back(std::move(shape.note));
  }

  const std::string& path_;
  const UrdfOptions& options_;
  SourceFiles& sources_;
  std::set<std::string> left_out_;  ///< links of the robot's other arms
  std::shared_ptr<RobotModel> model_ = std::make_shared<RobotModel>();
};

void check_options(const UrdfOptions& options) {
  const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  if (options.default_acceleration && !positive(*options.default_acceleration)) {
    throw ModelError("default acceleration = " + std::to_string(*options.default_acceleration) +
                     " must be finite and above 0");
  }
  if (options.default_velocity && !positive(*options.default_velocity)) {
    const std::string& name = options.names.default_velocity;
    throw ModelError((name.empty() ? "default velocity" : name) + " = " + std::to_string(*options.default_velocity) +
                     " must be finite and above 0");
  }
}

}  // namespace

std::shared_ptr<const RobotModel> load_urdf(const std::string& urdf_path, const UrdfOptions& options) {
  check_options(options);
  SourceFiles in_place;
  return ModelBuilder(urdf_path, options, options.sources != nullptr ? *options.sources : in_place).build();
}

const char* urdf_type(JointType type) {
  switch (type) {
    case JointType::kRevolute:
      return "revolute";
    case JointType::kContinuous:
      return "continuous";
    case JointType::kPrismatic:
      return "prismatic";
    case JointType::kFixed:
      break;
  }
  return "fixed";
}

}  // namespace hecaton::planner
