#pragma once
/// The chain of joints from a URDF's base to its tool, which the planner moves. Works on plain values, without urdfdom.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planner/model/followers.hpp"
#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// A joint of the URDF and the link that it carries. Index 0 of a tree is its root, which no joint carries.
struct TreeLink {
  Link link;  ///< `joint` not yet set
  bool has_collision = false;
  double lower = 0.0;  ///< of a revolute or prismatic joint [rad | m]
  double upper = 0.0;  ///< equal to lower: the joint does not move, or follows another one without a range of its own
  double velocity = 0.0;  ///< 0 when the URDF says nothing [rad/s | m/s]
  double effort = 0.0;    ///< the same [N m | N]
  struct Mimic {
    std::string joint;
    double multiplier = 1.0;
    double offset = 0.0;
  };
  std::optional<Mimic> mimic;
};

/// What a user asks of the chain. Messages use the `name_of_…`, such as "--tool LINK" or "arms[0].tool_link", as the
/// way to ask for it. Empty: there is no way.
struct ChainRequest {
  std::string path;                           ///< of the URDF; messages of errors begin with it
  std::string base_link;                      ///< joints above it are held; empty: the root
  std::string tool_link;                      ///< empty: proposed
  std::map<std::string, double> held;         ///< positions of joints outside the chain [rad | m]
  std::map<std::string, MotionRange> ranges;  ///< of joints outside the chain that move on their own
  std::string name_of_tool_link;
  std::string name_of_held;
};

/// In `name_of_tool_link`, stand for the two links of equal chains between which the user has to choose.
inline constexpr std::string_view kFirstToolLink = "@first";
inline constexpr std::string_view kSecondToolLink = "@second";

/// Index of the link with this name; −1: none.
[[nodiscard]] int index_of_link(const std::vector<TreeLink>& tree, const std::string& name);

/// Index of the tool link. Without `tool_link` it is the tip of the chain with the most moving joints below the base
/// link, without the fingers of a gripper; adds a note then. Throws ModelError when a link does not exist, or when
/// several chains qualify.
[[nodiscard]] int find_tool_link(const std::vector<TreeLink>& tree, const ChainRequest& request,
                                 std::vector<std::string>& notes);

/// A joint that the planner moves.
struct ChainJoint {
  int link = 0;                           ///< that it carries, an index into the tree
  JointType type = JointType::kRevolute;  ///< before it was fixed, when its link is beside the chain
};

/// The joints that move the tool, and what moves with them.
struct Chain {
  std::vector<ChainJoint> joints;  ///< base to tip
  /// Joints beside the chain that follow one of these joints or one with a range, or are one of them.
  std::vector<Follower> followers;
  std::vector<MotionRange> ranges;       ///< see Follower::joint
  std::vector<std::string> range_names;  ///< joints that have them
  std::map<std::string, double> held;    ///< positions of the other joints that follow none [rad | m]
};

/// Numbers the joints that move the links from the base link to `tool`, and sets Link::joint of these links. A link
/// that follows another joint moves with that one, also if that one is beside the chain. All other joints become fixed
/// ones, at the requested position, at zero, or at the nearest limit. Their followers are fixed where that puts them.
/// Adds one note with these positions, and one with the followers. Throws ModelError for a chain without moving joints,
/// with more than kMaxJoints moving links, or with a follower of another arm. Throws it also for joints that cannot be
/// held or move as requested.
[[nodiscard]] Chain number_chain(std::vector<TreeLink>& tree, int tool, const ChainRequest& request,
                                 std::vector<std::string>& notes);

/// Throws ModelError for the first body without collision geometry; a body is a link that a chain joint moves, with all
/// links fixed to it. `remedy` ends the sentence. With `allow`, adds notes instead. Frames without extent between two
/// joints that turn about one point, one of which follows, need no geometry.
void check_bare_links(const std::vector<TreeLink>& tree, bool allow, const std::string& remedy, const std::string& path,
                      std::vector<std::string>& notes);

}  // namespace hecaton::planner
