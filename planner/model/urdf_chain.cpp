#include "planner/model/urdf_chain.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <utility>

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

/// Without joints that follow others.
int free_joints(const std::vector<TreeLink>& tree, int i) {
  int joints = 0;
  for (; i > 0; i = tree[i].link.parent) joints += moves(tree[i]) && !tree[i].mimic ? 1 : 0;
  return joints;
}

/// Of the links fixed to `body`, the one named tool0, as ROS-Industrial does. Without tool0 it is the link with the
/// most fixed joints between; of equals, the first in the tree's order.
int tip_of_body(const std::vector<TreeLink>& tree, int body) {
  int tip = body;
  for (int i = body; i < static_cast<int>(tree.size()); ++i) {
    if (moved_link(tree, i) != body) continue;
    if (tree[i].link.name == "tool0") return i;
    if (depth(tree, i) > depth(tree, tip)) tip = i;
  }
  return tip;
}

/// The position at which joint `i` outside the chain is held.
double held_position(const std::vector<TreeLink>& tree, int i, const ChainRequest& request, std::size_t hops = 0) {
  const TreeLink& entry = tree[i];
  if (entry.mimic && hops < tree.size()) {
    const int source = index_of_joint(tree, entry.mimic->joint);
    const double position = source < 0 || !moves(tree[source]) ? 0.0 : held_position(tree, source, request, hops + 1);
    const double followed = entry.mimic->multiplier * position + entry.mimic->offset;
    return std::isfinite(followed) ? followed : 0.0;
  }
  const auto wish = request.held.find(entry.link.joint_name);
  if (wish != request.held.end()) return wish->second;
  return entry.link.joint_type == JointType::kContinuous ? 0.0 : std::clamp(0.0, entry.lower, entry.upper);
}

/// "0.02", without superfluous digits.
std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string bareness(const TreeLink& entry) {
  return "link " + in_quotes(entry.link.name) + ", which joint " + in_quotes(entry.link.joint_name) +
         " moves, has no collision geometry";
}

[[noreturn]] void refuse(const std::string& path, const std::string& sentence, const std::string& rule) {
  throw ModelError(path + ": " + sentence + "; " + rule);
}

/// The joint of the chain that joint `i` follows, over others if need be; nothing if it follows none of the chain.
std::optional<Follower> follower_of_chain(const std::vector<TreeLink>& tree, int i, const std::vector<int>& chain) {
  Follower follower{i, tree[i].link.joint_type, tree[i].link.X_PJ};
  int source = i;
  for (std::size_t hops = 0; hops < tree.size() && tree[source].mimic; ++hops) {
    const TreeLink::Mimic& mimic = *tree[source].mimic;
    follower.offset += follower.multiplier * mimic.offset;
    follower.multiplier *= mimic.multiplier;
    source = index_of_joint(tree, mimic.joint);
    if (source < 0) return std::nullopt;
    const auto found = std::find(chain.begin(), chain.end(), source);
    if (found == chain.end()) continue;
    follower.joint = static_cast<int>(found - chain.begin());
    return follower;
  }
  return std::nullopt;
}

bool is_below(const std::vector<TreeLink>& tree, int i, int top) {
  while (i > top) i = tree[i].link.parent;
  return i == top;
}

/// The links that moving joints connect with the body of `body`, followers included.
std::vector<int> moving_children(const std::vector<TreeLink>& tree, int body) {
  std::vector<int> children;
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (moves(tree[i]) && moved_link(tree, tree[i].link.parent) == body) children.push_back(i);
  }
  return children;
}

bool has_word(const std::string& name, std::initializer_list<const char*> words) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return lower.find(word) != std::string::npos; });
}

/// True for a joint named as "left_finger_joint" is, or for a link named so. A link named "gripper" may be the hand, a
/// joint named "gripper_roll" the wrist.
bool is_named_finger(const Link& link) {
  if (has_word(link.joint_name, {"roll", "rot", "yaw", "pitch", "wrist"})) return false;
  return has_word(link.joint_name, {"finger", "gripper", "jaw", "knuckle", "thumb", "claw"}) ||
         has_word(link.name, {"finger", "jaw", "knuckle", "thumb", "claw"});
}

/// True when the joints beyond `body` are those of a gripper. They are fewer than the joints before it, and one follows
/// another, or several slide, or all have names of fingers.
bool carries_fingers(const std::vector<TreeLink>& tree, int body, int joints_beyond) {
  const std::vector<int> children = moving_children(tree, body);
  if (children.empty() || joints_beyond >= moving_joints(tree, body)) return false;
  const auto all = [&](auto&& holds) { return std::all_of(children.begin(), children.end(), holds); };
  if (all([&](int i) { return is_named_finger(tree[i].link); })) return true;
  if (children.size() < 2) return false;
  if (all([&](int i) { return tree[i].link.joint_type == JointType::kPrismatic; })) return true;
  return std::any_of(children.begin(), children.end(), [&](int i) { return tree[i].mimic.has_value(); });
}

/// The body that carries the gripper to which `body` belongs, or `body` itself.
int without_fingers(const std::vector<TreeLink>& tree, int body) {
  const int joints = moving_joints(tree, body);
  int hand = body;
  for (int i = moved_link(tree, tree[body].link.parent); moves(tree[i]); i = moved_link(tree, tree[i].link.parent)) {
    if (carries_fingers(tree, i, joints - moving_joints(tree, i))) hand = i;
  }
  return hand;
}

int link_named(const std::vector<TreeLink>& tree, const std::string& wanted, const ChainRequest& request,
               const char* role) {
  const int found = index_of_link(tree, wanted);
  if (found >= 0) return found;
  constexpr std::size_t kMostNames = 40;
  std::string names;
  for (std::size_t i = 0; i < tree.size() && i < kMostNames; ++i) names += (i == 0 ? "" : ", ") + tree[i].link.name;
  if (tree.size() > kMostNames) names += ", …";
  throw ModelError(request.path + ": " + role + " link " + in_quotes(wanted) + " must be one of its links: " + names);
}

/// Refuses positions of joints that do not exist, move the tool, follow another joint, or cannot be there.
void check_held(const std::vector<TreeLink>& tree, const std::vector<int>& chain, const ChainRequest& request) {
  for (const auto& [name, position] : request.held) {
    const std::string sentence =
        request.path + ": " + request.name_of_held + ": joint " + in_quotes(name) + " = " + short_text(position);
    const int i = index_of_joint(tree, name);
    if (i < 0) throw ModelError(sentence + ": the robot has no such joint");
    if (std::find(chain.begin(), chain.end(), i) != chain.end()) {
      throw ModelError(sentence + ": it moves the tool; only joints outside the chain are held");
    }
    const TreeLink& entry = tree[i];
    if (!moves(entry)) throw ModelError(sentence + ": it does not move");
    if (entry.mimic) throw ModelError(sentence + ": it follows joint " + in_quotes(entry.mimic->joint) + "; give that");
    const bool endless = entry.link.joint_type == JointType::kContinuous;
    if (!endless && !(position >= entry.lower && position <= entry.upper)) {
      throw ModelError(sentence + " must be within its limits, " + short_text(entry.lower) + " to " +
                       short_text(entry.upper));
    }
  }
}

/// Fixes all joints outside the chain.
void hold_others(std::vector<TreeLink>& tree, const std::vector<int>& chain, const ChainRequest& request,
                 std::vector<std::string>& notes) {
  std::vector<double> held(tree.size(), 0.0);
  std::vector<int> others;
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!moves(tree[i]) || std::find(chain.begin(), chain.end(), i) != chain.end()) continue;
    others.push_back(i);
    held[i] = held_position(tree, i, request);
  }
  std::string positions;
  for (const int i : others) {
    Link& link = tree[i].link;
    positions += (positions.empty() ? "" : ", ") + in_quotes(link.joint_name) + " at " + short_text(held[i]);
    if (link.joint_type == JointType::kPrismatic) {
      link.X_PJ.translate(held[i] * link.axis);
    } else {
      link.X_PJ.rotate(Eigen::AngleAxisd(held[i], link.axis));
    }
    link.joint_type = JointType::kFixed;
  }
  if (positions.empty()) return;
  const std::string how = request.name_of_held.empty() ? "" : " (" + request.name_of_held + " sets them)";
  notes.push_back("joints outside the chain to the tool are held" + how + ": " + positions);
}

}  // namespace

int index_of_link(const std::vector<TreeLink>& tree, const std::string& name) {
  const auto found =
      std::find_if(tree.begin(), tree.end(), [&](const TreeLink& entry) { return entry.link.name == name; });
  return found == tree.end() ? -1 : static_cast<int>(found - tree.begin());
}

int find_tool_link(const std::vector<TreeLink>& tree, const ChainRequest& request, std::vector<std::string>& notes) {
  if (!request.tool_link.empty()) return link_named(tree, request.tool_link, request, "tool");
  const int base = request.base_link.empty() ? 0 : link_named(tree, request.base_link, request, "base");
  // Joints that follow others count only between chains of equally many free joints: a mechanism beside the arm is no
  // chain to the tool.
  using Length = std::pair<int, int>;
  const auto length = [&](int i) -> Length { return {free_joints(tree, i), moving_joints(tree, i)}; };
  const auto is_candidate = [&](int i) { return moves(tree[i]) && is_below(tree, i, base); };
  Length most{0, 0};
  for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
    if (is_candidate(i)) most = std::max(most, length(i));
  }
  std::vector<int> bodies;  // that carry a tool
  for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
    if (!is_candidate(i) || length(i) != most) continue;
    const int body = without_fingers(tree, i);
    if (std::find(bodies.begin(), bodies.end(), body) == bodies.end()) bodies.push_back(body);
  }
  if (bodies.size() > 1) {
    const std::string how = request.name_of_tool_link.empty() ? "tool_link" : request.name_of_tool_link;
    throw ModelError(request.path + ": the chains to links " + in_quotes(tree[tip_of_body(tree, bodies[0])].link.name) +
                     " and " + in_quotes(tree[tip_of_body(tree, bodies[1])].link.name) + " both have " +
                     std::to_string(moving_joints(tree, bodies[0])) + " joints; say which link is the tool (" + how +
                     ")");
  }
  const int tool = tip_of_body(tree, bodies.empty() ? base : bodies[0]);
  const bool has_fingers = !bodies.empty() && moving_joints(tree, bodies[0]) < most.second;
  notes.push_back("link " + in_quotes(tree[tool].link.name) + " is taken as the tool, the tip of the longest chain" +
                  (has_fingers ? " without the joints of its fingers" : ""));
  return tool;
}

Chain number_chain(std::vector<TreeLink>& tree, int tool, const ChainRequest& request,
                   std::vector<std::string>& notes) {
  const int base = request.base_link.empty() ? 0 : link_named(tree, request.base_link, request, "base");
  if (!is_below(tree, tool, base)) {
    throw ModelError(request.path + ": tool link " + in_quotes(tree[tool].link.name) + " must hang on base link " +
                     in_quotes(tree[base].link.name));
  }
  Chain chain;
  for (int i = tool; i > base; i = tree[i].link.parent) {
    if (moves(tree[i])) chain.links.insert(chain.links.begin(), i);
  }
  if (chain.links.empty()) {
    throw ModelError(request.path + ": no joint between the " +
                     (base == 0 ? "root" : "base link " + in_quotes(tree[base].link.name)) + " and tool link " +
                     in_quotes(tree[tool].link.name) +
                     " moves; an arm needs at least one revolute, continuous or prismatic joint");
  }
  if (static_cast<int>(chain.links.size()) > kMaxJoints) {
    throw ModelError(request.path + ": " + std::to_string(chain.links.size()) + " joints move the tool; at most " +
                     std::to_string(kMaxJoints) + " are allowed");
  }
  for (const int i : chain.links) {
    if (!tree[i].mimic) continue;
    throw ModelError(request.path + ": joint " + in_quotes(tree[i].link.joint_name) +
                     " moves the tool but mimics joint " + in_quotes(tree[i].mimic->joint) +
                     "; every joint of the chain must move freely");
  }
  check_held(tree, chain.links, request);
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!moves(tree[i])) continue;
    if (const auto follower = follower_of_chain(tree, i, chain.links)) chain.followers.push_back(*follower);
  }
  hold_others(tree, chain.links, request, notes);
  for (int joint = 0; joint < static_cast<int>(chain.links.size()); ++joint) {
    tree[chain.links[joint]].link.joint = joint;
  }
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
