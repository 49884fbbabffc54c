#include "services/view/foxglove/cell_server.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "services/ros2_messages/cell_description.hpp"
#include "services/ros2_messages/schema.hpp"
#include "services/ros2_messages/time.hpp"

namespace hecaton::services::foxglove {
namespace {

using namespace std::chrono_literals;

constexpr auto kTimePeriod = 50ms;

constexpr std::uintmax_t kLargestAsset = std::uintmax_t{64} << 20;  // [byte]
constexpr std::string_view kAssets = "package://hecaton/";          // before the path of a mesh on the page's server

std::uint64_t unix_ns() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(since).count());
}

std::shared_ptr<const std::string> asset(const view::Drawings& drawings, std::string_view uri) {
  auto file = uri.starts_with(kAssets) ? drawings.mesh(uri.substr(kAssets.size() - 1)) : drawings.mesh_named(uri);
  std::error_code error;
  if (!file || !std::filesystem::is_regular_file(*file, error)) return nullptr;
  const auto size = std::filesystem::file_size(*file, error);
  if (error || size > kLargestAsset) return nullptr;
  std::ifstream stream(*file, std::ios::binary);
  if (!stream) return nullptr;
  auto content = std::make_shared<std::string>(static_cast<std::size_t>(size), '\0');
  stream.read(content->data(), static_cast<std::streamsize>(size));
  content->resize(static_cast<std::size_t>(stream.gcount()));
  return content;
}

/// The URDF of the page with mesh files that clients fetch as assets, or the collision shapes.
std::string description(const planner::Arm& arm, const view::ArmDrawing& drawing) {
  if (!drawing.has_visuals) return ros2::arm_urdf(arm);
  std::string text = drawing.urdf;
  for (const std::string quote : {"\"", "'"}) {
    const std::string from = quote + "/meshes/";
    const std::string to = quote + std::string(kAssets) + "meshes/";
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
      text.replace(at, from.size(), to);
    }
  }
  return text;
}

void add_parameter(Json& list, const std::string& name, Json value, const char* type = nullptr) {
  Json parameter{{"name", name}, {"value", std::move(value)}};
  if (type != nullptr) parameter["type"] = type;
  list.push_back(std::move(parameter));
}

/// A list of numbers has none that JSON lacks.
void add_numbers(Json& list, const std::string& name, const planner::JointVector& values) {
  if (!values.allFinite()) return;
  add_parameter(list, name, std::vector<double>(values.begin(), values.end()), "float64_array");
}

Json parameters_of(const config::CellFile& file) {
  Json list = Json::array();
  add_parameter(list, "cell.name", file.cell.name);
  add_parameter(list, "cell.domain", file.network.domain);
  Json arms = Json::array();
  for (const planner::PlannedArm& planned : file.cell.arms) arms.push_back(planned.arm.name);
  add_parameter(list, "cell.arms", std::move(arms));
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const planner::Arm& arm = file.cell.arms[i].arm;
    add_parameter(list, arm.name + ".robot", arm.model->name);
    add_parameter(list, arm.name + ".device", file.devices[i].type);
    add_parameter(list, arm.name + ".joints", arm.model->joint_names);
    add_numbers(list, arm.name + ".lower", arm.limits.lower);
    add_numbers(list, arm.name + ".upper", arm.limits.upper);
    add_numbers(list, arm.name + ".velocity", arm.limits.velocity);
    add_numbers(list, arm.name + ".home", arm.home());
  }
  return list;
}

/// http://NAME or https://NAME, with or without a port.
bool is_page_of(std::string_view origin, std::string_view name) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    const std::string_view rest = origin.substr(scheme.size());
    if (!rest.starts_with(name)) return false;
    const std::string_view port = rest.substr(name.size());
    return port.empty() || (port[0] == ':' && port.size() > 1 && port.find_first_not_of("0123456789", 1) == port.npos);
  }
  return false;
}

std::string ns_of(const config::CellFile& file) {
  return file.ros2 ? file.ros2->ns : std::string();
}

bus::Clock::duration state_period(const config::CellFile& file) {
  const double period = file.ros2.value_or(config::Ros2{}).period;
  return std::chrono::duration_cast<bus::Clock::duration>(std::chrono::duration<double>(period));
}

}  // namespace

bool is_allowed_origin(std::string_view origin, const std::vector<std::string>& further) {
  if (origin == "https://app.foxglove.dev" || origin == "file://") return true;
  if (is_page_of(origin, "localhost") || is_page_of(origin, "127.0.0.1")) return true;
  return std::find(further.begin(), further.end(), origin) != further.end();
}

CellServer::CellServer(const CellFeed& feed, const config::CellFile& file, const view::Drawings& drawings,
                       CellServerOptions options)
    : feed_(feed),
      file_(file),
      drawings_(drawings),
      origins_(std::move(options.origins)),
      hub_(std::make_shared<Hub>(hub_options(file, drawings, std::move(options.orders)))),
      scene_(file) {
  send_fixed();
}

HubOptions CellServer::hub_options(const config::CellFile& file, const view::Drawings& drawings, OrderReceiver orders) {
  HubOptions options;
  // Clients take the notation and the names of types for those of this release of ROS 2.
  const bool humble = file.ros2 && file.ros2->distribution == config::Ros2Distribution::kHumble;
  options.info.name = "Hecaton cell " + file.cell.name;
  options.info.metadata = {{"ROS_DISTRO", humble ? "humble" : "jazzy"}};
  options.ns = ns_of(file);
  for (const Ros2Topic& topic : Ros2Topics::all(file)) {
    options.channels.push_back({topic.name, topic.type, ros2::message_definition(topic.type), topic.latched});
  }
  for (const planner::PlannedArm& planned : file.cell.arms) options.arms.push_back(planned.arm.name);
  options.parameters = parameters_of(file);
  options.asset = [&drawings](std::string_view uri) { return asset(drawings, uri); };
  options.orders = std::move(orders);
  return options;
}

WebProtocol CellServer::protocol() const {
  WebProtocol protocol;
  protocol.names.assign(std::begin(kSubprotocols), std::end(kSubprotocols));
  protocol.longest_message = kLongestMessage;
  protocol.allows = [origins = origins_](std::string_view origin) { return is_allowed_origin(origin, origins); };
  protocol.open = [hub = hub_](WebOpening opening) { return hub->open(std::move(opening)); };
  return protocol;
}

template <class Message>
void CellServer::send(std::size_t channel, const Message& message) {
  ros2::encode(message, bytes_);
  hub_->publish(channel, unix_ns(), std::string(bytes_.begin(), bytes_.end()));
}

void CellServer::send_fixed() {
  send(Ros2Topics::kDescription, ros2::String{ros2::cell_urdf(file_.cell)});
  for (std::size_t i = 0; i < file_.cell.arms.size(); ++i) {
    send(Ros2Topics::of_arm(i, Ros2Topics::kArmDescription),
         ros2::String{description(file_.cell.arms[i].arm, drawings_.arms()[i])});
  }
  send(Ros2Topics::kFixedTransforms,
       ros2::fixed_transforms(file_.cell, ros2::ros_time(std::chrono::system_clock::now())));
}

bool CellServer::due(std::size_t timer, bus::Clock::time_point now, bus::Clock::duration period) {
  if (now < due_[timer]) return false;
  due_[timer] = std::max(due_[timer] + period, now);
  return true;
}

void CellServer::publish(bus::Clock::time_point now) {
  hub_->deliver_answers();
  if (hub_->clients() == 0) return;
  scene_.update_states(feed_.state());
  if (due(0, now, kTimePeriod)) hub_->publish_time(unix_ns());
  if (due(1, now, state_period(file_))) send_states(feed_.now());
  if (due(2, now, ros2::kMarkerPeriod)) send_markers();
  if (due(3, now, ros2::kStatusPeriod)) {
    for (std::size_t i = 0; i < scene_.view().size(); ++i) {
      const std::size_t channel = Ros2Topics::of_arm(i, Ros2Topics::kArmStatus);
      if (hub_->wanted(channel)) send(channel, ros2::status_of(scene_.view().arm(i), feed_.now()));
    }
  }
  if (due(4, now, ros2::kDiagnosticsPeriod) && hub_->wanted(Ros2Topics::kDiagnostics)) send_diagnostics();
}

void CellServer::send_states(bus::Clock::time_point now) {
  if (hub_->wanted(Ros2Topics::kJointStates)) {
    const ros2::JointState all = ros2::joint_states(scene_.view(), now);
    if (!all.name.empty()) send(Ros2Topics::kJointStates, all);
  }
  if (hub_->wanted(Ros2Topics::kTransforms)) {
    const ros2::TFMessage moving = ros2::moving_transforms(scene_.view(), now);
    if (!moving.transforms.empty()) send(Ros2Topics::kTransforms, moving);
  }
  for (std::size_t i = 0; i < scene_.view().size(); ++i) {
    const std::size_t channel = Ros2Topics::of_arm(i, Ros2Topics::kArmJointStates);
    if (hub_->wanted(channel) && ros2::is_shown(scene_.view().arm(i), now))
      send(channel, ros2::joint_state(scene_.view().arm(i)));
  }
}

void CellServer::send_markers() {
  std::array<bool, ros2::CellMarkers::kNames.size()> wanted{};
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = hub_->wanted(Ros2Topics::kMarkers + i);
  if (std::none_of(wanted.begin(), wanted.end(), [](bool one) { return one; })) return;
  scene_.update_markers(feed_.state(), ros2::ros_time(std::chrono::system_clock::now()));
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i]) send(Ros2Topics::kMarkers + i, scene_.markers().message(i));
  }
}

void CellServer::send_diagnostics() {
  send(Ros2Topics::kDiagnostics,
       scene_.diagnostics(feed_.state(), feed_.now(), ros2::ros_time(std::chrono::system_clock::now())));
}

}  // namespace hecaton::services::foxglove
