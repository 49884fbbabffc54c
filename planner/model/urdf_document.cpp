#include "planner/model/urdf_document.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <tinyxml2.h>

#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

using tinyxml2::XMLElement;
using tinyxml2::XMLNode;

constexpr double kFurthest = 1000.0;  // of any part of an arm [m]; larger values are in a wrong unit

class UrdfChecker {
 public:
  UrdfChecker(std::string path, SourceFiles& sources) : path_(std::move(path)) {
    load_xml(path_, "URDF", document_, sources);
  }

  std::string checked_text() {
    XMLElement* robot = document_.RootElement();
    if (robot == nullptr || std::string_view(robot->Name()) != "robot") {
      fail("the root element is " + in_quotes(robot == nullptr ? "" : robot->Name()) + "; a URDF's is <robot>");
    }
    refuse_xacro(*robot);
    if (robot->Attribute("name") == nullptr || *robot->Attribute("name") == '\0') {
      fail("<robot> has no name; a URDF must name its robot");
    }
    keep(*robot, {"link", "joint"});
    check_links(*robot);
    check_joints(*robot);
    check_tree();
    tinyxml2::XMLPrinter printer;
    robot->Accept(&printer);
    return printer.CStr();
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const { throw ModelError(path_ + ": " + sentence); }

  void refuse_xacro(const XMLElement& element) const {
    const auto refuse = [&](const std::string& what) {
      fail(what + " is xacro, not plain URDF; expand the file first (xacro in.xacro > out.urdf)");
    };
    if (std::string_view(element.Name()).starts_with("xacro:")) refuse("<" + std::string(element.Name()) + ">");
    for (const auto* attribute = element.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
      const std::string_view value = attribute->Value();
      if (value.find("${") != value.npos || value.find("$(") != value.npos) {
        refuse(std::string(attribute->Name()) + " = " + in_quotes(attribute->Value()));
      }
    }
    for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      refuse_xacro(*child);
    }
  }

  /// Deletes all children except the named elements.
  static void keep(XMLElement& element, const std::set<std::string_view>& names) {
    for (XMLNode* node = element.FirstChild(); node != nullptr;) {
      XMLNode* next = node->NextSibling();
      if (node->ToElement() == nullptr || !names.contains(node->Value())) element.DeleteChild(node);
      node = next;
    }
  }

  /// Numbers that the planner does not use must be finite too: a NaN inertia shows that the file is broken.
  static void check_numbers(const XMLElement& element, const std::string& where) {
    constexpr std::array kTriples{"xyz", "rpy", "size", "scale"};
    constexpr std::array kScalars{"radius", "length", "lower", "upper", "velocity", "effort", "multiplier",
                                  "offset", "ixx",    "ixy",   "ixz",   "iyy",      "iyz",    "izz"};
    for (const char* name : kTriples) {
      if (element.Attribute(name) != nullptr) std::ignore = number_attribute(element, name, 3, where);
    }
    for (const char* name : kScalars) {
      if (element.Attribute(name) != nullptr) std::ignore = number_attribute(element, name, 1, where);
    }
    if (std::string_view(element.Name()) == "mass" && element.Attribute("value") != nullptr) {
      std::ignore = number_attribute(element, "value", 1, where);
    }
    for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      check_numbers(*child, where);
    }
  }

  static void check_origin(const XMLElement& element, const std::string& where) {
    const XMLElement* origin = element.FirstChildElement("origin");
    if (origin == nullptr || origin->Attribute("xyz") == nullptr) return;
    for (const double value : number_attribute(*origin, "xyz", 3, where)) {
      if (std::abs(value) > kFurthest) {
        throw ModelError(where + ": origin xyz = " + in_quotes(origin->Attribute("xyz")) + " must lie within 1000 m");
      }
    }
  }

  static void check_sizes(const XMLElement& shape, const char* name, int count, const std::string& where) {
    for (const double value : number_attribute(shape, name, count, where)) {
      if (value > 0.0 && value <= kFurthest) continue;
      throw ModelError(where + ": " + shape.Name() + " " + name + " = " + in_quotes(shape.Attribute(name)) +
                       " must be above 0 and at most 1000 m");
    }
  }

  static void check_collision(const XMLElement& collision, const std::string& where) {
    check_origin(collision, where);
    const XMLElement* geometry = collision.FirstChildElement("geometry");
    const XMLElement* shape = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (shape == nullptr) throw ModelError(where + " has no shape; box, cylinder, sphere and mesh are allowed");
    const std::string_view kind = shape->Name();
    if (kind == "box") {
      check_sizes(*shape, "size", 3, where);
    } else if (kind == "cylinder") {
      check_sizes(*shape, "radius", 1, where);
      check_sizes(*shape, "length", 1, where);
    } else if (kind == "sphere") {
      check_sizes(*shape, "radius", 1, where);
    } else if (kind == "mesh") {
      std::ignore = text_attribute(*shape, "filename", where);
      if (shape->Attribute("scale") == nullptr) return;
      for (const double factor : number_attribute(*shape, "scale", 3, where)) {
        if (factor == 0.0) {
          throw ModelError(where + ": mesh scale = " + in_quotes(shape->Attribute("scale")) + " must not hold a 0");
        }
      }
    } else {
      throw ModelError(where + ": shape " + in_quotes(shape->Name()) +
                       " is unknown; box, cylinder, sphere and mesh are allowed");
    }
  }

  void check_links(XMLElement& robot) {
    for (XMLElement* link = robot.FirstChildElement("link"); link != nullptr; link = link->NextSiblingElement("link")) {
      const std::string name = text_attribute(*link, "name", path_);
      const std::string where = path_ + ": link " + in_quotes(name);
      if (!links_.insert(name).second) throw ModelError(where + " exists twice; link names must be unique");
      check_numbers(*link, where);
      keep(*link, {"collision"});
      for (XMLElement* collision = link->FirstChildElement(); collision != nullptr;
           collision = collision->NextSiblingElement()) {
        check_collision(*collision, where + ", collision");
        keep(*collision, {"origin", "geometry"});
      }
    }
    if (links_.empty()) fail("the robot has no links; at least a base and one moving link are needed");
  }

  std::string link_reference(const XMLElement& joint, const char* role, const std::string& where) const {
    const XMLElement* element = joint.FirstChildElement(role);
    if (element == nullptr) throw ModelError(where + " has no <" + role + " link=…>");
    std::string link = text_attribute(*element, "link", where);
    if (!links_.contains(link)) {
      throw ModelError(where + ": its " + role + " link " + in_quotes(link) + " does not exist in this file");
    }
    return link;
  }

  static void check_axis(const XMLElement& joint, const std::string& where) {
    const XMLElement* axis = joint.FirstChildElement("axis");
    if (axis == nullptr) return;  // URDF's default: x
    const std::vector<double> xyz = number_attribute(*axis, "xyz", 3, where);
    const double length = std::hypot(xyz[0], xyz[1], xyz[2]);
    if (!(length > 1e-6) || length > 1e6) {
      throw ModelError(where + ": axis xyz = " + in_quotes(axis->Attribute("xyz")) +
                       " must be a direction, best a unit vector");
    }
  }

  static void check_limit(XMLElement& joint, bool has_range, const std::string& where) {
    XMLElement* limit = joint.FirstChildElement("limit");
    if (limit == nullptr) {
      if (has_range) throw ModelError(where + " has no <limit>; revolute and prismatic joints need lower and upper");
      return;
    }
    if (has_range) {
      for (const char* name : {"lower", "upper"}) {
        if (limit->Attribute(name) == nullptr) limit->SetAttribute(name, "0");  // URDF's default
      }
      if (!(number_attribute(*limit, "lower", 1, where)[0] < number_attribute(*limit, "upper", 1, where)[0])) {
        throw ModelError(where + ": limit lower = " + in_quotes(limit->Attribute("lower")) +
                         " must be below upper = " + in_quotes(limit->Attribute("upper")));
      }
    }
    for (const char* name : {"effort", "velocity"}) {
      if (limit->Attribute(name) == nullptr) limit->SetAttribute(name, "0");
    }
    if (number_attribute(*limit, "velocity", 1, where)[0] < 0.0) {
      throw ModelError(where + ": limit velocity = " + in_quotes(limit->Attribute("velocity")) + " must be above 0");
    }
  }

  /// A drive with a safety controller stays within its soft limits, therefore plans must, too.
  static void apply_soft_limits(XMLElement& joint, const std::string& where) {
    const XMLElement* safety = joint.FirstChildElement("safety_controller");
    XMLElement* limit = joint.FirstChildElement("limit");
    if (safety == nullptr || safety->Attribute("soft_lower_limit") == nullptr ||
        safety->Attribute("soft_upper_limit") == nullptr) {
      return;
    }
    const double soft_lower = number_attribute(*safety, "soft_lower_limit", 1, where)[0];
    const double soft_upper = number_attribute(*safety, "soft_upper_limit", 1, where)[0];
    const double lower = std::max(soft_lower, number_attribute(*limit, "lower", 1, where)[0]);
    const double upper = std::min(soft_upper, number_attribute(*limit, "upper", 1, where)[0]);
    if (!(lower < upper)) {
      throw ModelError(where +
                       ": safety_controller soft_lower_limit = " + in_quotes(safety->Attribute("soft_lower_limit")) +
                       " and soft_upper_limit = " + in_quotes(safety->Attribute("soft_upper_limit")) +
                       " must leave a part of the joint's range");
    }
    if (soft_lower == lower) limit->SetAttribute("lower", safety->Attribute("soft_lower_limit"));
    if (soft_upper == upper) limit->SetAttribute("upper", safety->Attribute("soft_upper_limit"));
  }

  void check_joint(XMLElement& joint, const std::string& name) {
    const std::string where = path_ + ": joint " + in_quotes(name);
    const std::string type = text_attribute(joint, "type", where);
    if (type != "revolute" && type != "continuous" && type != "prismatic" && type != "fixed") {
      throw ModelError(where + ": type = " + in_quotes(type) + " must be revolute, continuous, prismatic or fixed");
    }
    const std::string parent = link_reference(joint, "parent", where);
    const std::string child = link_reference(joint, "child", where);
    const auto [other, is_first] = carried_by_.try_emplace(child, name);
    if (!is_first) {
      throw ModelError(where + ": its child link " + in_quotes(child) + " is already the child of joint " +
                       in_quotes(other->second) + "; a link has one parent");
    }
    children_[parent].push_back(child);
    check_numbers(joint, where);
    check_origin(joint, where);
    if (type == "fixed") {
      keep(joint, {"parent", "child", "origin"});
      return;
    }
    check_axis(joint, where);
    check_limit(joint, type != "continuous", where);
    if (type != "continuous") apply_soft_limits(joint, where);
    keep(joint, {"parent", "child", "origin", "axis", "limit", "mimic"});
    if (const XMLElement* mimic = joint.FirstChildElement("mimic")) {
      mimics_.emplace_back(where, text_attribute(*mimic, "joint", where));
    }
  }

  void check_joints(XMLElement& robot) {
    for (XMLElement* joint = robot.FirstChildElement("joint"); joint != nullptr;
         joint = joint->NextSiblingElement("joint")) {
      const std::string name = text_attribute(*joint, "name", path_);
      if (!joints_.insert(name).second) fail("joint " + in_quotes(name) + " exists twice; joint names must be unique");
      check_joint(*joint, name);
    }
    for (const auto& [where, mimicked] : mimics_) {
      if (!joints_.contains(mimicked)) {
        throw ModelError(where + ": it mimics joint " + in_quotes(mimicked) + ", which does not exist in this file");
      }
    }
  }

  void check_tree() const {
    std::vector<std::string> reached;
    for (const std::string& link : links_) {
      if (!carried_by_.contains(link)) reached.push_back(link);
    }
    if (reached.size() > 1) {
      fail("links " + in_quotes(reached[0]) + " and " + in_quotes(reached[1]) +
           " both have no parent; a robot has one root link, from which joints lead to all others");
    }
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const auto children = children_.find(reached[i]);
      if (children != children_.end()) reached.insert(reached.end(), children->second.begin(), children->second.end());
    }
    const std::set<std::string> tree(reached.begin(), reached.end());
    for (const std::string& link : links_) {
      if (!tree.contains(link))
        fail("link " + in_quotes(link) + " is part of a loop of joints; joints must form a tree");
    }
  }

  std::string path_;
  tinyxml2::XMLDocument document_;
  std::set<std::string> links_;
  std::set<std::string> joints_;
  std::map<std::string, std::string> carried_by_;  // child link → joint
  std::map<std::string, std::vector<std::string>> children_;
  std::vector<std::pair<std::string, std::string>> mimics_;  // where, mimicked joint
};

}  // namespace

std::string read_urdf_document(const std::string& path, SourceFiles& sources) {
  return UrdfChecker(path, sources).checked_text();
}

}  // namespace hecaton::planner
