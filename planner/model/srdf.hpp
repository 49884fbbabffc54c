#pragma once
/// SRDF, MoveIt's semantic robot description: link pairs that need no check, and named configurations.

#include <set>
#include <string>
#include <vector>

#include "planner/model/robot_model.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/urdf_chain.hpp"

namespace hecaton::planner {

/// Removes the pairs that the SRDF at `path` disables from model.self_pairs (disable_collisions, and
/// disable_default_collisions without enable_collisions). Adds group_states that set every joint within its limits to
/// model.named. Skips entries with unknown links, and states that set some joints of the chain but not all, with a
/// note. `left_out`: links of the URDF that the model does not have; entries with them are skipped without a note.
/// One more note lists the elements that Hecaton does not use, such as virtual_joint. Throws ModelError when the file
/// is no SRDF.
void apply_srdf(const std::string& path, const std::set<std::string>& left_out, RobotModel& model,
                SourceFiles& sources);

/// The tool link according to the SRDF: the link that carries its only end effector, else the tip of its only group
/// that is a chain. A group has also what its subgroups have; groups in such a group do not count. Without a group with
/// <chain>, groups of <joint> and <link> count that are a chain with at least two moving joints. With `base_link`, only
/// groups from this link count. Empty if it names none or several. Throws ModelError when the file is no SRDF.
[[nodiscard]] std::string srdf_tool_link(const std::string& path, const std::vector<TreeLink>& tree,
                                         const std::string& base_link, SourceFiles& sources);

}  // namespace hecaton::planner
