#include "planner/model/srdf.hpp"

#include <algorithm>
#include <set>
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
    for (const auto* e = robot->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string_view kind = e->Name();
      if (kind == "disable_collisions") disabled_.insert(link_pair(*e));
      if (kind == "enable_collisions") enabled_.insert(link_pair(*e));
      if (kind == "disable_default_collisions") default_off_.insert(link_index(*e, "link"));
      if (kind == "group_state") add_group_state(*e);
    }
    std::erase_if(model_.self_pairs, [&](const auto& pair) {
      return is_disabled(model_.geometry[pair.first].link, model_.geometry[pair.second].link);
    });
  }

 private:
  void note(const std::string& sentence) { model_.notes.push_back(path_ + ": " + sentence); }

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
};

}  // namespace

std::string srdf_tool_link(const std::string& path, const std::string& base_link, SourceFiles& sources) {
  tinyxml2::XMLDocument document;
  load_xml(path, "SRDF", document, sources);
  std::set<std::string> carriers;
  std::set<std::string> tips;
  const XMLElement* robot = document.RootElement();
  for (const auto* e = robot == nullptr ? nullptr : robot->FirstChildElement(); e != nullptr;
       e = e->NextSiblingElement()) {
    const char* parent = e->Attribute("parent_link");
    if (std::string_view(e->Name()) == "end_effector" && parent != nullptr) carriers.insert(parent);
    if (std::string_view(e->Name()) != "group") continue;
    for (const auto* chain = e->FirstChildElement("chain"); chain != nullptr;
         chain = chain->NextSiblingElement("chain")) {
      const char* base = chain->Attribute("base_link");
      const char* tip = chain->Attribute("tip_link");
      if (tip != nullptr && (base_link.empty() || (base != nullptr && base == base_link))) tips.insert(tip);
    }
  }
  if (base_link.empty() && carriers.size() == 1) return *carriers.begin();
  return tips.size() == 1 ? *tips.begin() : std::string();
}

void apply_srdf(const std::string& path, const std::set<std::string>& left_out, RobotModel& model,
                SourceFiles& sources) {
  SrdfReader(path, left_out, model, sources).apply();
}

}  // namespace hecaton::planner
