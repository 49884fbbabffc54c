#include "planner/model/urdf_chain.hpp"

#include <algorithm>
#include <cmath>

#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

bool moves(const TreeLink& entry) {
  return entry.link.joint_type != JointType::kFixed;
}

int index_of_joint(const std::vector<TreeLink>& tree, const std::string& name) {
  const auto found =
      std::find_if(tree.begin() + 1, tree.end(), [&](const TreeLink& entry) { return entry.link.joint_name == name; });
  return found == tree.end() ? -1 : static_cast<int>(found - tree.begin());
}

/// The nearest link towards the root (or `i`) whose joint moves; 0: none.
int moved_link(const std::vector<TreeLink>& tree, int i) {
  while (i > 0 && !moves(tree[i])) i = tree[i].link.parent;
  return i;
}

int depth(const std::vector<TreeLink>& tree, int i) {
  int links = 0;
  for (; i > 0; i = tree[i].link.parent) ++links;
  return links;
}

int moving_joints(const std::vector<TreeLink>& tree, int i) {
  int joints = 0;
  for (; i > 0; i = tree[i].link.parent) joints += moves(tree[i]) ? 1 : 0;
  return joints;
}

/// Among the links fixed to `body`: tool0 (ROS-Industrial's name) if it exists, else the one with the most fixed joints
/// between, the first in the tree's order among equals.
int tip_of_body(const std::vector<TreeLink>& tree, int body) {
  int tip = body;
  for (int i = body; i < static_cast<int>(tree.size()); ++i) {
    if (moved_link(tree, i) != body) continue;
    if (tree[i].link.name == "tool0") return i;
    if (depth(tree, i) > depth(tree, tip)) tip = i;
  }
  return tip;
}

bool carries_collision(const std::vector<TreeLink>& tree, int top) {
  for (int i = top; i < static_cast<int>(tree.size()); ++i) {
    int ancestor = i;
    while (ancestor > top) ancestor = tree[ancestor].link.parent;
    if (ancestor == top && tree[i].has_collision) return true;
  }
  return false;
}

/// The constant position of joint `i`, which is outside the chain.
double held_position(const std::vector<TreeLink>& tree, int i, int mimic_depth = 0) {
  const TreeLink& entry = tree[i];
  if (entry.mimic && mimic_depth < static_cast<int>(tree.size())) {
    const int source = index_of_joint(tree, entry.mimic->joint);
    const double position = source < 0 || !moves(tree[source]) ? 0.0 : held_position(tree, source, mimic_depth + 1);
    const double followed = entry.mimic->multiplier * position + entry.mimic->offset;
    return std::isfinite(followed) ? followed : 0.0;
  }
  return entry.link.joint_type == JointType::kContinuous ? 0.0 : std::clamp(0.0, entry.lower, entry.upper);
}

std::string coupling(const TreeLink& follower, const TreeLink& source) {
  return "joint " + in_quotes(follower.link.joint_name) + " follows joint " + in_quotes(source.link.joint_name) +
         ", which moves the tool";
}

std::string bareness(const TreeLink& entry) {
  return "link " + in_quotes(entry.link.name) + ", which joint " + in_quotes(entry.link.joint_name) +
         " moves, has no collision geometry";
}

[[noreturn]] void refuse(const std::string& path, const std::string& sentence, const std::string& rule) {
  throw ModelError(path + ": " + sentence + "; " + rule);
}

/// A joint outside the chain that mimics a joint of the chain moves with the arm: refused if it carries collision
/// geometry, noted otherwise.
void refuse_if_coupled(const std::vector<TreeLink>& tree, int i, const std::vector<bool>& in_chain,
                       const std::string& path, std::vector<std::string>& notes) {
  int source = i;
  for (std::size_t hops = 0; hops < tree.size() && tree[source].mimic; ++hops) {
    source = index_of_joint(tree, tree[source].mimic->joint);
    if (source < 0) return;
    if (!in_chain[source]) continue;
    const std::string sentence = coupling(tree[i], tree[source]);
    if (carries_collision(tree, i)) {
      refuse(path, sentence, "mechanisms that move collision geometry beside the chain are not supported");
    }
    notes.push_back(sentence + "; it carries no collision geometry and is ignored");
    return;
  }
}

}  // namespace

int find_tool_link(const std::vector<TreeLink>& tree, const std::string& wanted, const std::string& path,
                   std::vector<std::string>& notes) {
  const int links = static_cast<int>(tree.size());
  if (!wanted.empty()) {
    std::string names;
    for (int i = 0; i < links; ++i) {
      if (tree[i].link.name == wanted) return i;
      names += (i == 0 ? "" : ", ") + tree[i].link.name;
    }
    throw ModelError(path + ": tool link " + in_quotes(wanted) + " must be one of its links: " + names);
  }
  int most = 0;
  for (int i = 0; i < links; ++i) most = std::max(most, moving_joints(tree, i));
  std::vector<int> bodies;
  for (int i = 0; i < links; ++i) {
    if (moves(tree[i]) && moving_joints(tree, i) == most) bodies.push_back(i);
  }
  if (bodies.size() > 1) {
    throw ModelError(path + ": the chains to links " + in_quotes(tree[bodies[0]].link.name) + " and " +
                     in_quotes(tree[bodies[1]].link.name) + " both have " + std::to_string(most) +
                     " joints; say which link is the tool (tool_link)");
  }
  const int tool = tip_of_body(tree, bodies.empty() ? 0 : bodies[0]);
  notes.push_back("link " + in_quotes(tree[tool].link.name) + " is taken as the tool, the tip of the longest chain");
  return tool;
}

std::vector<int> number_chain(std::vector<TreeLink>& tree, int tool, const std::string& path,
                              std::vector<std::string>& notes) {
  std::vector<bool> in_chain(tree.size(), false);
  std::vector<int> chain;
  for (int i = tool; i > 0; i = tree[i].link.parent) {
    if (!moves(tree[i])) continue;
    in_chain[i] = true;
    chain.insert(chain.begin(), i);
  }
  if (chain.empty()) {
    throw ModelError(path + ": no joint between the root and tool link " + in_quotes(tree[tool].link.name) +
                     " moves; an arm needs at least one revolute, continuous or prismatic joint");
  }
  if (static_cast<int>(chain.size()) > kMaxJoints) {
    throw ModelError(path + ": " + std::to_string(chain.size()) + " joints move the tool; at most " +
                     std::to_string(kMaxJoints) + " are allowed");
  }
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (in_chain[i] && tree[i].mimic) {
      throw ModelError(path + ": joint " + in_quotes(tree[i].link.joint_name) + " moves the tool but mimics joint " +
                       in_quotes(tree[i].mimic->joint) + "; every joint of the chain must move freely");
    }
    if (!in_chain[i] && moves(tree[i])) refuse_if_coupled(tree, i, in_chain, path, notes);
  }
  std::vector<double> held(tree.size(), 0.0);
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!in_chain[i] && moves(tree[i])) held[i] = held_position(tree, i);
  }
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    Link& link = tree[i].link;
    if (in_chain[i] || link.joint_type == JointType::kFixed) continue;
    notes.push_back("joint " + in_quotes(link.joint_name) + " is outside the chain to the tool and held at " +
                    std::to_string(held[i]));
    if (link.joint_type == JointType::kPrismatic) {
      link.X_PJ.translate(held[i] * link.axis);
    } else {
      link.X_PJ.rotate(Eigen::AngleAxisd(held[i], link.axis));
    }
    link.joint_type = JointType::kFixed;
  }
  for (int joint = 0; joint < static_cast<int>(chain.size()); ++joint) tree[chain[joint]].link.joint = joint;
  for (TreeLink& entry : tree) entry.link.motion = joint_motion(entry.link);
  return chain;
}

void check_bare_links(const std::vector<TreeLink>& tree, bool allow, const std::string& remedy, const std::string& path,
                      std::vector<std::string>& notes) {
  std::vector<bool> covered(tree.size(), false);  // by the link that moves the body
  for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
    if (tree[i].has_collision) covered[moved_link(tree, i)] = true;
  }
  if (!covered[0]) notes.push_back("the base, link " + in_quotes(tree[0].link.name) + ", has no collision geometry");
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!moves(tree[i]) || covered[i]) continue;
    const std::string sentence = bareness(tree[i]);
    if (!allow) refuse(path, sentence, "it must have some" + remedy);
    notes.push_back(sentence + ": the planner does not keep it clear of anything");
  }
}

}  // namespace hecaton::planner
