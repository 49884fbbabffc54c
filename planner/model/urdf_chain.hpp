#pragma once
/// Which joints of a URDF's tree the planner moves: those from the root to the tool. No urdfdom here: works on plain
/// values.

#include <optional>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// A joint of the URDF and the link that it carries. Index 0 of a tree is its root, which no joint carries.
struct TreeLink {
  Link link;  ///< `joint` not yet set
  bool has_collision = false;
  double lower = 0.0;  ///< of a revolute or prismatic joint [rad | m]
  double upper = 0.0;
  double velocity = 0.0;  ///< 0 when the URDF says nothing [rad/s | m/s]
  struct Mimic {
    std::string joint;
    double multiplier = 1.0;
    double offset = 0.0;
  };
  std::optional<Mimic> mimic;
};

/// Index of the tool link: `wanted` by name, or the tip of the chain with the most joints that move. Throws ModelError
/// (beginning with `path`) when it does not exist or when several chains qualify. Adds a note when it chose.
[[nodiscard]] int find_tool_link(const std::vector<TreeLink>& tree, const std::string& wanted, const std::string& path,
                                 std::vector<std::string>& notes);

/// Numbers the moving joints from the root to `tool` base to tip (Link::joint), and freezes all others in their zero
/// position, or the nearest limit, as fixed joints, with a note each. Returns the chain's link indices, base to tip.
/// Throws ModelError for a chain without moving joints, with more than kMaxJoints, or coupled by mimic joints.
[[nodiscard]] std::vector<int> number_chain(std::vector<TreeLink>& tree, int tool, const std::string& path,
                                            std::vector<std::string>& notes);

/// Throws ModelError naming the first body (a link moved by a chain joint, with all that is rigidly attached to it)
/// that has no collision geometry, and then the `remedy`; with `allow`, adds notes instead.
void check_bare_links(const std::vector<TreeLink>& tree, bool allow, const std::string& remedy, const std::string& path,
                      std::vector<std::string>& notes);

}  // namespace hecaton::planner
