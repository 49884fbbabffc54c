#include "services/ros2/ros2_service.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "services/client/connection.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/security/ros2_enclave.hpp"

namespace hecaton::ros2 {
namespace {

using namespace std::chrono_literals;

constexpr auto kLoopPeriod = 10ms;
constexpr std::uint64_t kMarkerTicks = kMarkerPeriod / kLoopPeriod;
constexpr std::uint64_t kStatusTicks = kStatusPeriod / kLoopPeriod;

bus::Participant ros_participant(const config::CellFile& file) {
  const std::string& folder = file.ros2->enclave;
  services::Ros2Enclave enclave{"/", {}, {}};
  if (!folder.empty()) enclave = services::read_ros2_enclave(folder);
  bus::ParticipantOptions options = bus::ros2::participant_options(enclave.name);
  options.interfaces = services::interface_addresses(file, "ros2.interface", file.ros2->interface);
  if (!folder.empty()) {
    options.identity = std::filesystem::absolute(folder);
    options.identity_expires = enclave.expires;
    options.revocations = enclave.revocations;
  }
  return {file.ros2->domain, enclave.name, options};
}

std::shared_ptr<client::Connection> connect(const config::CellFile& file, const services::ServiceOptions& options) {
  return client::Connection::make(client::join(file, services::choose_domain(options, file.network.domain)));
}

std::uint64_t ticks_of(double period) {
  const std::chrono::duration<double> loop = kLoopPeriod;
  return static_cast<std::uint64_t>(std::max(1L, std::lround(period / loop.count())));
}

std::optional<Control> control_of(const config::CellFile& file, bus::Participant& participant,
                                  const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox,
                                  const std::string& checkpoint) {
  if (!file.ros2->control) return std::nullopt;
  return std::optional<Control>(std::in_place, participant, file, connection, mailbox, checkpoint);
}

NodeEndpoints endpoints_of(const CellPublisher& publisher, const NameWatch& names,
                           const std::optional<Control>& control) {
  NodeEndpoints endpoints = control ? control->endpoints() : NodeEndpoints{};
  endpoints.readers.push_back(names.id());
  const auto writers = publisher.writers();
  endpoints.writers.insert(endpoints.writers.end(), writers.begin(), writers.end());
  return endpoints;
}

std::optional<NodeGraph> graph_of(const config::Ros2& ros2, bus::Participant& participant, NodeEndpoints endpoints,
                                  bus::Mailbox& mailbox) {
  if (!ros2.distribution) return std::nullopt;
  const NodeGraph::Node node{ros2.ns.empty() ? "/" : ros2.ns, "hecaton"};
  return std::optional<NodeGraph>(std::in_place, participant, *ros2.distribution, node, std::move(endpoints), mailbox);
}

}  // namespace

Ros2Service::Ros2Service(const config::CellFile& file, const services::ServiceOptions& options,
                         const services::ShutdownSignal& shutdown)
    : file_(file),
      participant_(
          services::make_participant(file, options, services::Role::kViewer, services::ros2_node(), &mailbox_)),
      ros_participant_(ros_participant(file)),
      modes_(participant_, &mailbox_),
      heartbeat_(
          participant_,
          {services::ros2_node(), msg::NodeKind::NODE_OTHER, "", options.host.empty() ? file.ros2->host : options.host},
          services::heartbeat_timing(file, options)),
      loop_(kLoopPeriod, shutdown),
      cell_(file, participant_, mailbox_),
      connection_(connect(file, options)),
      publisher_(file, ros_participant_),
      names_(ros_participant_, file.ros2->ns, ros_mailbox_),
      control_(control_of(file, ros_participant_, connection_, ros_mailbox_, options.checkpoint)),
      graph_(graph_of(*file.ros2, ros_participant_, endpoints_of(publisher_, names_, control_), ros_mailbox_)),
      status_(Cell(connection_)) {}

void Ros2Service::run() {
  services::log_info("ros2 started", {{"ros_domain", file_.ros2->domain},
                                      {"namespace", file_.ros2->ns},
                                      {"control", file_.ros2->control},
                                      {"enclave", file_.ros2->enclave}});
  publisher_.publish_descriptions();
  while (loop_.next()) {
    for (const bus::Event& event : mailbox_.take_events()) planners_.note(event);
    modes_.update();
    if (heartbeat_.due(loop_.now(), loop_.period() / 2)) publish_heartbeat();
    if (participant_.recovering()) continue;
    cell_.update(publisher_.shows_plans());
    if (control_) control_->update(cell_.view(), modes_.view(), planners_, loop_.now());
    publish(loop_.now());
    look_at_graph(loop_.now());
    look_at_names(loop_.now());
    ++ticks_;
  }
  services::log_info("ros2 shuts down");
}

void Ros2Service::publish(Clock::time_point now) {
  if (ticks_ % ticks_of(file_.ros2->period) == 0) publisher_.publish_states(cell_.view(), now);
  if (ticks_ % kMarkerTicks == 0)
    publisher_.publish_markers(cell_.view(), control_ ? control_->paths() : std::vector<OrderedPath>());
  if (ticks_ % kStatusTicks == 0) publisher_.publish_arm_status(cell_.view(), now);
  const StatusPoller::Answer status = status_.newest();
  if (status.number == told_status_) return;
  told_status_ = status.number;
  publisher_.publish_diagnostics(status.status.get(), status.problem,
                                 control_ ? control_->reports() : std::vector<OrderReport>());
}

void Ros2Service::look_at_graph(Clock::time_point now) {
  if (!graph_) return;
  const bool conflicting = graph_->conflicting();
  graph_->update(now);
  if (conflicting || !graph_->conflicting()) return;
  services::log_warning("node name not announced: nodes of another distribution of ROS 2 are in the domain",
                        {{"ros_domain", file_.ros2->domain}, {"what_to_do", "correct ros2.distribution"}});
}

void Ros2Service::look_at_names(Clock::time_point now) {
  if (!names_.update(now)) return;
  services::log_warning(
      "another node publishes under the same names",
      {{"topic", file_.ros2->ns + "/robot_description"},
       {"ros_domain", file_.ros2->domain},
       {"what_to_do",
        "set ros2.namespace or ros2.domain: a second cell of these names would carry out the same orders"}});
}

void Ros2Service::publish_heartbeat() {
  services::HealthReport report;
  report.term = modes_.view().term();
  heartbeat_.publish(loop_.now(), report, loop_.statistics());
}

}  // namespace hecaton::ros2
