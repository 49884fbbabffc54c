#include "services/config/robot_catalogue.hpp"

#include <algorithm>
#include <cstdlib>

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

/// Nothing when the catalogue has no poses for this chain.
const RobotTool* tool_of_chain(const NamedRobot& robot, const std::string& link, int joints) {
  const auto fits = [&](const RobotTool& tool) { return static_cast<int>(tool.poses.at("home").size()) == joints; };
  const auto named =
      std::find_if(robot.tools.begin(), robot.tools.end(), [&](const RobotTool& tool) { return tool.link == link; });
  if (named != robot.tools.end()) return fits(*named) ? &*named : nullptr;
  // Another link of the only arm, such as its last moving link.
  return robot.tools.size() == 1 && fits(robot.tools.front()) ? &robot.tools.front() : nullptr;
}

planner::JointVector joint_vector(const std::vector<double>& numbers) {
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
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
  if (const RobotTool* tool = tool_of_chain(robot, options.tool_link, model->joints())) {
    for (const auto& [name, pose] : tool->poses) model->named.try_emplace(name, joint_vector(pose));
    model->limits.acceleration = joint_vector(robot.acceleration);
  }
  std::string note = "approximate: " + robot.approximate.front();
  for (std::size_t i = 1; i < robot.approximate.size(); ++i) note += "; " + robot.approximate[i];
  model->notes.push_back(std::move(note));
  return model;
}

}  // namespace hecaton::config
