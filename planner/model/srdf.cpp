#include "planner/model/srdf.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tinyxml2.h>

#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

using tinyxml2::XMLElement;
using LinkPair = std::pair<int, int>;  // sorted

/// Elements of <robot> that Hecaton uses.
constexpr std::array<std::string_view, 6> kUsedElements = {
    "group", "group_state", "end_effector", "disable_collisions", "enable_collisions", "disable_default_collisions"};

/// Groups in groups that are followed.
constexpr std::size_t kMostNested = 64;

/// Calls visit with each child element of this name.
template <typename Visit>
void for_each_child(const XMLElement& parent, const char* name, Visit visit) {
  for (const auto* e = parent.FirstChildElement(name); e != nullptr; e = e->NextSiblingElement(name)) visit(*e);
}

std::string text_or_empty(const XMLElement& element, const char* attribute) {
  const char* text = element.Attribute(attribute);
  return text == nullptr ? "" : text;
}

class SrdfReader {
 public:
  SrdfReader(const std::string& path, const std::set<std::string>& left_out, RobotModel& model, SourceFiles& sources)
      : path_(path), model_(model), unknown_(left_out) {
    load_xml(path_, "SRDF", document_, sources);
  }

  void apply() {
    const XMLElement* robot = document_.RootElement();
    if (robot == nullptr || std::string_view(robot->Name()) != "robot") {
      throw ModelError(path_ + ": the root element is " + in_quotes(robot == nullptr ? "" : robot->Name()) +
                       "; an SRDF's is <robot>");
    }
    if (const char* name = robot->Attribute("name"); name != nullptr && name != model_.name) {
      note("it describes robot " + in_quotes(name) + ", the URDF robot " + in_quotes(model_.name));
    }
    for_each_child(*robot, "group", [&](const XMLElement& group) { groups_.insert(text_or_empty(group, "name")); });
    for (const auto* e = robot->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string_view kind = e->Name();
      if (kind == "disable_collisions") disabled_.insert(link_pair(*e));
      if (kind == "enable_collisions") enabled_.insert(link_pair(*e));
      if (kind == "disable_default_collisions") default_off_.insert(link_index(*e, "link"));
      if (kind == "group_state") add_group_state(*e);
      if (kind == "group") note_unknown_subgroups(*e);
      if (std::find(kUsedElements.begin(), kUsedElements.end(), kind) == kUsedElements.end()) note_unused(*e);
    }
    note_all_unused();
    std::erase_if(model_.self_pairs, [&](const auto& pair) {
      return is_disabled(model_.geometry[pair.first].link, model_.geometry[pair.second].link);
    });
  }

 private:
  void note(const std::string& sentence) { model_.notes.push_back(path_ + ": " + sentence); }

  void note_unknown_subgroups(const XMLElement& group) {
    for_each_child(group, "group", [&](const XMLElement& subgroup) {
      const std::string name = text_or_empty(subgroup, "name");
      if (groups_.contains(name)) return;
      note("group " + in_quotes(name) + " in group " + in_quotes(text_or_empty(group, "name")) +
           " does not exist and is skipped");
    });
  }

  /// A passive joint has no drive, but the planner moves each joint on the way to the tool.
  void note_unused(const XMLElement& element) {
    ++unused_[element.Name()];
    const std::string joint = text_or_empty(element, "name");
    const auto& moved = model_.joint_names;
    if (std::string_view(element.Name()) != "passive_joint" ||
        std::find(moved.begin(), moved.end(), joint) == moved.end()) {
      return;
    }
    note("joint " + in_quotes(joint) + " is passive, but moves the tool: it is planned as if it had a drive");
  }

  void note_all_unused() {
    std::string all;
    for (const auto& [element, count] : unused_) {
      all += (all.empty() ? "" : ", ") + in_quotes(element);
      if (count > 1) all += " (" + std::to_string(count) + ")";
    }
    if (!all.empty()) note("elements that are not used: " + all);
  }

  /// −1, with a note, when the model has no such link.
  int link_index(const XMLElement& element, const char* attribute) {
    const std::string name = text_attribute(element, attribute, path_);
    const auto found =
        std::find_if(model_.links.begin(), model_.links.end(), [&](const Link& link) { return link.name == name; });
    if (found != model_.links.end()) return static_cast<int>(found - model_.links.begin());
    if (unknown_.insert(name).second) note("link " + in_quotes(name) + " does not exist in the URDF and is skipped");
    return -1;
  }

  LinkPair link_pair(const XMLElement& element) {
    const int a = link_index(element, "link1");
    const int b = link_index(element, "link2");
    return {std::min(a, b), std::max(a, b)};
  }

  [[nodiscard]] bool is_disabled(int a, int b) const {
    const LinkPair pair{std::min(a, b), std::max(a, b)};
    if (disabled_.contains(pair)) return true;
    return (default_off_.contains(a) || default_off_.contains(b)) && !enabled_.contains(pair);
  }

  void add_group_state(const XMLElement& state) {
    const std::string name = text_attribute(state, "name", path_);
    const std::string where = path_ + ": group_state " + in_quotes(name);
    JointVector q = JointVector::Zero(model_.joints());
    std::vector<bool> set(model_.joint_names.size(), false);
    for (const auto* joint = state.FirstChildElement("joint"); joint != nullptr;
         joint = joint->NextSiblingElement("joint")) {
      const std::string joint_name = text_attribute(*joint, "name", where);
      const auto found = std::find(model_.joint_names.begin(), model_.joint_names.end(), joint_name);
      if (found == model_.joint_names.end()) continue;  // joints outside the chain, such as a gripper's
      const auto index = found - model_.joint_names.begin();
      q[index] = number_attribute(*joint, "value", 1, where)[0];
      set[index] = true;
      if (!(q[index] >= model_.limits.lower[index] && q[index] <= model_.limits.upper[index])) {
        note("group_state " + in_quotes(name) + " is skipped: joint " + in_quotes(joint_name) + " = " +
             std::to_string(q[index]) + " is outside its limits");
        return;
      }
    }
    // The state of another group, such as a gripper's.
    if (!set.empty() && std::find(set.begin(), set.end(), true) == set.end()) return;
    if (std::find(set.begin(), set.end(), false) != set.end()) {
      note("group_state " + in_quotes(name) + " is skipped: it does not set every joint that moves the tool");
      return;
    }
    if (!model_.named.emplace(name, q).second)
      note("group_state " + in_quotes(name) + " exists twice; the first counts");
  }

  const std::string& path_;
  RobotModel& model_;
  tinyxml2::XMLDocument document_;
  std::set<LinkPair> disabled_;
  std::set<LinkPair> enabled_;
  std::set<int> default_off_;
  std::set<std::string> unknown_;  ///< links without need for a note
  std::set<std::string> groups_;
  std::map<std::string, int> unused_;  ///< elements: how many
};

/// The groups of an SRDF, as sets of links of the URDF's tree.
class SrdfGroups {
 public:
  SrdfGroups(const XMLElement& robot, const std::vector<TreeLink>& tree) : tree_(tree) {
    for_each_child(robot, "group", [&](const XMLElement& group) {
      elements_.emplace(text_or_empty(group, "name"), &group);  // of equal names the first counts
    });
    for (const auto& [name, element] : elements_) {
      Group& group = groups_[name];
      std::set<std::string> path{name};
      collect(*element, path, group);
    }
  }

  /// Tips of groups that are a chain; see srdf_tool_link().
  [[nodiscard]] std::set<std::string> tips(const std::string& base_link) const {
    const std::set<std::string> parts = parts_of_chains();
    for (const bool with_chain : {true, false}) {
      std::set<std::string> tips;
      for (const auto& [name, group] : groups_) {
        if (!(with_chain ? ends_in_a_chain(group) : is_list(group)) || parts.contains(name)) continue;
        if (base_link.empty() || begins_at(group, base_link)) tips.insert(tree_[*group.links.rbegin()].link.name);
      }
      if (!tips.empty()) return tips;
    }
    return {};
  }

 private:
  struct Group {
    std::set<int> links;  ///< that its joints carry, and that it lists; parents have smaller indices
    std::set<std::string> subgroups;
    std::set<int> chain_tips;  ///< of its <chain> elements
  };

  void collect(const XMLElement& element, std::set<std::string>& path, Group& group) const {
    for_each_child(element, "link",
                   [&](const XMLElement& e) { add(index_of_link(tree_, text_or_empty(e, "name")), group); });
    for_each_child(element, "joint", [&](const XMLElement& e) {
      const std::string name = text_or_empty(e, "name");
      for (std::size_t i = 1; i < tree_.size(); ++i) {
        if (tree_[i].link.joint_name == name) add(static_cast<int>(i), group);
      }
    });
    for_each_child(element, "chain", [&](const XMLElement& e) {
      const int base = index_of_link(tree_, text_or_empty(e, "base_link"));
      int i = index_of_link(tree_, text_or_empty(e, "tip_link"));
      if (i >= 0) group.chain_tips.insert(i);
      for (; i > base; i = tree_[i].link.parent) add(i, group);
    });
    for_each_child(element, "group", [&](const XMLElement& e) {
      const std::string name = text_or_empty(e, "name");
      const auto found = elements_.find(name);
      // A group may be part of itself.
      if (found == elements_.end() || path.size() > kMostNested || !path.insert(name).second) return;
      group.subgroups.insert(name);
      collect(*found->second, path, group);
    });
  }

  static void add(int link, Group& group) {
    if (link >= 0) group.links.insert(link);
  }

  /// True if all links are on one way from the root.
  [[nodiscard]] bool is_chain(const Group& group) const {
    if (group.links.empty()) return false;
    std::size_t on_way = 0;
    for (int i = *group.links.rbegin(); i >= 0; i = tree_[i].link.parent) on_way += group.links.count(i);
    return on_way == group.links.size();
  }

  /// The end of such a group is a tip_link, not a link of a gripper in it.
  [[nodiscard]] bool ends_in_a_chain(const Group& group) const {
    return is_chain(group) && group.chain_tips.contains(*group.links.rbegin());
  }

  /// A chain by its joints and links alone. One moving joint is a gripper's finger.
  [[nodiscard]] bool is_list(const Group& group) const {
    const auto moves = [&](int i) { return tree_[i].link.joint_type != JointType::kFixed; };
    return group.chain_tips.empty() && is_chain(group) &&
           std::count_if(group.links.begin(), group.links.end(), moves) >= 2;
  }

  /// Groups that are part of a group that is a chain.
  [[nodiscard]] std::set<std::string> parts_of_chains() const {
    std::set<std::string> parts;
    for (const auto& [name, group] : groups_) {
      if (ends_in_a_chain(group) || is_list(group)) parts.insert(group.subgroups.begin(), group.subgroups.end());
    }
    return parts;
  }

  [[nodiscard]] bool begins_at(const Group& group, const std::string& base_link) const {
    const int parent = tree_[*group.links.begin()].link.parent;
    return parent >= 0 && tree_[parent].link.name == base_link;
  }

  const std::vector<TreeLink>& tree_;
  std::map<std::string, const XMLElement*> elements_;
  std::map<std::string, Group> groups_;
};

}  // namespace

std::string srdf_tool_link(const std::string& path, const std::vector<TreeLink>& tree, const std::string& base_link,
                           SourceFiles& sources) {
  tinyxml2::XMLDocument document;
  load_xml(path, "SRDF", document, sources);
  const XMLElement* robot = document.RootElement();
  if (robot == nullptr) return {};
  std::set<std::string> carriers;
  for_each_child(*robot, "end_effector", [&](const XMLElement& e) {
    if (e.Attribute("parent_link") != nullptr) carriers.insert(text_or_empty(e, "parent_link"));
  });
  if (base_link.empty() && carriers.size() == 1) return *carriers.begin();
  const std::set<std::string> tips = SrdfGroups(*robot, tree).tips(base_link);
  return tips.size() == 1 ? *tips.begin() : std::string();
}

void apply_srdf(const std::string& path, const std::set<std::string>& left_out, RobotModel& model,
                SourceFiles& sources) {
  SrdfReader(path, left_out, model, sources).apply();
}

}  // namespace hecaton::planner
