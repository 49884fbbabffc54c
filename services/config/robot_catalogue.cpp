#include "services/config/robot_catalogue.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include <dlfcn.h>
#include <link.h>

#include "planner/collision/model_filter.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolderOfPackage = "/usr/share/hecaton/robots";
constexpr std::size_t kMostTools = 16;
constexpr std::size_t kMostPoses = 64;
constexpr std::size_t kMostSentences = 32;

const Section kRobot{"robot", {"title", "reach", "payload", "tools", "acceleration", "sources", "approximate"}};

/// The program or shared library that has this code: a client library and the Python module run in other programs.
fs::path own_file() {
  Dl_info ignored{};
  void* map = nullptr;
  if (dladdr1(&kFolderOfPackage, &ignored, &map, RTLD_DL_LINKMAP) != 0 && map != nullptr) {
    const char* const library = static_cast<const link_map*>(map)->l_name;  // empty for the program
    if (library != nullptr && *library != '\0') return library;
  }
  return "/proc/self/exe";
}

/// A prefix has programs in bin, and the Python package in lib/python3/dist-packages/hecaton.
constexpr int kMostFoldersAbove = 5;

std::string entry_path(std::string_view name) {
  return (robots_folder() / (std::string(name) + ".yaml")).string();
}

std::vector<double> read_numbers(const YamlView& view, const Bounds& bounds) {
  std::vector<double> numbers;
  for (const YamlView& item : view.items(1, planner::kMaxJoints, "numbers, one for each joint")) {
    numbers.push_back(item.number(bounds));
  }
  return numbers;
}

std::vector<std::string> read_sentences(const YamlView& view) {
  std::vector<std::string> sentences;
  for (const YamlView& item : view.items(1, kMostSentences, "sentences")) sentences.push_back(item.text());
  return sentences;
}

std::vector<RobotTool> read_tools(const YamlView& view) {
  std::vector<RobotTool> tools;
  for (const auto& [link, poses] : view.named_items(kMostTools)) {
    RobotTool& tool = tools.emplace_back();
    tool.link = link;
    for (const auto& [name, numbers] : poses.named_items(kMostPoses)) {
      tool.poses[name] = read_numbers(numbers, {-1e6, 1e6, "rad (m for a prismatic joint)"});
    }
    if (!tool.poses.contains("home")) poses.fail("a map of poses with home");
  }
  if (tools.empty()) view.fail("a map with a tool link at least");
  return tools;
}

/// For each joint of `model` its place among all joints to the tool, in which the catalogue's lists are: a chain may
/// begin above the first of them, such as that of a rail, or end before the last. Empty: a joint is not among them.
std::vector<std::size_t> places_of_joints(const planner::RobotModel& model, const NamedRobot& robot,
                                          const RobotTool& tool, const planner::UrdfOptions& options) {
  planner::UrdfOptions whole;
  whole.sources = options.sources;
  whole.tool_link = tool.link;
  const bool is_whole = options.base_link.empty() && options.tool_link == tool.link;
  const std::vector<std::string> all =
      is_whole ? model.joint_names : planner::load_arm_model(robot.urdf, whole)->joint_names;
  if (all.size() != robot.acceleration.size() || all.size() != tool.poses.at("home").size()) return {};
  std::vector<std::size_t> places;
  for (const std::string& joint : model.joint_names) {
    const auto found = std::find(all.begin(), all.end(), joint);
    if (found == all.end()) return {};
    places.push_back(static_cast<std::size_t>(found - all.begin()));
  }
  return places;
}

/// A tool of the catalogue with the places of the arm's joints in its lists.
struct KnownChain {
  const RobotTool* tool;
  std::vector<std::size_t> places;
};

/// The tool that has the arm's link, otherwise the first that moves all joints of the arm; nothing: there is none.
std::optional<KnownChain> known_chain(const planner::RobotModel& model, const NamedRobot& robot,
                                      const planner::UrdfOptions& options) {
  std::optional<KnownChain> known;
  for (const RobotTool& tool : robot.tools) {
    const bool is_named = tool.link == options.tool_link;
    if (known && !is_named) continue;
    std::vector<std::size_t> places = places_of_joints(model, robot, tool, options);
    if (!places.empty()) known = KnownChain{&tool, std::move(places)};
  }
  return known;
}

planner::JointVector at_places(const std::vector<double>& numbers, const std::vector<std::size_t>& places) {
  planner::JointVector chosen(static_cast<Eigen::Index>(places.size()));
  for (std::size_t j = 0; j < places.size(); ++j) chosen[static_cast<Eigen::Index>(j)] = numbers.at(places[j]);
  return chosen;
}

}  // namespace

fs::path robots_folder() {
  if (const char* chosen = std::getenv("HECATON_ROBOTS")) return chosen;
  std::error_code ignored;
  fs::path prefix = fs::canonical(own_file(), ignored).parent_path();
  for (int i = 1; i <= kMostFoldersAbove && prefix.has_relative_path(); ++i, prefix = prefix.parent_path()) {
    const fs::path beside = fs::canonical(prefix / "share/hecaton/robots", ignored);
    if (fs::is_directory(beside, ignored)) return beside;
  }
  return kFolderOfPackage;
}

std::vector<std::string> robot_names() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(robots_folder(), ignored)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool is_robot_name(std::string_view name, const planner::SourceFiles& sources) {
  std::error_code ignored;
  return is_name(name) && fs::is_regular_file(sources.place(entry_path(name)), ignored);
}

bool means_robot(const std::string& word) {
  std::error_code ignored;
  return is_robot_name(word) && (!fs::exists(word, ignored) || fs::is_directory(word, ignored));
}

std::string robot_suggestion(std::string_view name) {
  const std::vector<std::string> names = robot_names();
  if (names.empty())
    return "there are no robots in " + robots_folder().string() + "; set HECATON_ROBOTS to their folder";
  const std::vector<std::string_view> words(names.begin(), names.end());
  return suggestion(name, words);
}

NamedRobot read_named_robot(const std::string& name, planner::SourceFiles& sources) {
  if (!is_robot_name(name, sources)) {
    throw ConfigError("'" + printable(name) + "' is no robot: " + robot_suggestion(name));
  }
  const std::string path = entry_path(name);
  const YamlNode tree = read_yaml_file(path, sources);
  const YamlSource source{path, sources};
  const MapView map = YamlView(tree, source, "").map(kRobot);
  NamedRobot robot;
  robot.name = name;
  robot.title = map.at("title").text();
  robot.urdf = beside(path, name + ".urdf");
  robot.reach = map.at("reach").number(kLength);
  robot.payload = map.at("payload").number({0.0, 1e4, "kg", true});
  robot.tools = read_tools(map.at("tools"));
  robot.acceleration = read_numbers(map.at("acceleration"), {0.0, 1e5, "rad/s² (m/s² for a prismatic joint)", true});
  const std::size_t joints = robot.tools.front().poses.at("home").size();
  if (robot.acceleration.size() != joints) {
    map.at("acceleration").fail("a list of " + std::to_string(joints) + " numbers, one for each joint of home");
  }
  robot.sources = read_sentences(map.at("sources"));
  robot.approximate = read_sentences(map.at("approximate"));
  return robot;
}

std::vector<RobotTool> tools_of(const std::string& word) {
  if (!means_robot(word)) return {};
  planner::SourceFiles sources;
  return read_named_robot(word, sources).tools;
}

std::shared_ptr<const planner::RobotModel> load_named_robot(const NamedRobot& robot, planner::UrdfOptions options) {
  if (options.tool_link.empty()) options.tool_link = robot.tools.front().link;
  const auto model = std::make_shared<planner::RobotModel>(*planner::load_arm_model(robot.urdf, options));
  if (const auto known = known_chain(*model, robot, options)) {
    for (const auto& [name, pose] : known->tool->poses) {
      if (pose.size() == robot.acceleration.size()) model->named.try_emplace(name, at_places(pose, known->places));
    }
    model->limits.acceleration = at_places(robot.acceleration, known->places);
  } else {
    model->notes.push_back("the catalogue has no accelerations for the joints to link '" +
                           printable(options.tool_link) + "': every joint is assumed to reach its velocity limit in " +
                           number_text(planner::kAssumedRunUp) + " s");
  }
  std::string note = "approximate: " + robot.approximate.front();
  for (std::size_t i = 1; i < robot.approximate.size(); ++i) note += "; " + robot.approximate[i];
  model->notes.push_back(std::move(note));
  return model;
}

}  // namespace hecaton::config
