#include "tests/bench/problem_set.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include <tinyxml2.h>

#include "planner/collision/model_filter.hpp"
#include "planner/model/urdf_document.hpp"
#include "planner/model/xml_checks.hpp"
#include "services/config/moveit_files.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
namespace fs = std::filesystem;

/// A joint of the URDF, as far as it matters here.
struct TreeJoint {
  std::string name, parent, child;
  bool moves = false;  ///< by itself
  double lower = -HUGE_VAL;
  double upper = HUGE_VAL;
};

class JointTree {
 public:
  explicit JointTree(const std::string& urdf) {
    SourceFiles sources;
    tinyxml2::XMLDocument document;
    parse_xml(read_urdf_document(urdf, sources).text, urdf, "URDF", document);
    const tinyxml2::XMLElement* robot = document.RootElement();
    std::set<std::string> carried;
    for (const auto* e = robot->FirstChildElement("joint"); e != nullptr; e = e->NextSiblingElement("joint")) {
      TreeJoint joint;
      joint.name = text_attribute(*e, "name", urdf);
      joint.parent = text_attribute(*e->FirstChildElement("parent"), "link", urdf);
      joint.child = text_attribute(*e->FirstChildElement("child"), "link", urdf);
      joint.moves = text_attribute(*e, "type", urdf) != "fixed" && e->FirstChildElement("mimic") == nullptr;
      const auto* limit = e->FirstChildElement("limit");
      if (limit != nullptr && text_attribute(*e, "type", urdf) != "continuous") {
        joint.lower = limit->DoubleAttribute("lower");
        joint.upper = limit->DoubleAttribute("upper");
        if (joint.lower == joint.upper) joint.moves = false;
      }
      carried.insert(joint.child);
      joint_of_link_[joint.child] = joint;
      link_of_joint_[joint.name] = joint.child;
    }
    for (const auto* e = robot->FirstChildElement("link"); e != nullptr; e = e->NextSiblingElement("link")) {
      const std::string link = text_attribute(*e, "name", urdf);
      if (!carried.contains(link)) root_ = link;
    }
  }

  [[nodiscard]] const std::string& root() const { return root_; }
  [[nodiscard]] bool has_link(const std::string& link) const { return link == root_ || joint_of_link_.contains(link); }
  /// The joint of this name; null: none.
  [[nodiscard]] const TreeJoint* joint(const std::string& name) const {
    const auto link = link_of_joint_.find(name);
    return link == link_of_joint_.end() ? nullptr : &joint_of_link_.at(link->second);
  }
  /// The joints that move a link, from the root on.
  [[nodiscard]] std::vector<const TreeJoint*> chain(std::string link) const {
    std::vector<const TreeJoint*> joints;
    while (link != root_) {
      const TreeJoint& joint = joint_of_link_.at(link);
      if (joint.moves) joints.insert(joints.begin(), &joint);
      link = joint.parent;
    }
    return joints;
  }

 private:
  std::string root_;
  std::map<std::string, TreeJoint> joint_of_link_;  ///< by the link that it carries
  std::map<std::string, std::string> link_of_joint_;
};

struct Pair {
  fs::path scene, request;
};

std::vector<Pair> find_pairs(const std::string& folder) {
  if (!fs::is_directory(folder)) {
    throw std::runtime_error(folder + ": must be a folder with the unpacked problems of MotionBenchMaker");
  }
  std::vector<Pair> pairs;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("scene") || !name.ends_with(".yaml")) continue;
    Pair pair{entry.path(), entry.path().parent_path() / ("request" + name.substr(5))};
    if (!fs::exists(pair.request)) {
      throw std::runtime_error(pair.scene.string() + ": has no " + pair.request.filename().string() +
                               " beside it; unpack the problems again");
    }
    pairs.push_back(std::move(pair));
  }
  if (pairs.empty()) {
    throw std::runtime_error(folder +
                             ": has no file sceneNNNN.yaml at any depth; give the folder of unpacked problems");
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.scene < b.scene; });
  return pairs;
}

class Reader {
 public:
  explicit Reader(const ProblemSetFiles& files)
      : files_(files), pairs_(find_pairs(files.folder)), tree_(files.urdf), frames_{"world", tree_.root()} {
    first_request_ = pairs_.front().request.string();
    first_ = config::read_moveit_request(first_request_);
  }

  ProblemSet read() {
    for (const auto& [joint, value] : first_.goal) {
      if (tree_.joint(joint) != nullptr) continue;
      throw std::runtime_error(first_request_ + ": has a goal for joint " + in_quotes(joint) + ", which " +
                               files_.urdf + " does not have; give the problems of this robot");
    }
    const std::vector<std::string> tools = tool_links();
    for (const std::string& tool : tools) set_.arms.push_back(load(tool, tools));
    for (const Pair& pair : pairs_) set_.problems.push_back(problem(pair));
    widen_limits();
    return std::move(set_);
  }

 private:
  /// Links of joints in the goal that move no other joint in the goal.
  [[nodiscard]] std::vector<std::string> tool_links() const {
    for (const std::string& tool : files_.tool_links) {
      if (tree_.has_link(tool)) continue;
      throw std::runtime_error("--tool-link " + tool + ": " + files_.urdf +
                               " has no link of this name; leave the option out to take it from the requests");
    }
    if (!files_.tool_links.empty()) return files_.tool_links;
    std::vector<std::string> tips;
    for (const auto& [name, value] : first_.goal) {
      const auto moves = [&](const auto& other) {
        const auto way = tree_.chain(tree_.joint(other.first)->parent);
        return std::any_of(way.begin(), way.end(), [&](const TreeJoint* joint) { return joint->name == name; });
      };
      if (std::none_of(first_.goal.begin(), first_.goal.end(), moves)) tips.push_back(tree_.joint(name)->child);
    }
    return tips;
  }

  Arm load(const std::string& tool, const std::vector<std::string>& tools) {
    UrdfOptions options;
    options.srdf_path = files_.srdf;
    options.tool_link = tool;
    options.default_velocity = 1.0;  // plans have no time
    options.allow_bare_links = true;
    std::copy_if(tools.begin(), tools.end(), std::back_inserter(options.other_arms),
                 [&](const std::string& other) { return other != tool; });
    const auto chain = tree_.chain(tool);
    const auto first = std::find_if(chain.begin(), chain.end(),
                                    [&](const TreeJoint* joint) { return first_.goal.contains(joint->name); });
    if (first == chain.end()) {
      throw std::runtime_error(first_request_ + ": has no goal for a joint that moves link " + in_quotes(tool) +
                               "; name another link with --tool-link");
    }
    for (auto joint = first; joint != chain.end(); ++joint) {
      if (!first_.goal.contains((*joint)->name)) refuse_missing(first_request_, "goal", (*joint)->name, tool);
    }
    if (first != chain.begin()) options.base_link = (*first)->parent;
    for (const auto& [name, value] : first_.start) {
      const TreeJoint* joint = tree_.joint(name);
      if (joint == nullptr || !joint->moves || first_.goal.contains(name)) continue;
      options.held_joints[name] = std::clamp(value, joint->lower, joint->upper);
    }
    Arm arm;
    arm.name = tools.size() == 1 ? "robot" : tool;
    arm.model = load_arm_model(files_.urdf, options);
    arm.limits = arm.model->limits;
    if (tools.size() > 1) arm.robot = 0;
    set_.notes.insert(set_.notes.end(), arm.model->notes.begin(), arm.model->notes.end());
    return arm;
  }

  [[noreturn]] static void refuse_missing(const std::string& file, const std::string& what, const std::string& joint,
                                          const std::string& tool) {
    throw std::runtime_error(file + ": has no " + what + " for joint " + in_quotes(joint) + ", which moves link " +
                             in_quotes(tool) + "; name another link with --tool-link");
  }

  [[nodiscard]] std::vector<double> ordered(const std::string& file, const std::string& what,
                                            const std::map<std::string, double>& positions) const {
    std::vector<double> q;
    for (const Arm& arm : set_.arms) {
      for (const std::string& joint : arm.model->joint_names) {
        const auto found = positions.find(joint);
        if (found == positions.end()) {
          refuse_missing(file, what, joint, arm.model->links[arm.model->tool_link].name);
        }
        q.push_back(found->second);
      }
    }
    return q;
  }

  [[nodiscard]] Problem problem(const Pair& pair) const {
    Problem problem{pair.scene.string(), pair.scene.parent_path().filename().string(), {}, {}, {}};
    for (const world::Obstacle& obstacle : config::read_moveit_scene(pair.scene.string(), frames_).obstacles) {
      for (const world::PlacedShape& placed : obstacle.shapes) {
        problem.world.push_back({placed.shape, obstacle.X_WO * placed.X_BS, obstacle.name});
      }
    }
    const std::string file = pair.request.string();
    const config::MoveItRequest request = config::read_moveit_request(file);
    check_held(file, request);
    problem.start = ordered(file, "start", request.start);
    problem.goal = ordered(file, "goal", request.goal);
    return problem;
  }

  void check_held(const std::string& file, const config::MoveItRequest& request) const {
    for (const auto& [name, value] : request.start) {
      if (first_.goal.contains(name) || tree_.joint(name) == nullptr || !tree_.joint(name)->moves) continue;
      const auto first = first_.start.find(name);
      if (first != first_.start.end() && std::abs(first->second - value) < 1e-6) continue;
      throw std::runtime_error(file + ": starts joint " + in_quotes(name) + " elsewhere than " + first_request_ +
                               ", though no goal moves it; give only problems that hold it in one place");
    }
  }

  void widen_limits() {
    for (const Problem& problem : set_.problems) {
      for (const auto* q : {&problem.start, &problem.goal}) {
        const double* values = q->data();
        for (Arm& arm : set_.arms) {
          const Eigen::Map<const JointVector> end(values, arm.model->joints());
          values += arm.model->joints();
          arm.limits.lower = arm.limits.lower.cwiseMin(end);
          arm.limits.upper = arm.limits.upper.cwiseMax(end);
        }
      }
    }
  }

  const ProblemSetFiles& files_;
  std::vector<Pair> pairs_;
  JointTree tree_;
  std::vector<std::string> frames_;  ///< names of the planning frame
  std::string first_request_;
  config::MoveItRequest first_;
  ProblemSet set_;
};

}  // namespace

ProblemSet read_problem_set(const ProblemSetFiles& files) {
  return Reader(files).read();
}

planner::global::Validity make_validity(const ProblemSet& set, double step) {
  std::vector<CellGeometry> planned;
  for (int i = 0; i < static_cast<int>(set.arms.size()); ++i) planned.emplace_back(set.arms, i);
  planner::global::ValidityOptions options;
  options.step = step;
  return planner::global::Validity(std::move(planned), {}, options);
}

}  // namespace hecaton::bench
