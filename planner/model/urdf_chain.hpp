#pragma once
/// The chain of joints from a URDF's root to its tool, which the planner moves. Works on plain values, without urdfdom.

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

/// Index of the tool link named `wanted`. If that is empty, takes the tip of the chain with the most moving joints and
/// adds a note. Throws ModelError (beginning with `path`) when the link does not exist or several chains qualify.
[[nodiscard]] int find_tool_link(const std::vector<TreeLink>& tree, const std::string& wanted, const std::string& path,
                                 std::vector<std::string>& notes);

/// Numbers the moving joints from the root to `tool` (Link::joint). All other joints become fixed ones at their zero
/// position, or the nearest limit, with a note each. Returns the chain's link indices, base to tip. Throws ModelError
/// for a chain without moving joints, with more than kMaxJoints, or coupled by mimic joints.
[[nodiscard]] std::vector<int> number_chain(std::vector<TreeLink>& tree, int tool, const std::string& path,
                                            std::vector<std::string>& notes);

/// Throws ModelError for the first body without collision geometry; a body is a link that a chain joint moves, with all
/// links fixed to it. `remedy` ends the sentence. With `allow`, adds notes instead.
void check_bare_links(const std::vector<TreeLink>& tree, bool allow, const std::string& remedy, const std::string& path,
                      std::vector<std::string>& notes);

}  // namespace hecaton::planner
