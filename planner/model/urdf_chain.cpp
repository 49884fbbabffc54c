#include "planner/model/urdf_chain.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <string_view>
#include <tuple>
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

/// The position at which joint `i` outside the chain is held.
double held_position(const std::vector<TreeLink>& tree, int i, const ChainRequest& request, std::size_t hops = 0) {
  const TreeLink& entry = tree[i];
  if (entry.mimic && hops < tree.size()) {
    const int source = index_of_joint(tree, entry.mimic->joint);
    const double position = source < 0             ? 0.0
                            : !moves(tree[source]) ? tree[source].lower
                                                   : held_position(tree, source, request, hops + 1);
    const double followed = entry.mimic->multiplier * position + entry.mimic->offset;
    return std::isfinite(followed) ? followed : 0.0;
  }
  const auto wish = request.held.find(entry.link.joint_name);
  if (wish != request.held.end()) return wish->second;
  const auto range = request.ranges.find(entry.link.joint_name);
  if (range != request.ranges.end()) return std::clamp(0.0, range->second.lower, range->second.upper);
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

/// The joint that joint `i` follows, over others if need be; `i` itself if it follows none.
struct Followed {
  int source = -1;  ///< −1: the robot has no such joint any more
  double multiplier = 1.0;
  double offset = 0.0;
};
Followed followed_by(const std::vector<TreeLink>& tree, int i) {
  Followed followed{i};
  for (std::size_t hops = 0; followed.source >= 0 && tree[followed.source].mimic && hops < tree.size(); ++hops) {
    const TreeLink::Mimic& mimic = *tree[followed.source].mimic;
    followed.offset += followed.multiplier * mimic.offset;
    followed.multiplier *= mimic.multiplier;
    followed.source = index_of_joint(tree, mimic.joint);
  }
  return followed;
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

/// The link fixed to `body` on which all fingers hang, directly or by fixed links; `body` itself without fingers.
int hand_of_body(const std::vector<TreeLink>& tree, int body) {
  int hand = -1;
  for (const int child : moving_children(tree, body)) {
    int carrier = tree[child].link.parent;
    if (hand < 0) hand = carrier;
    while (hand != carrier) {  // parents come before children
      int& deeper = hand > carrier ? hand : carrier;
      deeper = tree[deeper].link.parent;
    }
  }
  return hand < 0 ? body : hand;
}

/// Of the links fixed to `body`, the one named tool0, as ROS-Industrial does. Without tool0 it is one named as the
/// centre of a grasp, otherwise the link with the most fixed joints between; of equals, the first in the tree's order.
/// Frames of cameras are no tools. Where the body carries fingers, links of the flange that carries the hand come last,
/// tool0 included, and so do those that carry single fingers.
int tip_of_body(const std::vector<TreeLink>& tree, int body) {
  const int hand = hand_of_body(tree, body);
  const std::vector<int> fingers = moving_children(tree, body);
  const auto is_of_hand = [&](int i) {
    const auto hangs_on_it = [&](int finger) { return is_below(tree, finger, i); };
    return i == hand || (is_below(tree, i, hand) && std::none_of(fingers.begin(), fingers.end(), hangs_on_it));
  };
  const auto value_of = [&](int i) {
    const std::string& name = tree[i].link.name;
    const bool is_camera = has_word(name, {"camera", "optical", "realsense"});
    const int named = has_word(name, {"tcp", "grasp"}) ? 2 : 0;
    return std::pair{is_camera ? -1 : named + (is_of_hand(i) ? 1 : 0), depth(tree, i)};
  };
  int tip = body;
  for (int i = body; i < static_cast<int>(tree.size()); ++i) {
    if (moved_link(tree, i) != body) continue;
    if (tree[i].link.name == "tool0" && is_of_hand(i)) return i;
    if (value_of(i) > value_of(tip)) tip = i;
  }
  return tip;
}

/// True for a joint named as "left_finger_joint" is, or for a link named so. A link named "gripper" may be the hand, a
/// joint named "gripper_roll" the wrist. A thumb may turn as a wrist does.
bool is_named_finger(const Link& link) {
  if (has_word(link.joint_name, {"thumb"}) || has_word(link.name, {"thumb"})) return true;
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
  // Beside a thumb the other fingers are named "index", "middle", "ring" and so on.
  if (std::any_of(children.begin(), children.end(), [&](int i) { return has_word(tree[i].link.name, {"thumb"}); })) {
    return true;
  }
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

void replace_word(std::string& text, std::string_view word, const std::string& by) {
  const std::size_t at = text.rfind(word);
  if (at != std::string::npos) text.replace(at, word.size(), by);
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

/// Index into Chain::joints of the joint that carries link `i`; −1: none.
int index_in(const Chain& chain, int i) {
  const auto found =
      std::find_if(chain.joints.begin(), chain.joints.end(), [&](const ChainJoint& joint) { return joint.link == i; });
  return found == chain.joints.end() ? -1 : static_cast<int>(found - chain.joints.begin());
}

/// Which joints a position can be given for.
std::string settable_joints(const std::vector<TreeLink>& tree, const Chain& chain) {
  constexpr std::size_t kMostNames = 40;
  std::string names;
  std::size_t count = 0;
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!moves(tree[i]) || tree[i].mimic || index_in(chain, i) >= 0) continue;
    if (++count <= kMostNames) names += (names.empty() ? "" : ", ") + in_quotes(tree[i].link.joint_name);
  }
  if (count == 0) return "; no joint outside the chain moves: give none";
  return "; it must be one of those outside the chain: " + names + (count > kMostNames ? ", …" : "");
}

/// Refuses positions of joints that do not exist, move the tool, follow another joint, or cannot be there. `where` ends
/// before the value. Returns the link that the joint carries.
int check_position(const std::vector<TreeLink>& tree, const Chain& chain, const std::string& where,
                   const std::string& name, const MotionRange& wish) {
  const bool moves_on = wish.lower != wish.upper;
  const std::string sentence =
      where + ": joint " + in_quotes(name) + " = " +
      (moves_on ? "[" + short_text(wish.lower) + ", " + short_text(wish.upper) + "]" : short_text(wish.lower));
  const int i = index_of_joint(tree, name);
  if (i < 0) throw ModelError(sentence + ": the robot has no such joint" + settable_joints(tree, chain));
  if (index_in(chain, i) >= 0) {
    throw ModelError(sentence +
                     ": it moves the tool; remove it here, because goals and poses set it, or choose a base " +
                     "link behind it");
  }
  const TreeLink& entry = tree[i];
  if (!moves(entry)) throw ModelError(sentence + ": it does not move; remove it, or correct its type or limits");
  if (entry.mimic) throw ModelError(sentence + ": it follows joint " + in_quotes(entry.mimic->joint) + "; give that");
  const bool endless = entry.link.joint_type == JointType::kContinuous;
  if (!endless && !(wish.lower >= entry.lower && wish.upper <= entry.upper)) {
    throw ModelError(sentence + " must be within its limits, " + short_text(entry.lower) + " to " +
                     short_text(entry.upper));
  }
  if (!(wish.lower <= wish.upper)) throw ModelError(sentence + " must give the lower position first");
  return i;
}

void check_held(const std::vector<TreeLink>& tree, const Chain& chain, int tool, const ChainRequest& request) {
  const std::string where = request.path + ": " + request.name_of_held;
  for (const auto& [name, position] : request.held) {
    std::ignore = check_position(tree, chain, where, name, {position, position});
  }
  for (const auto& [name, range] : request.ranges) {
    const int i = check_position(tree, chain, where, name, range);
    if (!is_below(tree, tool, i)) continue;
    throw ModelError(where + ": joint " + in_quotes(name) +
                     " carries the arm and must have one position, because the planner does not move it: give one "
                     "number");
  }
}

/// Fixes all joints but those of the links `way`. Chain::held and the note leave out followers, whose links move.
void hold_others(std::vector<TreeLink>& tree, const std::vector<int>& way, const ChainRequest& request, Chain& chain,
                 std::vector<std::string>& notes) {
  std::vector<double> held(tree.size(), 0.0);
  std::vector<int> others;
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!moves(tree[i]) || std::find(way.begin(), way.end(), i) != way.end()) continue;
    others.push_back(i);
    held[i] = held_position(tree, i, request);
  }
  std::string positions;
  for (const int i : others) {
    Link& link = tree[i].link;
    const bool follows =
        std::any_of(chain.followers.begin(), chain.followers.end(), [i](const auto& one) { return one.link == i; });
    if (!follows) {
      if (!tree[i].mimic) chain.held[link.joint_name] = held[i];
      positions += (positions.empty() ? "" : ", ") + in_quotes(link.joint_name) + " at " + short_text(held[i]);
    }
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
    const std::string first = tree[tip_of_body(tree, bodies[0])].link.name;
    const std::string second = tree[tip_of_body(tree, bodies[1])].link.name;
    std::string how = request.name_of_tool_link.empty() ? "tool_link" : request.name_of_tool_link;
    replace_word(how, kFirstToolLink, first);
    replace_word(how, kSecondToolLink, second);
    throw ModelError(request.path + ": the chains to links " + in_quotes(first) + " and " + in_quotes(second) +
                     " both have " + std::to_string(moving_joints(tree, bodies[0])) +
                     " joints; say which link is the tool (" + how + ")");
  }
  const int tool = tip_of_body(tree, bodies.empty() ? base : bodies[0]);
  const bool has_fingers = !bodies.empty() && moving_joints(tree, bodies[0]) < most.second;
  notes.push_back("link " + in_quotes(tree[tool].link.name) + " is taken as the tool, the tip of the longest chain" +
                  (has_fingers ? " without the joints of its fingers" : ""));
  return tool;
}

namespace {

/// The moving links from `base` (excluded) to `tool`, base to tip.
std::vector<int> moving_way(const std::vector<TreeLink>& tree, int base, int tool) {
  std::vector<int> way;
  for (int i = tool; i > base; i = tree[i].link.parent) {
    if (moves(tree[i])) way.insert(way.begin(), i);
  }
  return way;
}

/// Removes the links of the way that do not move, because they follow a joint that is held or fixed.
void leave_out_held(const std::vector<TreeLink>& tree, int base, const ChainRequest& request, std::vector<int>& way) {
  const auto is_held = [&](int i) {
    if (!tree[i].mimic) return false;
    const Followed followed = followed_by(tree, i);
    if (followed.source < 0) {
      throw ModelError(request.path + ": joint " + in_quotes(tree[i].link.joint_name) + " moves the tool but mimics " +
                       "joint " + in_quotes(tree[i].mimic->joint) +
                       " of another arm; the joints of an arm must move without the other arms");
    }
    const TreeLink& source = tree[followed.source];
    const bool is_above = is_below(tree, base, followed.source);
    return !moves(source) || followed.multiplier == 0.0 || is_above || request.held.contains(source.link.joint_name);
  };
  std::erase_if(way, is_held);
}

/// The joints that move the way's links: each link's own, or the one that it follows.
std::vector<ChainJoint> joints_of(const std::vector<TreeLink>& tree, const std::vector<int>& way) {
  std::vector<ChainJoint> joints;
  for (const int i : way) {
    const int source = followed_by(tree, i).source;
    const bool comes_later = source != i && std::find(way.begin(), way.end(), source) != way.end();
    const bool is_known =
        std::any_of(joints.begin(), joints.end(), [&](const auto& joint) { return joint.link == source; });
    if (!comes_later && !is_known) joints.push_back({source, tree[source].link.joint_type});
  }
  return joints;
}

void note_followers(const std::vector<TreeLink>& tree, const std::vector<int>& way, const Chain& chain,
                    std::vector<std::string>& notes) {
  std::string list;
  for (const int i : way) {
    const Link& link = tree[i].link;
    if (!link.follows) continue;
    list += (list.empty() ? "" : ", ") + in_quotes(link.joint_name) + " = " + short_text(link.multiplier) + " · " +
            in_quotes(tree[chain.joints[link.joint].link].link.joint_name);
    if (link.offset != 0.0) list += (link.offset < 0.0 ? " - " : " + ") + short_text(std::abs(link.offset));
  }
  if (!list.empty()) notes.push_back("joints on the way to the tool follow others: " + list);
}

}  // namespace

Chain number_chain(std::vector<TreeLink>& tree, int tool, const ChainRequest& request,
                   std::vector<std::string>& notes) {
  const int base = request.base_link.empty() ? 0 : link_named(tree, request.base_link, request, "base");
  if (!is_below(tree, tool, base)) {
    throw ModelError(request.path + ": tool link " + in_quotes(tree[tool].link.name) + " must hang on base link " +
                     in_quotes(tree[base].link.name));
  }
  std::vector<int> way = moving_way(tree, base, tool);
  leave_out_held(tree, base, request, way);
  if (way.empty()) {
    throw ModelError(request.path + ": no joint between the " +
                     (base == 0 ? "root" : "base link " + in_quotes(tree[base].link.name)) + " and tool link " +
                     in_quotes(tree[tool].link.name) +
                     " moves; an arm needs at least one revolute, continuous or prismatic joint");
  }
  if (static_cast<int>(way.size()) > kMaxJoints) {
    throw ModelError(request.path + ": " + std::to_string(way.size()) + " joints move the tool; at most " +
                     std::to_string(kMaxJoints) + " are allowed");
  }
  Chain chain;
  chain.joints = joints_of(tree, way);
  check_held(tree, chain, tool, request);
  std::vector<int> with_range;  // links
  for (const auto& [name, range] : request.ranges) {
    with_range.push_back(index_of_joint(tree, name));
    chain.ranges.push_back(range);
    chain.range_names.push_back(name);
  }
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    if (!moves(tree[i])) continue;
    const Followed followed = followed_by(tree, i);
    int joint = index_in(chain, followed.source);
    const auto ranged = std::find(with_range.begin(), with_range.end(), followed.source);
    if (ranged != with_range.end()) {
      joint = static_cast<int>(chain.joints.size() + static_cast<std::size_t>(ranged - with_range.begin()));
    }
    if (joint < 0) continue;
    Link& link = tree[i].link;
    if (std::find(way.begin(), way.end(), i) == way.end()) {
      chain.followers.push_back({i, link.joint_type, link.X_PJ, joint, followed.multiplier, followed.offset});
      continue;
    }
    link.joint = joint;
    link.follows = followed.source != i;
    link.multiplier = followed.multiplier;
    link.offset = followed.offset;
  }
  hold_others(tree, way, request, chain, notes);
  note_followers(tree, way, chain, notes);
  for (TreeLink& entry : tree) entry.link.motion = joint_motion(entry.link);
  return chain;
}

namespace {

/// True if the body of link `i` is a mere frame between two joints that turn about one point, one of which follows.
/// Such frames describe parallelograms.
bool is_frame_of_turns(const std::vector<TreeLink>& tree, int i) {
  constexpr double kNoExtent = 1e-6;  // [m]
  const auto turns = [&](int link) { return tree[link].link.joint_type != JointType::kPrismatic; };
  for (const int child : moving_children(tree, i)) {
    Pose X_BJ = Pose::Identity();
    for (int link = child; link != i; link = tree[link].link.parent) X_BJ = tree[link].link.X_PJ * X_BJ;
    const bool follows = tree[i].link.follows || tree[child].link.follows;
    if (follows && turns(i) && turns(child) && X_BJ.translation().norm() < kNoExtent) return true;
  }
  return false;
}

}  // namespace

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
    if (!allow && is_frame_of_turns(tree, i)) {
      notes.push_back(sentence + " and no extent: it is the frame between two joints");
      continue;
    }
    if (!allow) refuse(path, sentence, "it must have some" + remedy);
    notes.push_back(sentence + ": the planner does not keep it clear of anything");
  }
}

}  // namespace hecaton::planner
