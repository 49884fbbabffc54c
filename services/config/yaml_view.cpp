#include "services/config/yaml_view.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

// One line of flow style, cut once it is longer than messages show.
void append_flow(const YamlNode& node, std::string& text) {
  constexpr std::size_t kEnough = 200;
  const bool map = node.kind == YamlNode::Kind::kMap;
  switch (node.kind) {
    case YamlNode::Kind::kEmpty:
      text += "(empty)";
      return;
    case YamlNode::Kind::kScalar:
      text += node.quoted || node.text.empty() ? "\"" + node.text + "\"" : node.text;
      return;
    case YamlNode::Kind::kSequence:
    case YamlNode::Kind::kMap:
      break;
  }
  text += map ? '{' : '[';
  for (std::size_t i = 0; i < node.items.size() && text.size() < kEnough; ++i) {
    if (i > 0) text += ", ";
    if (map) text += node.keys[i] + ": ";
    append_flow(node.items[i], text);
  }
  text += map ? '}' : ']';
}

std::string child_path(const std::string& path, std::string_view key) {
  return path.empty() ? printable(key) : path + "." + printable(key);
}

}  // namespace

YamlView::YamlView(const YamlNode& node, const YamlSource& file, std::string path)
    : node_(&node), file_(&file), path_(std::move(path)) {}

std::string YamlView::value() const {
  std::string text;
  append_flow(*node_, text);
  return printable(text);
}

void YamlView::fail(const std::string& must_be) const {
  throw ConfigError(file_->path + ": " + (path_.empty() ? "the file" : path_) + " = " + value() + " must be " +
                    must_be);
}

void YamlView::fail_with(const std::string& says) const {
  throw ConfigError(file_->path + ": " + (path_.empty() ? "" : path_ + ": ") + says);
}

const std::string& YamlView::scalar(const std::string& must_be) const {
  if (node_->kind != YamlNode::Kind::kScalar) fail(must_be);
  return node_->text;
}

double YamlView::number(const Bounds& bounds) const {
  const auto value = parsed_number("a number " + bounds.text());
  if (!std::isfinite(value)) fail("a finite number, " + bounds.text());
  if (!bounds.allow(value)) fail(bounds.text());
  return value;
}

double YamlView::number() const {
  return parsed_number("a number");
}

double YamlView::parsed_number(const std::string& must_be) const {
  const std::string& text = scalar(must_be);
  const auto value = node_->quoted ? std::nullopt : parse_number(text);
  if (!value) fail(must_be);
  return *value;
}

int YamlView::integer(int low, int high) const {
  const std::string must_be = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const std::string& text = scalar(must_be);
  const auto value = node_->quoted ? std::nullopt : parse_number(text);
  if (!value || !(*value >= low && *value <= high) || *value != std::floor(*value)) fail(must_be);
  return static_cast<int>(*value);
}

bool YamlView::boolean() const {
  const std::string& text = scalar("true or false");
  if (node_->quoted || (text != "true" && text != "false")) fail("true or false");
  return text == "true";
}

double YamlView::seconds(const Bounds& bounds) const {
  const double value = seconds();
  if (!std::isfinite(value)) fail("a finite duration, " + bounds.text());
  if (!bounds.allow(value)) fail(bounds.text());
  return value;
}

double YamlView::seconds() const {
  const std::string must_be = "a duration with its unit (" + std::string(kDurationUnits) + "), such as 20ms";
  const auto value = parse_duration(scalar(must_be));
  if (!value) fail(must_be);
  return *value;
}

std::string YamlView::text() const {
  const std::string& text = scalar("a text");
  if (text.empty() || text.find('\0') != std::string::npos) fail("a text that is not empty");
  return text;
}

std::string YamlView::name() const {
  const std::string rule(kNameRule);
  const std::string& text = scalar(rule);
  if (!is_name(text)) fail(rule);
  return text;
}

std::size_t YamlView::choice(std::span<const std::string_view> choices) const {
  const std::string& word = scalar(alternatives(choices));
  const auto found = std::find(choices.begin(), choices.end(), word);
  if (found == choices.end()) fail(alternatives(choices));
  return static_cast<std::size_t>(found - choices.begin());
}

std::vector<YamlView> YamlView::items(std::size_t least, std::size_t most, std::string_view of) const {
  const std::string count =
      least == most ? std::to_string(least) : std::to_string(least) + " to " + std::to_string(most);
  if (!is_sequence() || node_->items.size() < least || node_->items.size() > most) {
    fail("a list of " + count + " " + std::string(of));
  }
  std::vector<YamlView> views;
  for (std::size_t i = 0; i < node_->items.size(); ++i) {
    views.emplace_back(node_->items[i], *file_, path_ + "[" + std::to_string(i) + "]");
  }
  return views;
}

std::size_t YamlView::type(std::span<const std::string_view> choices) const {
  if (!is_map()) fail("a map with the key type (" + alternatives(choices) + ")");
  if (const auto type = child("type")) return type->choice(choices);
  throw ConfigError(file_->path + ": " + child_path(path_, "type") + " is missing, but must be " +
                    alternatives(choices));
}

std::optional<YamlView> YamlView::entry(std::string_view key) const {
  if (!is_map()) fail("a map with the key " + std::string(key));
  return child(key);
}

std::optional<YamlView> YamlView::child(std::string_view key) const {
  const auto found = std::find(node_->keys.begin(), node_->keys.end(), key);
  if (found == node_->keys.end()) return std::nullopt;
  return YamlView(node_->items[static_cast<std::size_t>(found - node_->keys.begin())], *file_, child_path(path_, key));
}

YamlView YamlView::at_path(std::string_view path) const {
  YamlView view = *this;
  while (!path.empty()) {
    const YamlNode& node = *view.node_;
    std::size_t child = node.items.size();
    std::string name;
    if (path.front() == '[') {
      const std::size_t end = std::min(path.find(']') + 1, path.size());
      const auto index = parse_number(path.substr(1, end - 2));
      name = view.path_ + std::string(path.substr(0, end));
      if (node.kind == YamlNode::Kind::kSequence && index) child = static_cast<std::size_t>(*index);
      path.remove_prefix(end);
    } else {
      const std::string_view key = path.substr(0, path.find_first_of(".["));
      name = child_path(view.path_, key);
      const auto found = std::find(node.keys.begin(), node.keys.end(), key);
      if (found != node.keys.end()) child = static_cast<std::size_t>(found - node.keys.begin());
      path.remove_prefix(key.size());
    }
    if (child >= node.items.size()) return view;
    view = YamlView(node.items[child], *file_, name);
    if (path.starts_with('.')) path.remove_prefix(1);
  }
  return view;
}

MapView YamlView::map(const Section& section) const {
  return {*this, section};
}

std::vector<std::pair<std::string, YamlView>> YamlView::named_items(std::size_t most) const {
  if (!is_map() || node_->items.size() > most) fail("a map of at most " + std::to_string(most) + " names");
  std::vector<std::pair<std::string, YamlView>> entries;
  for (std::size_t i = 0; i < node_->items.size(); ++i) {
    if (!is_name(node_->keys[i])) {
      fail_with("the key '" + printable(node_->keys[i]) + "' must be " + std::string(kNameRule));
    }
    entries.emplace_back(node_->keys[i], YamlView(node_->items[i], *file_, child_path(path_, node_->keys[i])));
  }
  return entries;
}

MapView::MapView(const YamlView& view, const Section& section) : view_(view), section_(&section) {
  if (!view.is_map()) view.fail("a map with the keys " + alternatives(section.keys));
  for (const std::string& key : view.node_->keys) {
    if (std::find(section.keys.begin(), section.keys.end(), key) != section.keys.end()) continue;
    throw ConfigError(view.file() + ": " + child_path(view.path(), key) + " is not a known key; did you mean '" +
                      std::string(nearest_word(key, section.keys)) + "'? Allowed are " + listed(section.keys));
  }
}

std::optional<YamlView> MapView::find(std::string_view key) const {
  if (std::find(section_->keys.begin(), section_->keys.end(), key) == section_->keys.end()) {
    throw std::logic_error("key '" + std::string(key) + "' is missing in the schema's section " +
                           std::string(section_->where));
  }
  return view_.child(key);
}

YamlView MapView::at(std::string_view key) const {
  if (const auto found = find(key)) return *found;
  fail_missing(key, "given");
}

void MapView::fail(std::string_view key, const std::string& value, const std::string& must_be) const {
  throw ConfigError(view_.file() + ": " + child_path(view_.path(), key) + " = " + value + " must be " + must_be);
}

void MapView::fail_missing(std::string_view key, const std::string& must_be) const {
  throw ConfigError(view_.file() + ": " + child_path(view_.path(), key) + " is missing, but must be " + must_be);
}

void read_number(const MapView& map, std::string_view key, double& out) {
  if (const auto view = map.find(key)) out = view->number();
}

void read_number(const MapView& map, std::string_view key, const Bounds& bounds, double& out) {
  if (const auto view = map.find(key)) out = view->number(bounds);
}

void read_seconds(const MapView& map, std::string_view key, const Bounds& bounds, double& out) {
  if (const auto view = map.find(key)) out = view->seconds(bounds);
}

void read_boolean(const MapView& map, std::string_view key, bool& out) {
  if (const auto view = map.find(key)) out = view->boolean();
}

Eigen::Vector3d read_vector(const YamlView& view, const Bounds& bounds, std::string_view of) {
  Eigen::Vector3d vector;
  int i = 0;
  for (const YamlView& item : view.items(3, 3, of)) vector[i++] = item.number(bounds);
  return vector;
}

Eigen::Vector3d read_vector(const YamlView& view, std::string_view of) {
  Eigen::Vector3d vector;
  int i = 0;
  for (const YamlView& item : view.items(3, 3, of)) vector[i++] = item.number();
  return vector;
}

Eigen::Vector3d read_direction(const YamlView& view) {
  const Eigen::Vector3d vector = read_vector(view, {-1e3, 1e3}, "numbers [x, y, z]");
  if (vector.norm() < 1e-6) view.fail("a direction, not the zero vector");
  return vector.normalized();
}

world::Pose read_pose(const YamlView& view) {
  const MapView map = view.map(section::kPose);
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  if (const auto value = map.find("xyz")) xyz = read_vector(*value, kCoordinate, "numbers [x, y, z] in m");
  if (const auto value = map.find("rpy")) rpy = read_vector(*value, kAngle, "numbers [roll, pitch, yaw] in rad");
  return world::pose_from_xyz_rpy(xyz, rpy);
}

world::Pose read_pose(const MapView& map, std::string_view key) {
  const auto view = map.find(key);
  return view ? read_pose(*view) : world::Pose::Identity();
}

std::string beside(const std::string& cell_file, const std::string& relative) {
  return (std::filesystem::path(cell_file).parent_path() / relative).lexically_normal().string();
}

}  // namespace hecaton::config
