#include "planner/model/urdf_document.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <tinyxml2.h>

#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

using tinyxml2::XMLElement;
using tinyxml2::XMLNode;

constexpr double kFurthest = 1000.0;  // of any part of an arm [m]; larger values are in a wrong unit
constexpr double kThinnest = 1e-3;    // stands for a size of 0 of a shape that has other sizes [m]

bool is_xacro(std::string_view text) {
  return text.find("${") != text.npos || text.find("$(") != text.npos;
}

bool is_one_of(const XMLElement& element, const std::set<std::string_view>& names) {
  return names.contains(element.Name());
}

/// The first part of the element that is xacro, as words for a sentence. Leaves out children named in `unused`.
std::optional<std::string> xacro_in(const XMLElement& element, const std::set<std::string_view>& unused = {}) {
  if (std::string_view(element.Name()).starts_with("xacro:")) return "<" + std::string(element.Name()) + ">";
  for (const auto* attribute = element.FirstAttribute(); attribute != nullptr; attribute = attribute->Next()) {
    if (is_xacro(attribute->Value())) return std::string(attribute->Name()) + " = " + in_quotes(attribute->Value());
  }
  for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
    if (is_one_of(*child, unused)) continue;
    if (auto found = xacro_in(*child)) return found;
  }
  return std::nullopt;
}

/// The first part of the robot that is xacro and that the planner needs.
std::optional<std::string> needed_xacro(const XMLElement& robot) {
  for (const auto* child = robot.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
    std::optional<std::string> found;
    if (is_one_of(*child, {"link"})) {
      found = xacro_in(*child, {"visual", "inertial", "material", "gazebo"});
    } else if (is_one_of(*child, {"joint"})) {
      found = xacro_in(*child, {"dynamics", "calibration", "hardwareInterface"});
    } else if (std::string_view(child->Name()).starts_with("xacro:")) {
      found = xacro_in(*child);
    }
    if (found) return found;
  }
  return std::nullopt;
}

class UrdfChecker {
 public:
  UrdfChecker(std::string path, SourceFiles& sources, const XacroOptions& xacro) : path_(std::move(path)) {
    load_xml(path_, "URDF", document_, sources);
    expand(sources, xacro);
  }

  UrdfDocument checked() {
    XMLElement& robot = root();
    if (xacro_in(robot) && !needed_xacro(robot)) {
      note("parts that the planner does not use have xacro text that is not expanded");
    }
    name_robot(robot);
    keep(robot, {"link", "joint"});
    check_links(robot);
    check_joints(robot);
    check_tree();
    tinyxml2::XMLPrinter printer;
    robot.Accept(&printer);
    result_.text = printer.CStr();
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const { throw ModelError(path_ + ": " + sentence); }
  void note(const std::string& sentence) { result_.notes.push_back(sentence); }

  XMLElement& root() {
    XMLElement* robot = document_.RootElement();
    if (robot == nullptr || std::string_view(robot->Name()) != "robot") {
      fail("the root element is " + in_quotes(robot == nullptr ? "" : robot->Name()) + "; a URDF's is <robot>");
    }
    return *robot;
  }

  /// Replaces a document whose links or joints are xacro by what the program `xacro` makes of the file.
  void expand(SourceFiles& sources, const XacroOptions& xacro) {
    const auto found = needed_xacro(root());
    if (!found) {
      if (!xacro.arguments.empty()) note("the file is plain URDF; the arguments for xacro have no effect");
      return;
    }
    const auto text = expand_xacro(path_, sources, xacro);
    if (!text) {
      fail(*found +
           " is xacro, not plain URDF; install the program xacro and put it on the PATH, or expand the file first "
           "(xacro in.xacro > out.urdf)");
    }
    sources.keep_as(path_, *text);
    parse_xml(*text, path_, "URDF", document_);
    const auto left = needed_xacro(root());
    if (left) fail(*left + " is xacro that the program xacro left as it was; correct the file");
    note("the program xacro expanded the file" +
         (xacro.arguments_option.empty() ? "" : "; " + xacro.arguments_option + " gives it arguments"));
  }

  void name_robot(XMLElement& robot) {
    const char* name = robot.Attribute("name");
    if (name != nullptr && *name != '\0') return;
    const std::string stem = std::filesystem::path(path_).stem().string();
    robot.SetAttribute("name", stem.c_str());
    note("the robot has no name; it is called " + in_quotes(stem) + ", after its file");
  }

  /// The planner needs no masses: an <inertial> that is incomplete or xacro is none.
  void read_mass(const XMLElement& link, const std::string& name) {
    const XMLElement* inertial = link.FirstChildElement("inertial");
    const XMLElement* mass = inertial == nullptr ? nullptr : inertial->FirstChildElement("mass");
    const XMLElement* moments = inertial == nullptr ? nullptr : inertial->FirstChildElement("inertia");
    const double kilograms = mass == nullptr ? 0.0 : number_of(*mass, "value").value_or(0.0);
    if (!(kilograms > 0.0) || moments == nullptr) return;
    const auto moment = [&](const char* attribute) { return number_of(*moments, attribute).value_or(0.0); };
    Eigen::Matrix3d inertia;
    inertia << moment("ixx"), moment("ixy"), moment("ixz"), moment("ixy"), moment("iyy"), moment("iyz"), moment("ixz"),
        moment("iyz"), moment("izz");
    world::Pose X_LI = world::Pose::Identity();
    if (const XMLElement* origin = inertial->FirstChildElement("origin")) {
      if (xacro_in(*origin)) return;
      X_LI.translation() = triple_of(origin, "xyz", name);
      X_LI.linear() = rotation_of(triple_of(origin, "rpy", name));
    }
    result_.masses.push_back(body_mass(name, kilograms, X_LI, inertia));
  }

  /// Zero where the URDF says nothing.
  static Eigen::Vector3d triple_of(const XMLElement* element, const char* name, const std::string& where) {
    if (element == nullptr || element->Attribute(name) == nullptr) return Eigen::Vector3d::Zero();
    const auto numbers = number_attribute(*element, name, 3, where);
    return {numbers[0], numbers[1], numbers[2]};
  }

  static Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rpy) {
    return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
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
    const auto check = [&](const char* name, int count) {
      const char* text = element.Attribute(name);
      if (text != nullptr && !is_xacro(text)) std::ignore = number_attribute(element, name, count, where);
    };
    for (const char* name : kTriples) check(name, 3);
    for (const char* name : kScalars) check(name, 1);
    if (std::string_view(element.Name()) == "mass") check("value", 1);
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

  /// Sizes are at least 0. A shape without any size is left out: false. A size of 0 beside others becomes kThinnest.
  bool check_sizes(XMLElement& shape, std::initializer_list<std::pair<const char*, int>> sizes,
                   const std::string& where) {
    bool has_size = false;
    bool is_flat = false;
    for (const auto& [name, count] : sizes) {
      for (const double value : number_attribute(shape, name, count, where)) {
        if (!(value >= 0.0) || value > kFurthest) {
          throw ModelError(where + ": " + shape.Name() + " " + name + " = " + in_quotes(shape.Attribute(name)) +
                           " must be at least 0 and at most 1000 m");
        }
        has_size = has_size || value > 0.0;
        is_flat = is_flat || value == 0.0;
      }
    }
    const std::string sentence = where.substr(path_.size() + 2) + ": the " + shape.Name();
    if (!has_size) note(sentence + " has no size and is left out");
    if (!has_size || !is_flat) return has_size;
    for (const auto& [name, count] : sizes) {
      std::string text;
      for (const double value : number_attribute(shape, name, count, where)) {
        text += (text.empty() ? "" : " ") + exact_text(value == 0.0 ? kThinnest : value);
      }
      shape.SetAttribute(name, text.c_str());
    }
    note(sentence + " has a size of 0, which is taken as 1 mm");
    return true;
  }

  static std::string exact_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
  }

  /// False: the collision element is left out.
  bool check_collision(XMLElement& collision, const std::string& where) {
    check_origin(collision, where);
    XMLElement* geometry = collision.FirstChildElement("geometry");
    XMLElement* shape = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (shape == nullptr)
      throw ModelError(where + " has no shape; box, cylinder, sphere, capsule and mesh are allowed");
    const std::string_view kind = shape->Name();
    if (kind == "box") return check_sizes(*shape, {{"size", 3}}, where);
    if (kind == "cylinder") return check_sizes(*shape, {{"radius", 1}, {"length", 1}}, where);
    if (kind == "sphere") return check_sizes(*shape, {{"radius", 1}}, where);
    if (kind == "capsule") return check_capsule(collision, *shape, where);
    if (kind == "mesh") {
      std::ignore = text_attribute(*shape, "filename", where);
      if (shape->Attribute("scale") == nullptr) return true;
      for (const double factor : number_attribute(*shape, "scale", 3, where)) {
        if (factor == 0.0) {
          throw ModelError(where + ": mesh scale = " + in_quotes(shape->Attribute("scale")) + " must not hold a 0");
        }
      }
      return true;
    }
    throw ModelError(where + ": shape " + in_quotes(shape->Name()) +
                     " is unknown; box, cylinder, sphere, capsule and mesh are allowed");
  }

  /// urdfdom knows no capsules before version 4. Writes one as a cylinder with a sphere at the centre of each end.
  bool check_capsule(XMLElement& collision, XMLElement& capsule, const std::string& where) {
    const double radius = number_attribute(capsule, "radius", 1, where)[0];
    const double length = number_attribute(capsule, "length", 1, where)[0];
    if (!(radius > 0.0) || radius > kFurthest || !(length >= 0.0) || length > kFurthest) {
      throw ModelError(where + ": capsule radius = " + in_quotes(capsule.Attribute("radius")) + ", length = " +
                       in_quotes(capsule.Attribute("length")) + " must be above 0 and at least 0, and at most 1000 m");
    }
    const XMLElement* origin = collision.FirstChildElement("origin");
    const Eigen::Vector3d middle = triple_of(origin, "xyz", where);
    const Eigen::Vector3d axis = rotation_of(triple_of(origin, "rpy", where)).col(2);
    for (const double side : length > 0.0 ? std::vector<double>{-0.5, 0.5} : std::vector<double>{0.0}) {
      const Eigen::Vector3d centre = middle + side * length * axis;
      const std::string xyz = exact_text(centre.x()) + " " + exact_text(centre.y()) + " " + exact_text(centre.z());
      XMLElement* ball = collision.Parent()->ToElement()->InsertNewChildElement("collision");
      ball->InsertNewChildElement("origin")->SetAttribute("xyz", xyz.c_str());
      ball->InsertNewChildElement("geometry")
          ->InsertNewChildElement("sphere")
          ->SetAttribute("radius", exact_text(radius).c_str());
    }
    if (length == 0.0) return false;
    capsule.SetName("cylinder");
    return true;
  }

  /// True for shapes that the loader can read.
  static bool has_usable_shape(const XMLElement& visual) {
    const XMLElement* geometry = visual.FirstChildElement("geometry");
    const XMLElement* shape = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (shape == nullptr) return false;
    const std::string_view kind = shape->Name();
    if (kind != "mesh") return kind == "box" || kind == "cylinder" || kind == "sphere" || kind == "capsule";
    const char* file = shape->Attribute("filename");
    if (file == nullptr) return false;
    std::string suffix = std::filesystem::path(file).extension().string();
    std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
    return suffix == ".stl" || suffix == ".dae" || suffix == ".obj";
  }

  /// Visual shapes stand for collision shapes in a URDF in which no link has collision shapes.
  void adopt_visuals(XMLElement& robot) {
    std::vector<XMLElement*> visuals;
    for (XMLElement* link = robot.FirstChildElement("link"); link != nullptr; link = link->NextSiblingElement("link")) {
      if (link->FirstChildElement("collision") != nullptr) return;
      for (XMLElement* visual = link->FirstChildElement("visual"); visual != nullptr;
           visual = visual->NextSiblingElement("visual")) {
        if (!has_usable_shape(*visual)) return;
        visuals.push_back(visual);
      }
    }
    if (visuals.empty()) return;
    for (XMLElement* visual : visuals) visual->SetName("collision");
    note("no link has collision geometry: the visual geometry of all links stands for it");
  }

  void check_links(XMLElement& robot) {
    adopt_visuals(robot);
    for (XMLElement* link = robot.FirstChildElement("link"); link != nullptr; link = link->NextSiblingElement("link")) {
      const std::string name = text_attribute(*link, "name", path_);
      const std::string where = path_ + ": link " + in_quotes(name);
      if (!links_.insert(name).second) throw ModelError(where + " exists twice; link names must be unique");
      check_numbers(*link, where);
      read_mass(*link, name);
      keep(*link, {"collision"});
      for (XMLElement* collision = link->FirstChildElement(); collision != nullptr;) {
        XMLElement* next = collision->NextSiblingElement();
        if (check_collision(*collision, where + ", collision")) {
          keep(*collision, {"origin", "geometry"});
        } else {
          link->DeleteChild(collision);
        }
        collision = next;
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

  /// The number of an attribute; nothing if it is missing or no number.
  static std::optional<double> number_of(const XMLElement& element, const char* name) {
    double value = 0.0;
    if (element.QueryDoubleAttribute(name, &value) != tinyxml2::XML_SUCCESS || !std::isfinite(value)) return {};
    return value;
  }

  /// Limits that are equal, as generators of URDFs write for joints without a drive, mean that a follower has no range
  /// of its own; missing and unreadable ones are made equal. Exchanged limits are put in order.
  static void check_limit_of_follower(XMLElement& joint) {
    XMLElement* limit = joint.FirstChildElement("limit");
    if (limit == nullptr) limit = joint.InsertNewChildElement("limit");
    const auto lower = number_of(*limit, "lower");
    const auto upper = number_of(*limit, "upper");
    const auto velocity = number_of(*limit, "velocity");
    const bool has_range = lower && upper;
    limit->SetAttribute("lower", has_range ? exact_text(std::min(*lower, *upper)).c_str() : "0");
    limit->SetAttribute("upper", has_range ? exact_text(std::max(*lower, *upper)).c_str() : "0");
    if (!velocity || *velocity < 0.0) limit->SetAttribute("velocity", "0");
    limit->SetAttribute("effort", "0");
  }

  static void check_limit(XMLElement& joint, bool has_range, const std::string& where) {
    XMLElement* limit = joint.FirstChildElement("limit");
    if (limit == nullptr) {
      if (has_range) throw ModelError(where + " has no <limit>; revolute and prismatic joints need lower and upper");
      return;
    }
    if (has_range) {
      const bool is_given = limit->Attribute("lower") != nullptr && limit->Attribute("upper") != nullptr;
      for (const char* name : {"lower", "upper"}) {
        if (limit->Attribute(name) == nullptr) limit->SetAttribute(name, "0");  // URDF's default
      }
      const double lower = number_attribute(*limit, "lower", 1, where)[0];
      const double upper = number_attribute(*limit, "upper", 1, where)[0];
      const bool is_locked = is_given && lower == upper;
      if (!(lower < upper) && !is_locked) {
        throw ModelError(where + ": limit lower = " + in_quotes(limit->Attribute("lower")) +
                         " must be below upper = " + in_quotes(limit->Attribute("upper")));
      }
    }
    for (const char* name : {"effort", "velocity"}) {
      if (limit->Attribute(name) == nullptr) limit->SetAttribute(name, "0");
    }
    // Some files write -1 for an unknown limit: as if it were missing.
    if (number_attribute(*limit, "velocity", 1, where)[0] < 0.0) limit->SetAttribute("velocity", "0");
  }

  /// A drive with a safety controller stays within its soft limits, therefore plans must, too.
  void apply_soft_limits(XMLElement& joint, const std::string& where) {
    const XMLElement* safety = joint.FirstChildElement("safety_controller");
    XMLElement* limit = joint.FirstChildElement("limit");
    if (safety == nullptr || safety->Attribute("soft_lower_limit") == nullptr ||
        safety->Attribute("soft_upper_limit") == nullptr) {
      return;
    }
    const double soft_lower = number_attribute(*safety, "soft_lower_limit", 1, where)[0];
    const double soft_upper = number_attribute(*safety, "soft_upper_limit", 1, where)[0];
    const double hard_lower = number_attribute(*limit, "lower", 1, where)[0];
    const double hard_upper = number_attribute(*limit, "upper", 1, where)[0];
    // Some files write URDF's default, which leaves nothing: as if it were missing. A locked joint has no range.
    if ((soft_lower == 0.0 && soft_upper == 0.0) || hard_lower == hard_upper) return;
    const double lower = std::max(soft_lower, hard_lower);
    const double upper = std::min(soft_upper, hard_upper);
    if (!(lower < upper)) {
      throw ModelError(where +
                       ": safety_controller soft_lower_limit = " + in_quotes(safety->Attribute("soft_lower_limit")) +
                       " and soft_upper_limit = " + in_quotes(safety->Attribute("soft_upper_limit")) +
                       " must leave a part of the joint's range");
    }
    if (soft_lower == lower) limit->SetAttribute("lower", safety->Attribute("soft_lower_limit"));
    if (soft_upper == upper) limit->SetAttribute("upper", safety->Attribute("soft_upper_limit"));
    if (lower == hard_lower && upper == hard_upper) return;
    softened_ += (softened_.empty() ? "" : ", ") + in_quotes(joint.Attribute("name"));
  }

  /// Checks axis and limits of a joint that moves.
  void check_motion(XMLElement& joint, const std::string& type, const std::string& where) {
    check_numbers(joint, where);
    check_axis(joint, where);
    if (joint.FirstChildElement("mimic") != nullptr) {
      check_limit_of_follower(joint);
      return;
    }
    check_limit(joint, type != "continuous", where);
    if (type != "continuous") apply_soft_limits(joint, where);
  }

  void hold(XMLElement& joint) {
    joint.SetAttribute("type", "fixed");
    keep(joint, {"parent", "child", "origin"});
  }

  void check_joint(XMLElement& joint, const std::string& name) {
    const std::string where = path_ + ": joint " + in_quotes(name);
    const std::string type = text_attribute(joint, "type", where);
    const std::set<std::string_view> types{"revolute", "continuous", "prismatic", "fixed", "floating", "planar"};
    if (!types.contains(type)) {
      throw ModelError(where + ": type = " + in_quotes(type) +
                       " must be revolute, continuous, prismatic, fixed, floating or planar");
    }
    const std::string parent = link_reference(joint, "parent", where);
    const std::string child = link_reference(joint, "child", where);
    const auto [other, is_first] = carried_by_.try_emplace(child, name);
    if (!is_first) {
      throw ModelError(where + ": its child link " + in_quotes(child) + " is already the child of joint " +
                       in_quotes(other->second) + "; a link has one parent");
    }
    children_[parent].push_back(child);
    if (const XMLElement* origin = joint.FirstChildElement("origin")) check_numbers(*origin, where);
    check_origin(joint, where);
    if (type == "floating" || type == "planar") {
      note("joint " + in_quotes(name) + " is " + type + " and held in its zero position");
    }
    if (type == "fixed" || type == "floating" || type == "planar") {
      hold(joint);
      return;
    }
    const XMLElement* mimic = joint.FirstChildElement("mimic");
    if (mimic != nullptr) follows_[name] = text_attribute(*mimic, "joint", where);
    try {
      check_motion(joint, type, where);
      keep(joint, {"parent", "child", "origin", "axis", "limit", "mimic"});
    } catch (const ModelError& fault) {
      result_.faulty_joints[name] = fault.what();
      hold(joint);
    }
  }

  /// What is wrong with the joint that joint `name` follows; empty if following leads to a joint that follows none.
  [[nodiscard]] std::string fault_of_follower(const std::string& name) const {
    const std::string where =
        path_ + ": joint " + in_quotes(name) + ": it mimics joint " + in_quotes(follows_.at(name));
    std::string source = name;
    for (std::size_t hops = 0; follows_.contains(source); ++hops) {
      source = follows_.at(source);
      if (!joints_.contains(source))
        return where + ", which " + (hops == 0 ? "" : "leads to one that ") + "does not exist in this file";
      if (source == name || hops > follows_.size()) return where + " and so follows itself; it must follow another one";
    }
    return {};
  }

  void check_followers(XMLElement& robot) {
    for (XMLElement* joint = robot.FirstChildElement("joint"); joint != nullptr;
         joint = joint->NextSiblingElement("joint")) {
      const std::string name = text_attribute(*joint, "name", path_);
      if (!follows_.contains(name) || result_.faulty_joints.contains(name)) continue;
      const std::string fault = fault_of_follower(name);
      if (fault.empty()) continue;
      result_.faulty_joints[name] = fault;
      hold(*joint);
    }
  }

  void check_joints(XMLElement& robot) {
    for (XMLElement* joint = robot.FirstChildElement("joint"); joint != nullptr;
         joint = joint->NextSiblingElement("joint")) {
      const std::string name = text_attribute(*joint, "name", path_);
      if (!joints_.insert(name).second) fail("joint " + in_quotes(name) + " exists twice; joint names must be unique");
      check_joint(*joint, name);
    }
    check_followers(robot);
    if (!softened_.empty()) note("soft limits of safety controllers narrow the ranges of joints: " + softened_);
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
  std::map<std::string, std::string> follows_;  // joint → the one that it mimics
  std::string softened_;                        // joints
  UrdfDocument result_;
};

}  // namespace

UrdfDocument read_urdf_document(const std::string& path, SourceFiles& sources, const XacroOptions& xacro) {
  return UrdfChecker(path, sources, xacro).checked();
}

}  // namespace hecaton::planner
